"""A course over time at one place, run by run, and blocks of five minutes of which it consists."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.network.fitting.inputs import Inputs

BLOCK_S, MOST_BLOCKS = 300.0, 400
"""Length of a block, and how many all runs together may have: then blocks are longer."""
Quantity = Literal["heat", "conductance"]
UNITS: dict[Quantity, str] = {"heat": "W", "conductance": "W/K"}


@dataclass(frozen=True, eq=False)
class RunCourse:
    """One run's course, block by block, shape (k,) each.

    Attributes
    ----------
    run
        Which of the later runs.
    time_s
        The middles of the blocks, from the run's first row.
    value, deviation
        What is missing, and its standard deviation: W of heat, or W/K of a conductance.
    turning
        The share of the block in which the motor turns.
    speed
        Mean |PWM| over full scale while it does.
    """

    run: int
    time_s: FloatArray
    value: FloatArray
    deviation: FloatArray
    turning: FloatArray
    speed: FloatArray


@dataclass(frozen=True, eq=False)
class Course:
    """What is missing at one place, over all runs.

    Attributes
    ----------
    quantity
        Heat, in W, or a conductance to the ambient, in W/K.
    component
        A node, or the whole motor.
    likelihood
        Logarithm of the readings' likelihood with it, but for a constant that all courses of the same runs share.
    evidence
        By how much that is more than without any course.
    left
        Weighed squares that are left with it, over those without.
    runs
        The later runs.
    usual
        The mean that the network has of the same while the motor turns: of a conductance there, of heat in all.
    """

    quantity: Quantity
    component: str
    likelihood: float
    evidence: float
    left: float
    runs: tuple[RunCourse, ...]
    usual: float

    @property
    def unit(self) -> str:
        """Of its values."""
        return UNITS[self.quantity]


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of one run: its bins, the block of each, and where the first block stands among all."""

    rows: IntArray
    block: IntArray
    first: int
    count: int

    @property
    def at(self) -> slice:
        """Its blocks among those of all runs."""
        return slice(self.first, self.first + self.count)

    def mean(self, values: FloatArray, weight: FloatArray) -> FloatArray:
        """Average over each block, values and weights by bin; 0 where all weights are."""
        total = np.bincount(self.block, weight, self.count)
        return np.asarray(np.bincount(self.block, values * weight, self.count) / np.maximum(total, 1e-9))

    def course(self, number: int, inputs: Inputs, value: FloatArray, deviation: FloatArray) -> RunCourse:
        """Give the run's part of the values of all blocks."""
        width, turns = inputs.width[self.rows], 1.0 - inputs.rest[self.rows]
        return RunCourse(
            number,
            self.mean(inputs.begins[self.rows] + 0.5 * width, width),
            value[self.at],
            deviation[self.at],
            self.mean(turns, width),
            self.mean(inputs.speed[self.rows], turns * width),
        )


def blocks_of(inputs: Inputs, later: int) -> list[Blocks]:
    """Cut the later runs, which come first, into blocks; none is cut where no bin's middle lies."""
    length = max(BLOCK_S, sum(run.duration for run in inputs.runs[:later]) / MOST_BLOCKS)
    made: list[Blocks] = []
    first = 0
    for rows in inputs.rows[:later]:
        middle = inputs.begins[rows] + 0.5 * inputs.width[rows]
        distinct, block = np.unique((middle // length).astype(np.int64), return_inverse=True)
        made.append(Blocks(rows, np.ravel(block), first, distinct.size))
        first += distinct.size
    return made


def along(blocks: Sequence[Blocks], values: FloatArray, bins: int) -> FloatArray:
    """Give the value of each bin's block, shape (N,); 0 in runs that have none."""
    made = np.zeros(bins)
    for one in blocks:
        made[one.rows] = values[one.at][one.block]
    return made
