"""Times as loggers write them: instants, times of day, durations."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from gen.importing.table import FloatArray, InstantArray, IntArray

_TIME = (
    r"(?P<h>\d{1,3})(?P<between>:|\.(?=\d{2}\.\d{2}))(?P<min>\d{2})"
    r"(?:(?P=between)(?P<s>\d{2})(?:[.,:](?P<frac>\d{1,9}))?)?\s*(?P<half>[AaPp]\.?[Mm]\.?)?"
)
"""Points may part hours, minutes and seconds, all three: 10.02.33."""
_ZONE = r"\s*(?P<zone>Z|UTC|[+-]\d{2}:?\d{2})?"
_SEPARATOR = r"(?:[T ,;]\s*)"
_ISO = r"(?P<y>\d{4})[-/.]?(?P<m>\d{2})[-/.]?(?P<d>\d{2})"
_TRIPLE = r"(?P<a>\d{1,2})(?P<mark>[./-])(?P<b>\d{1,2})(?P=mark)(?P<y>\d{4}|\d{2})"
_NAMED = r"(?P<d>\d{1,2})[-. ](?P<month>[A-Za-zäÄ]{3})[a-z]*\.?[-. ](?P<y>\d{4}|\d{2})"
_CLOCK = re.compile(_TIME, re.ASCII)
_MINUTES = re.compile(r"(?P<min>\d{1,3}):(?P<s>\d{2})(?:[.,](?P<frac>\d{1,9}))?", re.ASCII)
_DATES = tuple(
    re.compile(rf"{date}(?:{_SEPARATOR}{_TIME}{_ZONE})?", re.ASCII if date != _NAMED else 0)
    for date in (_ISO, _TRIPLE, _NAMED)
)
_MONTHS = {
    name: number
    for names in (
        "jan feb mar apr may jun jul aug sep oct nov dec",
        "jan feb mär apr mai jun jul aug sep okt nov dez",
    )
    for number, name in enumerate(names.split(), start=1)
}
_SOUND = 0.95
"""Of a column of times, as others hold damaged lines."""
_DOTTED = re.compile(r"\d{1,2}\.\d{2}\.\d{2}(?:[.,]\d{1,9})?", re.ASCII)
_ISO_MARKS = str.maketrans("", "", "0123456789-:.T \n")
_DAY_NS = 86_400 * 10**9
_NOT = np.iinfo(np.int64).min


def is_time(text: str) -> bool:
    """Whether a text is a date, a time of day or both; a number alone is none of them."""
    if ":" in text:
        return bool(_CLOCK.fullmatch(text) or _MINUTES.fullmatch(text)) or any(p.fullmatch(text) for p in _DATES)
    if text.isdigit() or _plain(text) is not None:
        return False
    return bool(_DOTTED.fullmatch(text)) or any(p.fullmatch(text) for p in _DATES)


def _plain(text: str) -> re.Match[str] | None:
    return re.fullmatch(r"[+-]?\d*[.,]?\d*", text)


def kind_of(cells: Sequence[str]) -> str:
    """What a column's texts are: "instant", "date", "clock" (time of day), "minutes" (mm:ss), or "" for none."""
    sample = [cell.strip() for cell in cells[:2000] if cell.strip()]
    if not sample:
        return ""

    def share(test: Sequence[bool]) -> bool:
        return sum(test) > 0.5 * len(sample)

    if share([bool(_DOTTED.fullmatch(text)) for text in sample]) and _goes_on(cells):
        return "clock"
    if share([any(p.fullmatch(text) and is_time(text) for p in _DATES) for text in sample]):
        return "instant" if share([_has_time(text) for text in sample]) else "date"
    if share([bool(_CLOCK.fullmatch(text)) and text.count(":") >= 2 for text in sample]):
        return "clock"
    return "minutes" if share([bool(_MINUTES.fullmatch(text)) for text in sample]) else ""


def _has_time(text: str) -> bool:
    return ":" in text or any(match["h"] is not None for p in _DATES if (match := p.fullmatch(text)))


def dotted(cells: Sequence[str]) -> bool:
    """Whether times of day are parted by points; the first that holds something tells.

    Parameters
    ----------
    cells
        Times of day.
    """
    return bool(_DOTTED.fullmatch(next((cell.strip() for cell in cells if cell.strip()), "")))


def _goes_on(cells: Sequence[str]) -> bool:
    """Whether texts such as `10.02.33` are times of day that go on, a few damaged apart, and no dates of a few days.

    The last number of a date is the year, which a log of hours does not change; of a time it is the seconds.
    """
    filled = [text for cell in cells if (text := cell.strip())]
    ns = of_day(filled)
    sound = (ns != _NOT) & (ns < _DAY_NS) & np.array([bool(_DOTTED.fullmatch(text)) for text in filled], dtype=bool)
    if sound.sum() < _SOUND * sound.size:
        return False
    texts, ns = [text for text, good in zip(filled, sound, strict=True) if good], ns[sound]
    on, nights = over_midnight(ns)
    steps = np.diff(on)
    if (steps < 0).any() or not (steps > 0).any() or on[-1] - on[0] >= (nights + 1) * _DAY_NS:
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
    found = {match.group("a", "mark", "b") for cell in cells if (match := _DATES[1].match(cell.strip()))}
    if not found:
        return "ymd", 1.0, "year first, or the month in letters"
    if any(int(a) > 12 for a, _, _ in found):
        return "dmy", 0.99, "a first number above 12"
    if any(int(b) > 12 for _, _, b in found):
        return "mdy", 0.99, "a second number above 12"
    if {mark for _, mark, _ in found} == {"."}:
        return "dmy", 0.9, "parted by points"
    if len(found) == 1:
        return "mdy", 0.9, "one date only, so that the order does not matter"
    return "mdy", 0.4, f"{len(found)} dates that are possible either way"


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
    days: dict[str, int | None] = {}
    made = np.full(len(cells), _NOT, dtype=np.int64)
    for i, cell in enumerate(cells):
        text = cell.strip()
        for pattern in _DATES:
            match = pattern.fullmatch(text)
            if match is None:
                continue
            date = text[: match.start("h")] if match["h"] else text
            if date not in days:
                days[date] = _day(match, order)
            day, ns = days[date], _of_day(match) if match["h"] else 0
            if day is not None and ns is not None:
                made[i] = day * _DAY_NS + ns - _offset(match["zone"])
            break
    return made


def _plain_instants(cells: Sequence[str]) -> IntArray | None:
    """Instants where all are ``2024-05-01T12:00:00.5`` without a zone: numpy's own way, which is quick."""
    if not all(len(cell) >= 19 and cell[10] in "T " and cell[16] == ":" and cell[-1] in "0123456789" for cell in cells):
        return None
    if "\n".join(cells).translate(_ISO_MARKS) or any("-" in cell[11:] for cell in cells):
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
    text = next((cell.strip() for cell in cells if cell.strip()), "")
    return any(match["zone"] is not None for pattern in _DATES if (match := pattern.fullmatch(text)))


def of_day(cells: Sequence[str]) -> IntArray:
    """Times of day, or durations, in ns; the smallest integer where a text is none."""
    made = np.full(len(cells), _NOT, dtype=np.int64)
    for i, cell in enumerate(cells):
        match = _CLOCK.fullmatch(cell.strip())
        ns = _of_day(match) if match else None
        if ns is not None:
            made[i] = ns
    return made


def minutes(cells: Sequence[str]) -> IntArray:
    """Minutes and seconds (``7:05.3``) in ns; the smallest integer where a text is none."""
    made = np.full(len(cells), _NOT, dtype=np.int64)
    for i, cell in enumerate(cells):
        match = _MINUTES.fullmatch(cell.strip())
        if match and int(match["s"]) < 60:
            made[i] = (int(match["min"]) * 60 + int(match["s"])) * 10**9 + _fraction(match["frac"])
    return made


def over_midnight(ns: IntArray) -> tuple[IntArray, int]:
    """Times of day that go on after midnight, and how often they passed it.

    Parameters
    ----------
    ns
        Times of day, shape (N,); missing ones stay.
    """
    good = np.flatnonzero(ns != _NOT)
    made = ns.copy()
    back = np.concatenate([[False], np.diff(ns[good]) < -_DAY_NS // 2])
    made[good] += np.cumsum(back) * _DAY_NS
    return made, int(back.sum())


def together(dates: IntArray, ns: IntArray) -> IntArray:
    """Instants of dates and times of day; missing where one of them is."""
    return np.where((dates == _NOT) | (ns == _NOT), _NOT, dates + ns)


def of_instants(values: InstantArray) -> IntArray:
    """Instants of a typed file in ns since 1970."""
    made: IntArray = values.astype("datetime64[ns]").astype(np.int64)
    return made


def seconds(ns: IntArray) -> tuple[FloatArray, int | None]:
    """Seconds since the first instant, NaN where missing, and that instant in ns; None where there is none."""
    good = ns != _NOT
    if not good.any():
        return np.full(ns.size, np.nan), None
    first = int(ns[np.argmax(good)])
    return np.where(good, (np.where(good, ns, first) - first) / 1e9, np.nan), first


def in_seconds(ns: IntArray) -> FloatArray:
    """As they are, in seconds; NaN where missing."""
    return np.where(ns == _NOT, np.nan, np.where(ns == _NOT, 0, ns) / 1e9)


def _day(match: re.Match[str], order: str) -> int | None:
    parts = match.groupdict()
    year = int(parts["y"]) + (2000 if len(parts["y"]) == 2 else 0)
    if parts.get("month"):
        month, day = _MONTHS.get(parts["month"].casefold(), 0), int(parts["d"])
    elif parts.get("a"):
        first, second = int(parts["a"]), int(parts["b"])
        month, day = (first, second) if order == "mdy" else (second, first)
    else:
        month, day = int(parts["m"]), int(parts["d"])
    try:
        return int(np.datetime64(f"{year:04d}-{month:02d}-{day:02d}", "D").astype(np.int64))
    except ValueError:
        return None


def _of_day(match: re.Match[str]) -> int | None:
    hour, minute, second = int(match["h"]), int(match["min"]), int(match["s"] or 0)
    if match["half"]:
        if not 1 <= hour <= 12:
            return None
        hour = hour % 12 + (12 if match["half"][0] in "Pp" else 0)
    if minute > 59 or second > 60:
        return None
    return (hour * 3600 + minute * 60 + second) * 10**9 + _fraction(match["frac"])


def _fraction(digits: str | None) -> int:
    return int(digits.ljust(9, "0")) if digits else 0


def _offset(zone: str | None) -> int:
    if not zone or zone in ("Z", "UTC"):
        return 0
    sign = -1 if zone[0] == "-" else 1
    return sign * (int(zone[1:3]) * 3600 + int(zone[-2:]) * 60) * 10**9
