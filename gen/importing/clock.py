"""Columns of times: instants, times of day, durations."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.importing.dates import (
    DAY_NS,
    DOTTED,
    MINUTES,
    duration,
    fraction,
    has_time,
    instant,
    plainly,
    says_seconds,
    stamp,
    time_of_day,
    zone_of,
)
from gen.importing.table import InstantArray

_MUCH_SHORTER = 0.2
"""A log of days that would be months is one of days."""
_SAMPLE = 2000
_SOUND = 0.95
"""Of a column of times, as others hold damaged lines."""
DAY_OR_YEAR = "the day first, or the year in two digits"
_YEAR_FIRST = "year first, or the month in letters"
ONE_DATE = "one date only"
EITHER = "dates that are possible either way"
"""Why an order of days and months is taken that nothing in the dates tells."""
_YEARS = (10, 40)
"""Of this century, from which there are logs, and until when this may be read."""
_NUMBER = re.compile(r"[+-]?\d*[.,]?\d*")
_ISO_MARKS = str.maketrans("", "", "0123456789-:.T \n")
MISSING = int(np.iinfo(np.int64).min)
"""What is no time."""
_FIRST_YEAR, _LAST_YEAR = "1700", "2200"
"""Between them nanoseconds since 1970 fit a word of 64 bits; no log was made before or after."""
_FIRST, _LAST = (int(np.datetime64(year, "ns").astype(np.int64)) for year in (_FIRST_YEAR, _LAST_YEAR))


def is_time(text: str) -> bool:
    """Whether a text is a date, a time of day or both; a number alone, or one with a unit, is none of them."""
    text = plainly(text)
    if ":" in text:
        return time_of_day(text) is not None or MINUTES.fullmatch(text) is not None or stamp(text) is not None
    if text.isdigit() or _plain(text) is not None:
        return False
    if DOTTED.fullmatch(text) or stamp(text) is not None:
        return True
    spelt = time_of_day(text)
    return spelt is not None and says_seconds(spelt)


def _plain(text: str) -> re.Match[str] | None:
    return _NUMBER.fullmatch(text)


def kind_of(cells: Sequence[str]) -> str:
    """What a column's texts are: "instant", "date", "clock" (time of day), "minutes" (mm:ss), or "" for none."""
    sample = [text for cell in cells[:_SAMPLE] if (text := plainly(cell))]
    if not sample:
        return ""

    def share(test: Sequence[bool]) -> bool:
        return sum(test) > 0.5 * len(sample)

    numbers = [_plain(text) is not None for text in sample]
    if share(numbers):
        return ""
    if share([bool(DOTTED.fullmatch(text)) for text in sample]) and _goes_on(cells):
        return "clock"
    stamps = [None if number else stamp(text) for text, number in zip(sample, numbers, strict=True)]
    if share([match is not None for match in stamps]):
        return "instant" if share([match is not None and has_time(match) for match in stamps]) else "date"
    clocks = [None if number else time_of_day(text) for text, number in zip(sample, numbers, strict=True)]
    of_seconds = [match is not None and says_seconds(match) for match in clocks]
    of_minutes = [bool(MINUTES.fullmatch(text)) for text in sample]
    if share([a or b for a, b in zip(of_seconds, of_minutes, strict=True)]) and _goes_over_to_hours(cells):
        return "minutes"
    if share(of_seconds):
        return "clock"
    return "minutes" if share(of_minutes) else ""


def _goes_over_to_hours(cells: Sequence[str]) -> bool:
    """Whether `59:50` is followed by `1:00:00`, as a stopwatch shows it.

    Times of day that leave out seconds of 0 (`10:15`, `10:15:30`) fall if they are read so.
    """
    parts = {cell.count(":") for cell in cells}
    return {1, 2} <= parts and _falls(minutes(cells)) < _falls(of_day(cells))


def _falls(ns: IntArray) -> int:
    return int((np.diff(ns[ns != MISSING]) < 0).sum())


def dotted(cells: Sequence[str]) -> bool:
    """Whether times of day are parted by points; the first that holds something tells.

    Parameters
    ----------
    cells
        Times of day.
    """
    return bool(DOTTED.fullmatch(next((cell.strip() for cell in cells if cell.strip()), "")))


def _goes_on(cells: Sequence[str]) -> bool:
    """Whether texts such as `10.02.33` are times of day that go on, a few damaged apart, and no dates of a few days.

    The last number of a date is the year, which a log of hours does not change; of a time it is the seconds.
    """
    filled = [text for cell in cells if (text := cell.strip())]
    ns = of_day(filled)
    sound = (ns != MISSING) & (ns < DAY_NS) & np.array([bool(DOTTED.fullmatch(text)) for text in filled], dtype=bool)
    if sound.sum() < _SOUND * sound.size:
        return False
    texts, ns = [text for text, good in zip(filled, sound, strict=True) if good], ns[sound]
    on, nights = over_midnight(ns)
    steps = np.diff(on)
    if (steps < 0).any() or not (steps > 0).any() or on[-1] - on[0] >= (nights + 1) * DAY_NS:
        return False
    found = [tuple(map(int, re.split("[.,]", text)[:3])) for text in texts]
    if any(not (_is_day(a, b) or _is_day(b, a)) for a, b, _ in found):
        return True
    years = {year for _, _, year in found}
    if len(years) == 1:
        return False
    dates = ([(year, b, a) for a, b, year in found], [(year, a, b) for a, b, year in found])
    return len(years) > 2 or not any(date == sorted(date) for date in dates)


def _is_day(day: int, month: int) -> bool:
    return 1 <= day <= 31 and 1 <= month <= 12


def date_order(cells: Sequence[str]) -> tuple[str, float, str]:
    """Whether day or month comes first in dates such as 3/4/2024.

    Parameters
    ----------
    cells
        Dates, with or without times.

    Returns
    -------
    order, confidence, why
        "ymd", "dmy" or "mdy".
    """
    if all(cell[4:5] == "-" and cell[:4].isdigit() for cell in cells):  # what nearly all programs write
        return "ymd", 1.0, _YEAR_FIRST
    stamps = [stamp(text) for text in {plainly(cell) for cell in cells}]
    found = {match.group("a", "mark", "b") for match in stamps if match and "a" in match.re.groupindex}
    if not found:
        return "ymd", 1.0, _YEAR_FIRST
    short = {
        (match["a"], match["b"], match["y"]) for match in stamps if match is not None and "a" in match.re.groupindex
    }
    if (order := _year_first(short, {mark for _, mark, _ in found})) is not None:
        return order
    if any(int(a) > 12 for a, _, _ in found):
        return "dmy", 0.99, "a first number above 12"
    if any(int(b) > 12 for _, _, b in found):
        return "mdy", 0.99, "a second number above 12"
    if {mark for _, mark, _ in found} == {"."}:
        return "dmy", 0.9, "parted by points"
    if len(found) == 1:
        return "mdy", 0.9, ONE_DATE
    lasting = {order: _lasting_s(cells, order) for order in ("mdy", "dmy")}
    shorter, longer = sorted(lasting, key=lambda order: lasting[order])
    if 0.0 < lasting[shorter] < _MUCH_SHORTER * lasting[longer]:
        days = (lasting[shorter] / 86_400.0, lasting[longer] / 86_400.0)
        return shorter, 0.9, f"it lasts {days[0]:.3g} d so, and {days[1]:.3g} d as {longer}"
    return "mdy", 0.4, EITHER


def _year_first(dates: set[tuple[str, str, str]], marks: set[str]) -> tuple[str, float, str] | None:
    """Whether two digits of the year stand first (`26-03-02`), or may; None where they do not."""
    if any(len(year) != 2 or int(month) > 12 or not 1 <= int(year) <= 31 for _, month, year in dates):
        return None
    firsts, lasts = ({int(date[k]) for date in dates} for k in (0, 2))
    if min(firsts) < _YEARS[0] or max(firsts) > _YEARS[1] or len(firsts) > len(lasts):
        return None
    if len(lasts) > len(firsts) or not _YEARS[0] <= min(lasts) <= max(lasts) <= _YEARS[1]:
        return "ymd", 0.9, "the year first, in two digits"
    return ("dmy", 0.4, DAY_OR_YEAR) if marks == {"-"} else None


def _lasting_s(cells: Sequence[str], order: str) -> float:
    """From the first to the last of instants, of some, s; 0 where there are none."""
    step = max(1, len(cells) // _SAMPLE)
    ns = instants([*cells[::step], *cells[-1:]], order)
    known = ns[ns != MISSING]
    return float(known.max() - known.min()) / 1e9 if known.size else 0.0


def instants(cells: Sequence[str], order: str = "ymd") -> IntArray:
    """Instants in ns since 1970, in UTC where a zone is given; the smallest integer where a text is none.

    Parameters
    ----------
    cells
        Dates, or dates with times.
    order
        "dmy" or "mdy" for dates with the year last.
    """
    quick = _plain_instants(cells)
    if quick is not None:
        return quick
    made = np.full(len(cells), MISSING, dtype=np.int64)
    for i, cell in enumerate(cells):
        match = stamp(plainly(cell))
        ns = instant(match, order) if match else None
        if ns is not None and _FIRST <= ns < _LAST:
            made[i] = ns
    return made


def _plain_instants(cells: Sequence[str]) -> IntArray | None:
    """Instants where all are ``2024-05-01T12:00:00.5`` without a zone: numpy's own way, which is quick."""
    if not all(len(cell) >= 19 and cell[10] in "T " and cell[16] == ":" and cell[-1] in "0123456789" for cell in cells):
        return None
    if "\n".join(cells).translate(_ISO_MARKS) or any("-" in cell[11:] for cell in cells):
        return None
    if not all(_FIRST_YEAR <= cell[:4] < _LAST_YEAR for cell in cells):
        return None
    try:
        made: IntArray = np.array(cells, dtype="datetime64[ns]").astype(np.int64)
    except ValueError:
        return None
    return made


def zoned(cells: Sequence[str]) -> bool:
    """Whether timestamps say how far they are from UTC; the first that holds something tells.

    Parameters
    ----------
    cells
        Dates with times.
    """
    match = stamp(next((text for cell in cells if (text := plainly(cell))), ""))
    return match is not None and zone_of(match) != ""


def of_day(cells: Sequence[str]) -> IntArray:
    """Times of day, or durations, in ns; the smallest integer where a text is none."""
    made = np.full(len(cells), MISSING, dtype=np.int64)
    for i, cell in enumerate(cells):
        match = time_of_day(plainly(cell))
        ns = duration(match) if match else None
        if ns is not None:
            made[i] = ns
    return made


def minutes(cells: Sequence[str]) -> IntArray:
    """Minutes and seconds (``7:05.3``), or hours as well (``1:00:00``), in ns; the smallest integer for other texts."""
    made = np.full(len(cells), MISSING, dtype=np.int64)
    for i, cell in enumerate(cells):
        match = MINUTES.fullmatch(cell.strip())
        if match and int(match["s"]) < 60:
            made[i] = (int(match["min"]) * 60 + int(match["s"])) * 10**9 + fraction(match["frac"])
        elif cell.count(":") == 2 and (longer := time_of_day(plainly(cell))):
            ns = duration(longer)
            made[i] = MISSING if ns is None else ns
    return made


def over_midnight(ns: IntArray) -> tuple[IntArray, int]:
    """Times of day that go on after midnight, and how often they passed it.

    Parameters
    ----------
    ns
        Times of day, shape (N,); missing ones stay.
    """
    good = np.flatnonzero(ns != MISSING)
    made = ns.copy()
    back = np.concatenate([[False], np.diff(ns[good]) < -DAY_NS // 2])
    made[good] += np.cumsum(back) * DAY_NS
    return made, int(back.sum())


def together(dates: IntArray, ns: IntArray) -> IntArray:
    """Instants of dates and times of day; missing where one of them is."""
    return np.where((dates == MISSING) | (ns == MISSING), MISSING, dates + ns)


def of_instants(values: InstantArray) -> IntArray:
    """Instants of a typed file in ns since 1970."""
    made: IntArray = in_nanoseconds(values).astype(np.int64)
    return made


def in_nanoseconds(values: InstantArray) -> InstantArray:
    """Instants of any resolution in datetime64[ns]; NaT where a year is one of no log.

    Parameters
    ----------
    values
        Shape (N,).
    """
    coarse = values.astype("datetime64[s]")  # holds any year
    within = (coarse >= np.datetime64(_FIRST_YEAR, "s")) & (coarse < np.datetime64(_LAST_YEAR, "s"))
    return np.where(within, values, np.datetime64("NaT", "s")).astype("datetime64[ns]")


def seconds(ns: IntArray) -> tuple[FloatArray, int | None]:
    """Seconds since the first instant, NaN where missing, and that instant in ns; None where there is none."""
    good = ns != MISSING
    if not good.any():
        return np.full(ns.size, np.nan), None
    first = int(ns[np.argmax(good)])
    return np.where(good, (np.where(good, ns, first) - first) / 1e9, np.nan), first


def in_seconds(ns: IntArray) -> FloatArray:
    """As they are, in seconds; NaN where missing."""
    return np.where(ns == MISSING, np.nan, np.where(ns == MISSING, 0, ns) / 1e9)
