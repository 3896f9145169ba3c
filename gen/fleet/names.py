"""Names of motors, days and runs, as folders and files of any store can have them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import date

from gen.errors import InputError

_MOTOR = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._-]{0,62}[A-Za-z0-9_-])?", re.ASCII)
_DAY = re.compile(r"\d{4}-\d{2}-\d{2}", re.ASCII)
_LONGEST_STEM = 80
STARTED = "started"
"""Key of the comment in which a run says when it began."""


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


def said_day(comments: Mapping[str, str]) -> str | None:
    """Give the day on which a run began by its own comment, or None."""
    text = comments.get(STARTED, "")[:10]
    try:
        return checked_day(text)
    except InputError:
        return None


def stem_of(name: str) -> str:
    """Give a run's name with what a file of any store can have; never empty."""
    kept = re.sub(r"[^A-Za-z0-9._-]+", "_", name).strip("._-")
    return kept[:_LONGEST_STEM].rstrip("._-") or "run"


def shown(text: str) -> str:
    """Quote what a user wrote, not more than a line of it."""
    return repr(text if len(text) <= 80 else f"{text[:76]}...")
