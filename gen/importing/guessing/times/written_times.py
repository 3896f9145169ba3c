"""How dates and times are written: whether the day or the month comes first, whether `8:15` is hours or minutes."""

from __future__ import annotations

import re
from itertools import pairwise

from gen.importing import clock
from gen.importing.dates import MINUTES
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import CERTAIN, Guess, quoted
from gen.importing.guessing.names import DAY_FIRST, OF_DAY
from gen.importing.mapping import TimeForm
from gen.importing.units import DEGF

_HOURS_OR_MINUTES = {"hh:mm": "time of day", "mm:ss": "mm:ss"}
_LAST_HOUR = 23


def date_order_of(evidence: Evidence, cells: list[str], name: str) -> tuple[str, float, str]:
    """Whether day or month comes first; where dates do not tell, by how the rest of the log is written.

    Parameters
    ----------
    evidence
        The columns.
    cells
        Dates, with or without times.
    name
        Of their column.

    Returns
    -------
    order, confidence, why
        "ymd", "dmy" or "mdy".
    """
    order, sure, reason = clock.date_order(cells)
    if reason not in (clock.ONE_DATE, clock.EITHER):
        return order, sure, reason
    found = _written(evidence, cells)
    if found is not None:
        return found[0], 0.85, f"{reason}; {found[1]}"
    if reason == clock.EITHER:
        return order, sure, reason
    day, month = (f"{quoted(f'{name}={order}')}" for order in ("dmy", "mdy"))
    said = {"mdy": f"the month first; if the day is: --unit {day}", "dmy": f"the day first; if not: --unit {month}"}
    return order, sure, f"{reason}, taken with {said[order]}"


def _written(evidence: Evidence, cells: list[str]) -> tuple[str, str] | None:
    """The order of dates by who writes the rest so, and what tells it: commas for decimals, or °F and AM."""
    table = evidence.tables[0]
    degrees = {unit.name for facts in evidence.facts.values() if (unit := facts.named[1]) is not None}
    said = [
        ("dmy", table.reading.decimal == ",", "decimal commas"),
        ("dmy", table.reading.delimiter == ";", "semicolons"),
        ("dmy", any(DAY_FIRST.fullmatch(name) for name in evidence.facts), "names of no English"),
        ("mdy", DEGF.name in degrees, "degF"),
    ]
    orders = {order for order, is_so, _ in said if is_so}
    if len(orders) != 1:
        return None
    order = next(iter(orders))
    whys = " and ".join(why for _, is_so, why in said if is_so)
    return order, f"the {'day' if order == 'dmy' else 'month'} first, as in logs with {whys}"


def hours_or_minutes(entry: Facts, told: str, confidence: float, why: str) -> tuple[TimeForm, list[Guess]]:
    """Whether `8:15` is a time of day or eight minutes: by where it begins and ends, by what it passes, by its name.

    Parameters
    ----------
    entry
        The column.
    told
        What the user says it is.
    confidence, why
        That it is the time.
    """
    firsts = [int(match[1]) for cell in entry.texts if (match := MINUTES.fullmatch(cell.strip()))]
    over_midnight = any(one == _LAST_HOUR and other == 0 for one, other in pairwise(firsts))
    if told in _HOURS_OR_MINUTES:
        unit, sure, reason = _HOURS_OR_MINUTES[told], CERTAIN, "--unit"
    elif said := _said_of_minutes(entry):
        unit, sure, reason = _HOURS_OR_MINUTES[said], 0.95, f"{said} by its name"
    elif any(cell.count(":") == 2 for cell in entry.texts):
        unit, sure, reason = "mm:ss", 0.95, "mm:ss, then h:mm:ss"
    elif over_midnight and max(firsts) == _LAST_HOUR:
        unit, sure, reason = "time of day", 0.9, "hh:mm, it passes midnight"
    elif max(firsts, default=0) > _LAST_HOUR:
        unit, sure, reason = "mm:ss", 0.9, f"mm:ss, up to {max(firsts)}"
    elif any("." in cell or "," in cell for cell in entry.texts):
        unit, sure, reason = "mm:ss", 0.9, "mm:ss, with fractions"
    elif OF_DAY.fullmatch(entry.named[0].casefold()):
        unit, sure, reason = "time of day", 0.9, "hh:mm by its name"
    elif firsts and firsts[0] == 0 and max(firsts) < _LAST_HOUR:
        unit, sure, reason = "mm:ss", 0.65, "mm:ss, as it begins at 0"
    else:
        unit, sure, reason = "time of day", 0.4, "hh:mm, or mm:ss since something began"
    settle = f"--unit {quoted(f'{entry.name}=hh:mm')} or {quoted(f'{entry.name}=mm:ss')}"
    form = TimeForm.model_validate({"columns": [entry.name], "unit": unit})
    return form, [Guess(entry.name, f"time: {unit}", min(confidence, sure), f"{why}; {reason}", settle)]


def _said_of_minutes(entry: Facts) -> str:
    """Whether a name, or a row of units, says `hh:mm` or `mm:ss`; empty where it says neither."""
    said = f"{entry.name} {entry.columns[0].unit}".casefold()
    if re.search(r"(?<![a-z:])(?:h|hh|std|hrs?):(?:m|mm|min)(?![a-z:])", said):
        return "hh:mm"
    return "mm:ss" if re.search(r"(?<![a-z:])(?:m|mm|min):(?:s|ss|sec|sek)(?![a-z:])", said) else ""
