"""Lines of a system's log: ``Mar 02 08:15:00 pi motor[1234]: winding=21.5C``, whose dates have no year.

Or of `ts`, which puts such a time before each line of any program.
"""

from __future__ import annotations

import calendar
import re
from collections.abc import Sequence
from itertools import accumulate

from gen.importing.reading.lines import Lines

_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_LINE = re.compile(
    rf"(?:<\d{{1,3}}>)?(?P<month>{'|'.join(_MONTHS)}) {{1,2}}(?P<day>\d{{1,2}}) "
    r"(?P<time>\d{2}:\d{2}:\d{2}(?:\.\d+)?) (?:\S+ [^\s:\[\]={}\"]+(?:\[\d+\])?: )?(?P<said>\S.*)"
)
_LEAST = 0.5
_LEAP, _COMMON = 2000, 2001


def is_logged(lines: Sequence[str]) -> bool:
    """Whether most lines are of syslog's form."""
    return sum(1 for line in lines if _LINE.match(line)) > _LEAST * len(lines)


def logged(lines: Lines) -> tuple[Lines, list[str]]:
    """Part the times from lines of a system's log.

    Returns
    -------
    lines, times
        What the program said, and days, hours, minutes and seconds since the year began (``60.08:15:00``): which year,
        nobody knows. Nothing of lines of another form.
    """
    found = [_LINE.match(line) for line in lines.texts]
    leap = any(match and match["month"] == "Feb" and match["day"] == "29" for match in found)
    before = [0, *accumulate(calendar.monthrange(_LEAP if leap else _COMMON, month)[1] for month in range(1, 13))]
    texts = [match["said"] if match else line for match, line in zip(found, lines.texts, strict=True)]
    times = [
        f"{before[_MONTHS.index(match['month'])] + int(match['day']) - 1}.{match['time']}" if match else ""
        for match in found
    ]
    return Lines(texts, lines.numbers, lines.comments), times
