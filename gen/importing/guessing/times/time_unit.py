"""The unit of a time in numbers: by its name, by when it begins, else by its steps."""

from __future__ import annotations

import re

import numpy as np

from gen.errors import InputError
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import CERTAIN, Choices, quoted
from gen.importing.guessing.times.plain_steps import plainer_unit
from gen.importing.mapping import TimeForm
from gen.importing.origins import days_since, seconds_since
from gen.importing.units import TIME, unit_of

_EPOCHS = (
    (1e9, 2.5e9, "s"),
    (1e12, 2.5e12, "ms"),
    (1e15, 2.5e15, "us"),
    (1e18, 2.5e18, "ns"),
    (1.16e17, 1.5e17, "100ns"),
    (6.2e17, 6.6e17, "100ns"),
    (1.16e16, 1.5e16, "us"),
)
"""From which first number to which, and the unit; the last since 1601 and the year 1, as Windows and .NET count."""
_ROUND_S = {60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0}
EARLIEST_S = _EPOCHS[0][0]
"""Since 1970, of a log."""
_EITHER = 0.5
_IN_SECONDS = {"x_value"}
"""LabVIEW's time, whatever its steps."""
_SHORT_S, _SHORT_ONE_BY_ONE_S = 900.0, 7200.0
"""Of a log that may be of longer units than seconds; and where rows are 1 apart, as in one of minutes."""
_SLOWER = (("min", 60.0, 1.0), ("h", 3600.0, 10.0))
"""Units that loggers write instead of s, and from which interval of rows on, s."""
_SLOWEST_S = 1800.0
_SLOW_S = 300.0
"""Rows that would come as seldom in ms may be of a counter of us."""
_LEAST_US, _LONG_S = 1000.0, 86400.0
"""Steps in us of what logs fastest; and a day, which a counter of ms seldom passes where one of us soon would."""
_LONGEST_UP_S = 1e8
"""Three years, which nothing runs without being switched off."""
_FINER = (("us", 1e-6), ("ns", 1e-9))
_UNITS_APART = 50.0
"""Between the intervals of one logger's files, from which on these may be in s and min, or ms and s."""
_SPOKEN = ((3600.0, "h"), (60.0, "min"), (1.0, "s"))
_FACTORED = re.compile(
    r"(?:[x*×]\s*)?(?P<by>\d+(?:\.\d+)?)\s*(?P<one>[mun]?s|min)|(?P<of>[mun]?s|min)\s*[x*×]\s*(?P<last>\d+(?:\.\d+)?)",
    re.IGNORECASE,
)
"""A time that is counted in several of a unit: `x10ms`, `ms*10`."""
_CENTI = {"cs", "centisec", "centiseconds", "1/100s", "1/100 s"}
_NO_TIME = (
    "tick ticks sample samples scan scans count counts cycle cycles point points index idx row rows frame frames # n no"
)
_SHORTEST_S = 20.0
"""A log of a motor's temperature lasts longer."""


def unit_of_time(entry: Facts, choices: Choices) -> tuple[str, float, str]:
    """The unit of a column of numbers that is the time.

    Parameters
    ----------
    entry
        The column.
    choices
        What the user says.

    Returns
    -------
    unit, confidence, why
        The unit's plain name.

    Raises
    ------
    InputError
        Without a file name: what was said is no unit of a time.
    """
    told = choices.units.get(entry.name) or choices.units.get("time_s")
    if told:
        unit = unit_of(told)
        if unit is None or unit.quantity != TIME:
            raise InputError(f'found "{told}", expected s, ms, us, min, h or d', place=f"--unit {entry.name}")
        return unit.name, CERTAIN, "--unit"
    base, unit, where = entry.named
    if unit is None and (alone := unit_of(base)) and alone.quantity == TIME:
        unit, where = alone, "name"
    if unit is not None and unit.quantity == TIME:
        said = ["" if where == "name" else f"unit from the {where}", _since(entry, unit.scale)]
        return unit.name, 0.95, "; ".join(filter(None, said))
    written = entry.written_unit.strip()
    factor = _FACTORED.fullmatch(written) or _FACTORED.fullmatch(entry.name.rpartition("_")[2])
    if written.casefold() in _CENTI:
        return "10ms", 0.95, "by its name"
    if factor and (several := unit_of(f"{factor['by'] or factor['last']}{factor['one'] or factor['of']}")):
        return several.name, 0.95, "by its name"
    if written and (any(c.isdigit() for c in written) or written.casefold() in _NO_TIME.split()):
        return "s", 0.4, f"in {written}: how long is one?"
    epoch = epoch_of(entry)
    if epoch and (counted := unit_of(epoch)):
        return epoch, 0.95, f"begins at {float(np.median(entry.starts)):.0f} {epoch} {_since(entry, counted.scale)}"
    apart = _steps_apart(entry)
    if apart:
        return "s", 0.4, f"a row every {apart[0]:g} in one file and every {apart[1]:g} in another: of one unit?"
    unit_name, sure, reason = _unit_by_steps(entry)
    since = _since(entry, 1.0) if unit_name == "s" else ""
    if since:
        return "s", 0.9, f"begins at {entry.span[0]:.0f} s {since}"
    unknown = entry.starts.size and float(entry.starts[0]) * _scale_of(unit_name) > _LONGEST_UP_S
    return unit_name, sure, f"{reason}, since what instant nothing tells" if unknown else reason


def _steps_apart(entry: Facts) -> tuple[float, float] | None:
    """The least and the largest usual step of files, where they are so far apart that units may be; else None."""
    finite = [parsed.values[np.isfinite(parsed.values)] for parsed in entry.parsed]
    rising = [steps[steps > 0] for steps in map(np.diff, finite)]
    usual = [float(np.median(steps)) for steps in rising if steps.size]
    return (min(usual), max(usual)) if usual and max(usual) >= _UNITS_APART * min(usual) else None


def _scale_of(name: str) -> float:
    unit = unit_of(name)
    return 1.0 if unit is None else unit.scale


def _since(entry: Facts, scale: float) -> str:
    """From which instant numbers of a unit count, and the day so; empty where they count from none that is known."""
    first = float(entry.starts[0]) * scale if entry.starts.size else 0.0
    counted = seconds_since(first, entry.name) if scale <= 1.0 else None
    if counted is None and EARLIEST_S < first < _EPOCHS[0][1]:
        counted = (0, "since 1970")
    return "" if counted is None else f"{counted[1]}: {np.datetime64(int(first + counted[0]), 's').astype(str)[:10]}"


def epoch_of(entry: Facts) -> str:
    """The unit of a time since 1970, or since long before; empty where it is none.

    Parameters
    ----------
    entry
        The column.
    """
    first = float(np.median(entry.starts)) if entry.starts.size else 0.0
    return next((name for low, high, name in _EPOCHS if low < first < high), "")


def _unit_by_steps(entry: Facts) -> tuple[str, float, str]:
    """The unit by the usual interval: seconds are taken for granted only where nothing else is likely."""
    rising = entry.steps[entry.steps > 0]
    step = float(np.median(rising)) if rising.size else 0.0
    low, high = entry.span
    since = days_since(low)
    if since and not entry.whole and high - low < 1000:
        return "d", 0.85, since[1]
    plainer, why = ("", "") if entry.whole else plainer_unit(entry.values)
    if plainer:
        return plainer, 0.45, why
    said = f"steps of {step:.6g}"
    if entry.whole and step * 1e-3 > _SLOWEST_S:
        finer = next(((name, part) for name, part in _FINER if step * part <= _SLOWEST_S), _FINER[-1])
        return finer[0], 0.7, f"{said} and whole, {_lasting(step * 1e-3)} in ms: {finer[0]}"
    if entry.whole and step * 1e-3 > _SLOW_S and step * 1e-3 not in _ROUND_S:
        return "ms", _EITHER, f"{said} and whole: {_lasting(step * 1e-3)} in ms, {step * 1e-6:.3g} s in us"
    if entry.whole and step >= _LEAST_US and high * 1e-3 > _LONG_S:
        return "ms", _EITHER, f"{said} and whole, up to {_lasting(high * 1e-3)} in ms and {_lasting(high * 1e-6)} in us"
    if entry.whole and step >= 100 and not (step in _ROUND_S and len(set(rising.tolist())) == 1):
        return "ms", 0.8, f"{said} and whole: ms"
    if entry.whole and step in _ROUND_S:
        return "s", 0.65, f"{said}: s"
    if high - low < _SHORTEST_S:
        return "s", 0.4, f"{said}, {high - low:.4g} in all: too short for s, so it may be min or h"
    if entry.whole and 10 <= step < 100:
        sure = 0.65 if step in (10, 15, 20, 30) and len(set(rising.tolist())) <= 3 else 0.45
        return "s", sure, f"{said} and whole: s or ms"
    if 1e-3 <= step <= 60.0:
        return "s", 0.8, f"{said}: s"
    return "s", 0.4, f"{said}: no unit is likely"


def short_in_seconds(evidence: Evidence, form: TimeForm, choices: Choices) -> str:
    """What is said of a time that nothing says to be in seconds, where the log would then be short; else empty.

    Parameters
    ----------
    evidence
        The columns.
    form
        What was decided.
    choices
        What the user says.
    """
    if form.unit != "s" or not form.columns or {form.columns[0], "time_s"} & set(choices.units):
        return ""
    entry = evidence.facts[form.columns[0]]
    low, high = entry.span
    base, unit, _ = entry.named
    said = unit is not None or unit_of(base) is not None or base.casefold() in _IN_SECONDS or bool(epoch_of(entry))
    said = said or seconds_since(low) is not None
    rising = entry.steps[entry.steps > 0]
    step = float(np.median(rising)) if rising.size else 0.0
    if said or high - low >= (_SHORT_ONE_BY_ONE_S if entry.whole and step == 1.0 else _SHORT_S):
        return ""
    others = [
        (name, scale) for name, scale, least_s in _SLOWER if step * scale >= least_s and step * scale <= _SLOWEST_S
    ]
    if not others:
        return ""
    shown = ", ".join(
        f"{quoted(f'{entry.name}={name}')} ({_lasting((high - low) * scale)}, a row every {_lasting(step * scale)})"
        for name, scale in others
    )
    return (
        f"{entry.name}: has no unit; taken for s it lasts {_lasting(high - low)}, a row every {_lasting(step)}, which "
        f"is short for a motor's temperature; if it is not s: --unit {shown}; if it is: --unit "
        f"{quoted(f'{entry.name}=s')}"
    )


def _lasting(seconds: float) -> str:
    """A time in the unit in which people say it."""
    return next(f"{seconds / scale:.4g} {name}" for scale, name in _SPOKEN if seconds >= 2 * scale or scale == 1.0)
