"""Single times as people and programs write them: dates with and without times of day, times of day, durations."""

from __future__ import annotations

import re
from datetime import date

DAY_NS = 86_400 * 10**9
_SECOND_NS = 10**9
_EPOCH = date(1970, 1, 1).toordinal()

_TIME = (
    r"(?P<h>\d{1,3})(?P<between>:|\.(?=\d{2}\.\d{2}))(?P<min>\d{2})"
    r"(?:(?P=between)(?P<s>\d{2})(?:[.,:](?P<frac>\d{1,9}))?)?\s*(?P<half>[AaPp]\.?\s?[Mm]\.?|Uhr)?"
)
"""Points may part hours, minutes and seconds, all three: 10.02.33."""
_ZONES = {
    name: hours
    for hours, names in (
        (0, "Z UTC GMT WET"),
        (1, "CET MEZ BST WEST"),
        (2, "CEST MESZ EET"),
        (3, "EEST MSK"),
        (9, "JST KST"),
        (10, "AEST"),
        (11, "AEDT"),
        (-3, "BRT"),
        (-4, "EDT"),
        (-5, "EST CDT"),
        (-6, "CST MDT"),
        (-7, "MST PDT"),
        (-8, "PST"),
    )
    for name in names.split()
}
"""Hours before UTC. Of names that stand for several, the one whose summer time has a name as well."""
_ZONE = (
    rf"(?:\s*(?:GMT|UTC)?(?P<zone>(?:{'|'.join(sorted(_ZONES, key=len, reverse=True))})|[+-]\d{{2}}(?::?\d{{2}})?)"
    r"(?:\s*[(\[][^()\[\]]*[)\]])?)?"
)
"""A name in brackets may follow: `GMT+0200 (CEST)`, `+02:00[Europe/Berlin]`."""
_WEEKDAY = r"(?:[^\W\d_]{2,10}\.?,?\s+)?"
_MONTH = r"(?P<month>[^\W\d_]{3,10})"
_SEPARATOR = r"(?:[Tt ,;_]\s*|:|-|\s+(?:at|um|à|alle|a las)\s+)"
_ISO = r"(?P<y>\d{4})(?:[-/.:]?(?P<m>\d{2})[-/.:]?(?P<d>\d{2}))"
_SHORT_ISO = r"(?P<y>\d{4})(?P<mark>[-/.])\s?(?P<m>\d{1,2})(?P=mark)\s?(?P<d>\d{1,2})\.?"
_KANJI = r"(?P<y>\d{4})\s?年\s?(?P<m>\d{1,2})\s?月\s?(?P<d>\d{1,2})\s?日"
_YEAR = r"(?P<y>\d{4}|(?<!\s)\d{2}|\d{2}(?!:))"
"""Four digits or two; behind a space, two before a colon are an hour: `02.03. 08:15`."""
_TRIPLE = rf"(?P<a>\d{{1,2}})(?P<mark>[./-])\s?(?P<b>\d{{1,2}})(?P=mark)\s?{_YEAR}"
_NAMED = rf"{_WEEKDAY}(?P<d>\d{{1,2}})\.?[-. /]\s*(?:de\s+)?{_MONTH}\.?,?[-. /]\s*(?:de\s+)?{_YEAR}"
_SAS = r"(?P<d>\d{1,2})(?P<month>[^\W\d_]{3})(?P<y>\d{4}|\d{2})"
"""02Mar2026."""
_MONTH_FIRST = rf"{_WEEKDAY}{_MONTH}\.?\s+(?P<d>\d{{1,2}})(?:st|nd|rd|th)?,?\s+(?P<y>\d{{4}})"
_YEAR_FIRST = rf"(?P<y>\d{{4}})[-. /]{_MONTH}\.?[-. /](?P<d>\d{{1,2}})"
_UNIX = rf"{_WEEKDAY}{_MONTH}\s+(?P<d>\d{{1,2}})\s+{_TIME}{_ZONE}\s+(?P<y>\d{{4}})"
"""`ctime`, and `date` with a zone: Thu Apr  3 23:30:00 CEST 2025."""
_UNIX_DAY_FIRST = rf"{_WEEKDAY}(?P<d>\d{{1,2}})\.?\s+{_MONTH}\.?\s+{_TIME}{_ZONE}\s+(?P<y>\d{{4}})"
"""`date` in other countries: Thu  3 Apr 23:30:00 BST 2025, Do 3. Apr 23:30:00 CEST 2025."""
_COMPACT = (
    rf"(?P<y>\d{{4}})-?(?P<m>\d{{2}})-?(?P<d>\d{{2}})[Tt_ -](?P<h>\d{{2}})(?P<min>\d{{2}})"
    rf"(?:(?P<s>\d{{2}})(?:[.,]?(?P<frac>\d{{1,9}}))?)?{_ZONE}"
)
_DASHED = (
    r"(?P<y>\d{4})-(?P<m>\d{2})-(?P<d>\d{2})[-_ T](?P<h>\d{2})-(?P<min>\d{2})-(?P<s>\d{2})(?:[.,-](?P<frac>\d{1,9}))?"
)
"""As names of files have it: 2026-03-02-08-15-00."""
_IN_NUMBERS = (_ISO, _SHORT_ISO, _KANJI, _TRIPLE)
_STAMPS = tuple(
    re.compile(form)
    for form in (
        *(
            rf"{form}(?:{_SEPARATOR}{_TIME}{_ZONE})?"
            for form in (*_IN_NUMBERS, _NAMED, _SAS, _MONTH_FIRST, _YEAR_FIRST)
        ),
        _UNIX,
        _UNIX_DAY_FIRST,
        _COMPACT,
        _DASHED,
        *(rf"{_TIME}[ ,;]\s*{form}" for form in (_ISO, _SHORT_ISO, _TRIPLE)),
    )
)
_CLOCK = re.compile(r"(?P<sign>-)?" + _TIME.replace(r"\d{1,3}", r"\d{1,6}", 1))
"""Before a trigger, times since a beginning are negative."""
_DAYS = re.compile(
    r"(?P<days>\d{1,5})(?:\s*(?:days?|d|Tage?|jours?|j)[ ,]*|[.:])"
    r"(?P<h>\d{1,2}):(?P<min>\d{2}):(?P<s>\d{2})(?:[.,](?P<frac>\d{1,9}))?"
)
"""`0 days 23:53:20`, `1.02:03:04`, `1d 02:03:04`."""
_SPELT = re.compile(
    r"(?:P?T?)(?:(?P<days>\d+)\s*d(?:ays?)?[ ,T]*)?(?:(?P<h>\d+)\s*(?:h|hrs?|hours?|std\.?)[ ,]*)?"
    r"(?:(?P<min>\d+)\s*(?:m|min|mins|minutes?|')[ ,]*)?"
    r"(?:(?P<s>\d+)(?:[.,](?P<frac>\d{1,9}))?\s*(?:s|secs?|seconds?|sek\.?|\"|''))?[ ,]*(?:(?P<milli>\d{1,9})\s*ms)?",
    re.IGNORECASE,
)
"""`0h00m10s`, `1 h 2 min 3 s`, ISO's `PT1H2M3S`."""
MINUTES = re.compile(r"(?P<min>\d{1,3}):(?P<s>\d{2})(?:[.,](?P<frac>\d{1,9}))?", re.ASCII)
DOTTED = re.compile(r"\d{1,2}\.\d{2}\.\d{2}(?:[.,]\d{1,9})?", re.ASCII)
_OF_A_CONTROLLER = re.compile(r"^(?:L?TIME|L?T|L?DATE_AND_TIME|L?DT|L?TIME_OF_DAY|L?TOD)#", re.IGNORECASE)
"""What IEC 61131 puts before times: `T#1m30s500ms`, `TOD#08:15:00`."""
_SINCE_A_START = re.compile(r"^(?:T?\+(?=\d)|T(?=-\d))")
"""`T+00:01:00`, `+00:01:00`."""
_BARE = re.compile(r"(?<![\d:.])\d{1,3}:(?:\d:\d{1,2}|\d{2}:\d)(?![\d:])", re.ASCII)
"""Numbers of a sketch as they are: `8:5:3`."""
_ODD = str.maketrans(dict.fromkeys("\u00a0\u202f\u2009", " "))
"""Spaces that no line breaks at: before AM and PM, of Windows and of spreadsheets."""
_NAMES_OF_MONTHS = (
    "january januar janvier gennaio enero januari janeiro jänner",
    "february februar février fevrier febbraio febrero februari fevereiro feber",
    "march märz mars marzo maart março marco mrt maerz",
    "april avril aprile abril apr",
    "may mai maggio mayo mei maio",
    "june juni juin giugno junio junho",
    "july juli juillet luglio julio julho",
    "august août aout agosto augustus",
    "september septembre settembre septiembre setembro",
    "october oktober octobre ottobre octubre outubro",
    "november novembre noviembre novembro",
    "december dezember décembre decembre dicembre diciembre dezembro",
)
"""In the languages of the columns' names."""


def _prefixes() -> dict[str, int]:
    """Three letters and more of a month, where they are of one month only: `jui` is June or July."""
    found: dict[str, set[int]] = {}
    for number, names in enumerate(_NAMES_OF_MONTHS, start=1):
        for name in names.split():
            for length in range(3, len(name) + 1):
                found.setdefault(name[:length], set()).add(number)
    return {prefix: next(iter(numbers)) for prefix, numbers in found.items() if len(numbers) == 1}


_MONTHS = _prefixes()


def plainly(cell: str) -> str:
    """A cell without what stands around it, and with plain spaces."""
    plain = cell.strip().translate(_ODD)
    if "#" in plain:
        plain = _OF_A_CONTROLLER.sub("", plain)
    if plain[:1] in "+T" and ":" in plain:
        plain = _SINCE_A_START.sub("", plain)
    if ":" in plain and _BARE.search(plain):
        plain = _BARE.sub(lambda found: ":".join(part.zfill(2) for part in found[0].split(":")), plain)
    return plain


def stamp(text: str) -> re.Match[str] | None:
    """What a text says as a date, with or without a time; None where it says none.

    Parameters
    ----------
    text
        A cell, plainly.
    """
    if text.isdigit() or not text.isprintable():
        return None
    for pattern in _STAMPS:
        match = pattern.fullmatch(text)
        if match and ("month" not in pattern.groupindex or match["month"].casefold() in _MONTHS):
            return match
    return None


def has_time(match: re.Match[str]) -> bool:
    """Whether a date's match holds a time, too."""
    return "h" in match.re.groupindex and match["h"] is not None


def zone_of(match: re.Match[str]) -> str:
    """How far from UTC a date's match says it is, as written; empty where it does not."""
    return match.groupdict().get("zone") or ""


def instant(match: re.Match[str], order: str) -> int | None:
    """The instant of a date's match in ns since 1970, in UTC where it names a zone; None where no calendar has it.

    Parameters
    ----------
    match
        Of :func:`stamp`.
    order
        "dmy" or "mdy" for dates with the year last; "ymd" where two digits of it stand first.
    """
    day = _day(match, order)
    ns = duration(match) if has_time(match) else 0
    return None if day is None or ns is None else day * DAY_NS + ns - _offset(zone_of(match))


def time_of_day(text: str) -> re.Match[str] | None:
    """What a text says as hours, minutes and seconds, or None: a time of day, or a time since a beginning."""
    found = _CLOCK.fullmatch(text) or _DAYS.fullmatch(text)
    if found:
        return found
    spelt = _SPELT.fullmatch(text)
    return spelt if spelt and any(spelt.groupdict().values()) else None


def says_seconds(match: re.Match[str]) -> bool:
    """Whether a time of day's match has more than one of days, hours, minutes and seconds, and more than `7:05`.

    `7:05 PM` is no time since a start, of minutes and seconds.
    """
    said = {key for key in ("days", "h", "min", "s", "milli") if match.groupdict().get(key) is not None}
    return len(said) > 1 and (match.re is not _CLOCK or "s" in said or match["half"] is not None)


def duration(match: re.Match[str]) -> int | None:
    """A time of day, or a time since a beginning, in ns; None where its minutes or seconds are none."""
    parts = match.groupdict()
    days, hour, minute, second = (int(parts.get(key) or 0) for key in ("days", "h", "min", "s"))
    half = parts.get("half") or ""
    if half and half != "Uhr":
        if not 1 <= hour <= 12:
            return None
        hour = hour % 12 + (12 if half[0] in "Pp" else 0)
    counted = match.re is _SPELT  # 90m00s is an hour and a half
    if not counted and (minute > 59 or second > 60):
        return None
    sign = -1 if parts.get("sign") else 1
    return sign * (
        days * DAY_NS
        + (hour * 3600 + minute * 60 + second) * _SECOND_NS
        + fraction(parts.get("frac"))
        + int(parts.get("milli") or 0) * 10**6
    )


def fraction(digits: str | None) -> int:
    """Digits behind a second's mark, in ns."""
    return int(digits.ljust(9, "0")) if digits else 0


def _day(match: re.Match[str], order: str) -> int | None:
    """Days since 1970."""
    parts = match.groupdict()
    year = int(parts["y"]) + (2000 if len(parts["y"]) == 2 else 0)
    if parts.get("month"):
        month, day = _MONTHS[parts["month"].casefold()], int(parts["d"])
    elif parts.get("a") and order == "ymd" and len(parts["y"]) == 2:
        year, month, day = 2000 + int(parts["a"]), int(parts["b"]), int(parts["y"]) % 100
    elif parts.get("a"):
        first, second = int(parts["a"]), int(parts["b"])
        month, day = (first, second) if order == "mdy" else (second, first)
    else:
        month, day = int(parts["m"]), int(parts["d"])
    try:
        return date(year, month, day).toordinal() - _EPOCH
    except ValueError:
        return None


def _offset(zone: str) -> int:
    """How far before UTC, in ns."""
    if not zone:
        return 0
    if zone in _ZONES:
        return _ZONES[zone] * 3600 * _SECOND_NS
    sign = -1 if zone[0] == "-" else 1
    digits = zone[1:].replace(":", "").ljust(4, "0")
    return sign * (int(digits[:2]) * 3600 + int(digits[2:]) * 60) * _SECOND_NS
