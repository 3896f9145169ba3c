"""What a run's PWM stands for, where another quantity drove the machine: a comment line of an imported run."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Literal, get_args

FULL_COUNTS = 255
"""Count that an imported run's full scale becomes."""
COUNTS = "counts"
"""Unit of an input that is a PWM already."""
OWN_UNIT = "of its own unit"
"""Unit of an input of which nothing said one."""

WHOLE = {COUNTS: float(FULL_COUNTS), "percent": 100.0, "permille": 1000.0, "duty": 1.0}
"""Units of a share, and all of it in each: to say half is the same in any of them."""

COMMENT = "input"
MACHINE_COMMENT = "drives"
Machine = Literal["motor", "heater"]
"""What an input drives: a motor moves air and makes heat in ways of its own, a heater does neither."""
MACHINES: tuple[Machine, ...] = get_args(Machine)
_FORM = re.compile(rf"(.+), {FULL_COUNTS} = ([0-9][0-9.e+-]*) (.+?)(?:, 0 = (-?[0-9][0-9.e+-]*))?(?:, sign of (.+))?")


@dataclass(frozen=True)
class Drive:
    """What the column ``pwm`` was made of.

    Parameters
    ----------
    quantity
        The log's column.
    unit
        Of its values.
    full_scale
        The value that became 255 counts, in that unit.
    sign
        The column that gave the direction, or nothing.
    rest
        The value that became 0 counts, in that unit: 4 of a signal of 4 to 20 mA.
    """

    quantity: str
    unit: str
    full_scale: float
    sign: str = ""
    rest: float = 0.0

    @property
    def is_pwm(self) -> bool:
        """Whether it was the PWM itself, in counts: then there is nothing to tell."""
        return self.unit == COUNTS and self.rest == 0.0

    def agrees(self, other: Drive) -> bool:
        """Whether counts of both mean the same, as far as runs tell it: names differ between loggers."""
        alike = (self.unit, self.full_scale, self.rest) == (other.unit, other.full_scale, other.rest)
        return alike or (self._is_whole and other._is_whole)

    def remedy(self, other: Drive) -> str:
        """What makes runs of both agree, where one has no unit and all else is alike; empty where nothing does.

        Parameters
        ----------
        other
            That of the other run.
        """
        if (self.full_scale, self.rest) != (other.full_scale, other.rest) or OWN_UNIT not in (self.unit, other.unit):
            return ""
        bare, unit = (self, other.unit) if self.unit == OWN_UNIT else (other, self.unit)
        shown = shlex.quote(f"{bare.quantity}={unit}")
        return f"; where {bare.quantity} is in {unit}, too: import it with --unit {shown}"

    @property
    def _is_whole(self) -> bool:
        return WHOLE.get(self.unit) == self.full_scale and self.rest == 0.0

    def text(self) -> str:
        """The comment's value."""
        sign = f", sign of {self.sign}" if self.sign else ""
        rest = f", 0 = {self.rest:g}" if self.rest else ""
        return f"{self.quantity}, {FULL_COUNTS} = {self.full_scale:g} {self.unit}{rest}{sign}"


def drive_of(comments: Mapping[str, str]) -> Drive | None:
    """What a run file says of its input; None where it says nothing, or what nobody but its author can read."""
    found = _FORM.fullmatch(comments.get(COMMENT, ""))
    if found is None:
        return None
    quantity, value, unit, at_rest, sign = found.groups(default="")
    try:
        full_scale, rest = float(value), float(at_rest or 0.0)
    except ValueError:
        return None
    if not isfinite(full_scale) or full_scale <= max(rest, 0.0):
        return None
    return Drive(quantity, unit, full_scale, sign, rest)
