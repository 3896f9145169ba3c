"""Names of motors, days and runs, as folders and files of any store can have them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import UTC, date, datetime, timedelta

from gen.errors import InputError

_MOTOR = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._-]{0,62}[A-Za-z0-9_-])?", re.ASCII)
_DAY = re.compile(r"\d{4}-\d{2}-\d{2}", re.ASCII)
_LONGEST_STEM = 80
STARTED = "started"
"""Key of the comment in which a run says when its time was 0."""
_HASH = r"[0-9a-f]{16}"
_KEPT = re.compile(rf"(?P<stem>.*?)(?:-(?P<began>\d{{8}}T\d{{6}}))?-{_HASH}", re.ASCII)


def checked_motor(name: str) -> str:
    """Give a motor's name back if it can name a folder.

    Raises
    ------
    InputError
        If it has anything but letters, digits, ``.``, ``_`` and ``-``, or could lead out of its place.
    """
    if _MOTOR.fullmatch(name) is None or ".." in name:
        raise InputError(
            f"found {shown(name)}, expected 1 to 64 letters, digits, '.', '_' and '-', a letter or digit first, "
            "no '.' last, no '..'",
            place="--motor",
        )
    return name


def checked_day(text: str) -> str:
    """Give a day back if it is one of the calendar, as ``YYYY-MM-DD``.

    Raises
    ------
    InputError
        If it is none.
    """
    try:
        if _DAY.fullmatch(text) is None:
            raise ValueError
        date.fromisoformat(text)
    except ValueError:
        raise InputError(f"found {shown(text)}, expected a day as YYYY-MM-DD", place="--day") from None
    return text


def said_day(comments: Mapping[str, str], first_s: float) -> str | None:
    """Give the day of a run's first row by its own comment, or None; `first_s` is that row's time, s."""
    at = _began(comments, first_s)
    try:
        return checked_day(comments.get(STARTED, "")[:10] if at is None else at.date().isoformat())
    except InputError:
        return None


def said_beginning(comments: Mapping[str, str], first_s: float) -> str:
    """Give the instant of a run's first row by its own comment, as `YYYYMMDDTHHMMSS`; may be empty.

    It is in UTC, where the comment says how far it is from that; one that does not is taken as it is.
    """
    at = _began(comments, first_s)
    if at is None:
        return ""
    try:
        plain = at if at.tzinfo is None else at.astimezone(UTC)
    except OverflowError:
        return ""
    return re.sub("[-:]", "", plain.replace(tzinfo=None).isoformat(timespec="seconds"))


def _began(comments: Mapping[str, str], first_s: float) -> datetime | None:
    """None also where a day stands alone: that says no order of the runs of one."""
    text = comments.get(STARTED, "")
    try:
        return datetime.fromisoformat(text) + timedelta(seconds=first_s) if "T" in text or " " in text else None
    except (ValueError, OverflowError):
        return None


def kept_name(name: str, began: str, content: str) -> str:
    """Give the name of a run's file in the store, of its own file's name, when it began, and its content's hash."""
    return "-".join(filter(None, (stem_of(name), began, content)))


def in_time(day: str, kept: str) -> tuple[str, tuple[str | int, ...], str]:
    """Give what a motor's runs are sorted by, of a run's day and the name of its file in the store.

    It is the instant at which it began; the day where its name does not say that, and there the natural order of names:
    run2 before run10.
    """
    found = _KEPT.fullmatch(kept)
    stem, began = (kept, None) if found is None else (found["stem"], found["began"])
    parts = re.split(r"([0-9]+)", stem)
    natural = tuple(int(part) if place % 2 else part for place, part in enumerate(parts))
    return began or day.replace("-", ""), natural, kept


def stem_of(name: str) -> str:
    """Give a run's name with what a file of any store can have; never empty."""
    kept = re.sub(r"[^A-Za-z0-9._-]+", "_", name).strip("._-")
    return kept[:_LONGEST_STEM].rstrip("._-") or "run"


def shown(text: str) -> str:
    """Quote what a user wrote, not more than a line of it."""
    return repr(text if len(text) <= 80 else f"{text[:76]}...")
