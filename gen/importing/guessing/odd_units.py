"""Numbers that are hardly in the unit that their column says."""

from __future__ import annotations

from gen.importing.guessing.evidence import Facts
from gen.importing.units import Unit

_HOT_C, _HOTTEST_C = 200.0, 700.0
_COLDEST_K = 150.0
_VOLTS = 3.0
"""What stays between 0 and it is rather what a sensor's amplifier gives than degC."""


def odd_in(unit: Unit, facts: Facts, begin: float) -> str:
    """Why a motor's temperature is hardly in a unit; empty where it may be.

    Parameters
    ----------
    unit
        What the column says.
    facts
        The column.
    begin
        Where it begins.
    """
    low, high = facts.span
    if unit.name == "K" and begin < _COLDEST_K:
        return f"begins at {begin:.4g}, which is no temperature in K"
    if unit.name != "degC":
        return ""
    if begin > _HOT_C and high < _HOTTEST_C:
        return f"begins at {begin:.4g}, which is rather K than degC"
    if begin > _HOT_C and low != high:
        return f"begins at {begin:.4g}, which is no cold motor in degC"
    return f"{low:.4g}..{high:.4g}, which is rather V than degC" if 0.0 < low != high < _VOLTS else ""
