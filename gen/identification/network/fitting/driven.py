"""What is known of curves over an input that is no motor's PWM.

A power is what heats, and a share of a heater is one of its power. A current heats by its square, where it flows
through a resistance, and so does a heater's voltage. And none of them moves air, as a motor that turns does:
conductances are those at rest. All of that is a prior that runs may overrule, not a law: a motor whose current was
logged turns, too.
"""

from __future__ import annotations

from collections.abc import Iterator

from gen.identification.network.fitting.speed_laws import HEAT, OUTSIDE, WITHIN
from gen.identification.network.fitting.structure import Structure
from gen.runs.drive import Drive

POWER, CURRENT = "power", "current"
"""What heats go with: the input, or its square."""
_KINDS = {"W": POWER, "kW": POWER, "mW": POWER, "A": CURRENT, "mA": CURRENT}
_HEATER_KINDS = {**_KINDS, "V": CURRENT, "mV": CURRENT}
"""By the unit of an input, as a run file names it."""
UNSURE = 1.5
"""Standard deviation of a logarithm of shares."""
NEXT_TO_NOTHING, MOST_OF_IT = -5.0, 5.0
"""Logarithms of a heat's share over its linear one."""
NO_AIR = -4.0
"""Logarithm of what the input adds to a conductance over what there is at rest."""
SAME = 0.1
"""Standard deviation of the logarithm by which conductances differ at rest and at any input."""


def kind_of(drive: Drive | None, machine: str) -> str:
    """Give what heats go with; nothing for a motor.

    Parameters
    ----------
    drive
        What the input is, where runs say it.
    machine
        What it drives, where that is said: it counts more than a unit.
    """
    unit = "" if drive is None else drive.unit
    if machine == "heater":
        return _HEATER_KINDS.get(unit, POWER)
    return "" if machine else _KINDS.get(unit, "")


def known(structure: Structure) -> Iterator[tuple[int, float, float]]:
    """Give numbers whose prior is another one: place, mean and standard deviation; none for a motor's PWM."""
    if structure.driven not in (POWER, CURRENT):
        return
    square = MOST_OF_IT if structure.driven == CURRENT else NEXT_TO_NOTHING
    for at in structure.heats:
        yield at.start + HEAT.terms.index("steady"), NEXT_TO_NOTHING, UNSURE
        yield at.start + HEAT.terms.index("square"), square, UNSURE
    for law, at in zip(structure.laws, structure.conductances, strict=True):
        if law is OUTSIDE:
            yield at.start + law.terms.index("at rest"), 0.0, SAME
            yield at.start + law.terms.index("moved"), NO_AIR, UNSURE
        elif law is WITHIN:
            yield at.start + law.terms.index("slope"), 0.0, SAME
