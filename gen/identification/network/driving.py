"""Measured columns that heat a motor beside its PWM: a current, another heater's power, a torque."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray
from gen.errors import InputError
from gen.identification.logs.sources import Source
from gen.runs.gaps import held_over_gaps

_WRITTEN = re.compile(r"(?P<column>[A-Za-z]\w*?)(\^(?P<power>[12]))?", re.ASCII)
_SQUARED = ("_A", "_Nm")
"""Ends of the names of what heats with its square: a current, and a torque, which goes with one."""
MARGIN = 0.25
"""Of a column's largest value: so much beyond it the model is declared good for it."""
NOISE = 0.05
"""Of a column's largest value: a meter of what is never below zero may read so much below it."""


@dataclass(frozen=True)
class Driving:
    """One column.

    Attributes
    ----------
    column
        Its name.
    power
        1 or 2: heat goes with the value or with its square.
    low, high
        Least and largest value in all runs; `low` is 0 where heat goes with the value and a meter read a little below.
    """

    column: str
    power: int
    low: float
    high: float

    @property
    def largest(self) -> float:
        """Of |value|."""
        return max(abs(self.low), abs(self.high))

    @property
    def range(self) -> tuple[float, float]:
        """What the model is told at most."""
        beyond = MARGIN * self.largest
        return (self.low - beyond if self.low < 0.0 else 0.0, self.high + beyond)

    def share(self, values: FloatArray) -> FloatArray:
        """Heat as a share of that at the largest value, shape as the values; what is below `low` is a meter's noise."""
        return np.asarray((np.maximum(values, self.low) / self.largest) ** self.power)


def driving_of(sources: Sequence[Source], heat: Sequence[str]) -> tuple[Driving, ...]:
    """Find the columns in all runs.

    Parameters
    ----------
    sources
        The runs.
    heat
        Columns as a person writes them: ``current_A``, ``heater2_percent``, ``drag_N^2``.

    Raises
    ------
    InputError
        When one is written otherwise, is not in every run, never changes, or is negative although heat goes with it.
    """
    written = [_written(text) for text in heat]
    if len(set(written)) < len(written):
        twice = next(one for k, one in enumerate(written) if one in written[:k])
        raise InputError(f"found '{twice[0]}^{twice[1]}' twice, expected it once", place="--heat")
    linear = {column for column, power in written if power == 1}
    return tuple(_measured(sources, column, power, is_linear=column in linear) for column, power in written)


def _written(text: str) -> tuple[str, int]:
    """Column and power as a person writes them."""
    found = _WRITTEN.fullmatch(text)
    if found is None:
        raise InputError(f"found {text!r}, expected a column such as current_A or heater2_W^1", place="--heat")
    column = found.group("column")
    return column, int(found.group("power") or (2 if column.endswith(_SQUARED) else 1))


def _measured(sources: Sequence[Source], column: str, power: int, *, is_linear: bool) -> Driving:
    """What the runs hold of a column; `is_linear`: heat goes with its value, be it beside its square."""
    known = [values_of(source, column) for source in sources]
    one = Driving(column, power, min(float(v.min()) for v in known), max(float(v.max()) for v in known))
    if one.low == one.high:
        raise InputError(f"column {column} is {one.low:g} in every row of every run: it tells nothing", place="--heat")
    if is_linear and one.low < -NOISE * one.high:
        raise InputError(
            f"column {column} goes down to {one.low:g}, and no heat is below 0: expected another column, or {column}^2",
            place="--heat",
        )
    return replace(one, low=max(one.low, 0.0)) if is_linear else one


def values_of(source: Source, column: str) -> FloatArray:
    """Give a run's column without gaps: the last value stays, shape (rows,).

    Raises
    ------
    InputError
        When the run does not have it.
    """
    if column in {f"{part}_degC" for part in source.run.temps}:
        raise InputError(
            f"found the temperature {column}, which gives no heat itself; expected another column. If it is of what "
            "the motor stands in or is cooled by, it is the ambient: name it ambient_degC",
            file=source.path,
        )
    values = source.run.extras.get(column)
    if values is None or not np.isfinite(values).any():
        held = ", ".join(sorted(source.run.extras)) or "none beside temperatures and PWM"
        raise InputError(
            f"found no values of {column}, which is to heat the motor; its columns: {held}", file=source.path
        )
    return held_over_gaps(values)
