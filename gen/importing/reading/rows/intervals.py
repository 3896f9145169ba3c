"""What lines above a table say of the interval of its rows: `Interval: 00:00:05`, `Sample Rate: 4 Hz`, `Delta_X 5`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gen.importing.units import TIME, unit_of

_SAID = re.compile(
    r"(?P<what>(?:sampl\w*|scan\w*|log\w*|record\w*|measure\w*|storage)?[ _-]?"
    r"(?:interval|rate|frequency|period|delta_x)|dt|intervall|messrate|abtastrate)"
    r"\s*(?:[\[(](?P<before>[a-z]+)[\])])?\s*[:=,;\t ]\s*"
    r"(?P<number>\d+:\d\d:\d\d(?:\.\d+)?|\d+(?:\.\d+)?(?:e[+-]?\d+)?)\s*(?P<behind>[a-z]+(?:/s)?)?",
    re.IGNORECASE,
)
_RATES = {"hz": 1.0, "khz": 1e3, "s/s": 1.0, "sps": 1.0, "/s": 1.0}
_LONGEST_S = 86_400.0


def told_interval(before: Sequence[Sequence[str]], comments: Sequence[str]) -> str:
    """The option that takes the interval which a line above the rows says, with that line; empty where none does.

    Parameters
    ----------
    before
        Lines above the first row.
    comments
        The comment lines.
    """
    for line in [*(" ".join(cell.strip() for cell in row) for row in before), *comments]:
        text = line.strip().lstrip("#").strip()
        found = _SAID.match(text)
        seconds = _seconds(found) if found else None
        if seconds is not None and 0.0 < seconds <= _LONGEST_S:
            return f'--time {seconds:g}, if "{text[:60].strip()}" is the interval of its rows'
    return ""


def _seconds(found: re.Match[str]) -> float | None:
    """The interval, s; None where it is in no unit that is known."""
    number, unit = found["number"], (found["behind"] or found["before"] or "").casefold()
    if ":" in number:
        hours, minutes, seconds = map(float, number.split(":"))
        return 3600.0 * hours + 60.0 * minutes + seconds
    value = float(number)
    if unit in _RATES:
        return 1.0 / (value * _RATES[unit]) if value else None
    if not unit:
        return value if found["what"].casefold() == "delta_x" else None  # LabVIEW's, s
    known = unit_of(unit)
    return value * known.scale if known is not None and known.quantity == TIME else None
