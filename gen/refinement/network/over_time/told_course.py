"""What a course over time is like, in words for a user."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gen.refinement.network.effects.base import WHOLE
from gen.refinement.network.over_time.courses import Course
from gen.refinement.network.over_time.uneven import Uneven

AT_ONCE_H = 0.3
"""Into a run up to which a change is told as since it."""


def told(found: Uneven, course: Course, names: Sequence[str]) -> str:
    """Say what is uneven, for a user.

    Parameters
    ----------
    found
        What the course is like.
    course
        What it is, and where.
    names
        Of the runs.

    Returns
    -------
    str
        Empty where it goes with speed.
    """
    if found.pattern == "even":
        return ""
    place = "the motor" if course.component == WHOLE else course.component
    said = _heat(found, names) if course.quantity == "heat" else _cooling(found, names, course.usual)
    return f"{place}: {said}"


def _heat(found: Uneven, names: Sequence[str]) -> str:
    """Heat that is missing, W."""
    known = f"(each known to {found.deviation:.2g} W, as the file counts watts: temperatures do not tell their scale)"
    if found.pattern == "since":
        return (
            f"since {_when(found, names)} another heat is missing at the same speed than before, by "
            f"{found.high - found.low:.2g} W {known}: the motor, what it drives or what cools it has changed. "
            "Refine the runs before and after it apart"
        )
    each = _each(found, names, "W")
    if found.pattern == "grows":
        return (
            f"the heat that is missing at the same speed goes one way from run to run ({each}, against their "
            "mean): something wears, gathers dust, or is loaded ever more. It is no property of the motor that all "
            "runs share"
        )
    if found.pattern == "by run":
        return (
            f"the heat that is missing at the same speed is another one in each run ({each}, against their "
            "mean): something was otherwise that no column holds (a fan, a load, the supply, how it was mounted). Log "
            "it, or refine the runs that are alike apart"
        )
    return (
        f"what is missing comes and goes like a heat from {found.low:+.2g} to {found.high:+.2g} W about "
        f"its mean at each speed {known}, and nothing in the columns goes with it: a load, a fan, the sun, a "
        "neighbour, or a part that sticks at times. No number of the file can be that: log it (a motor's current "
        "tells its load) and refine again. The report draws it over time"
    )


def _cooling(found: Uneven, names: Sequence[str], usual: float) -> str:
    """Conductance to the ambient that is missing, W/K."""
    known = f"(each known to {found.deviation:.2g} W/K; of the {usual:.2g} W/K that the whole motor has to the ambient)"
    if found.pattern == "since":
        return (
            f"since {_when(found, names)} it is cooled otherwise at the same speed than before, by "
            f"{found.high - found.low:.2g} W/K {known}: moving air, or how it is mounted. Refine the "
            "runs before and after it apart"
        )
    each = _each(found, names, "W/K")
    if found.pattern == "grows":
        return (
            f"the cooling at the same speed goes one way from run to run ({each}, against their mean): a fan that "
            "blows ever more or less. It is no property of the motor that all runs share"
        )
    if found.pattern == "by run":
        return (
            f"the cooling at the same speed is another one in each run ({each}, against their mean): something was "
            "otherwise that no column holds (a fan, how it was mounted). Log it, or refine the runs that are alike "
            "apart"
        )
    return (
        f"cooling comes and goes, from {found.low:+.2g} to {found.high:+.2g} W/K about its mean at each speed {known}, "
        "and nothing in the columns goes with it: moving air, or a load that is less at times. No number of the file "
        "can be that: log it and refine again. The report draws it over time"
    )


def _when(found: Uneven, names: Sequence[str]) -> str:
    assert found.since is not None
    run, earliest_h, latest_h = found.since
    return (f"{earliest_h:.1f} to {latest_h:.1f} h into " if latest_h > AT_ONCE_H else "") + Path(names[run]).name


def _each(found: Uneven, names: Sequence[str], unit: str) -> str:
    each = zip(names, found.levels, strict=True)
    return ", ".join(f"{Path(name).name} {level:+.2g} {unit}" for name, level in each)
