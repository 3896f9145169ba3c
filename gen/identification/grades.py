"""What a user would accept of a model: errors graded by size, by share of the rise, and by the sensor's noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

GOOD_K, FAIR_K = 1.0, 5.0
"""Errors up to which a model is good, and up to which it is fair: about what a thermocouple itself may be off by, and
about the distance that limits keep from what a part can bear."""
SHARE = 0.1
"""Of what a part moves by in the runs: a model that misses more of it is neither."""
NOISES = 3.0
"""Times its sensor's scatter: up to so much a share says nothing of the model. Kelvins stay kelvins: what scatters may
be the part itself, where the input switches between two rows, or a sensor that jumps."""


class Grade(IntEnum):
    """How good a model is, the best first."""

    GOOD = 0
    FAIR = 1
    BAD = 2


@dataclass(frozen=True)
class Miss:
    """By how much a model misses one part.

    Attributes
    ----------
    name
        The part's.
    error_K
        Root mean square, K.
    moved_K
        By how much the part moves in the runs, K.
    noise_K
        Standard deviation of a single reading of its sensor, K.
    """

    name: str
    error_K: float
    moved_K: float
    noise_K: float

    @property
    def grade(self) -> Grade:
        """What a user would say of it."""
        shown = self.error_K > NOISES * self.noise_K
        if self.error_K > FAIR_K or (shown and self.error_K > SHARE * self.moved_K):
            return Grade.BAD
        return Grade.FAIR if self.error_K > GOOD_K else Grade.GOOD

    @property
    def sized(self) -> str:
        """The error, beside what the part moves by and what its sensor scatters by."""
        share = f"{self.error_K / self.moved_K:.0%} of what it moves by" if self.moved_K > 0.0 else "it does not move"
        times = f", {self.error_K / self.noise_K:.0f} times its sensor's scatter" if self.noise_K > 0.0 else ""
        return f"{self.error_K:.2g} K ({share}{times})"


def worse_than(grade: Grade, misses: Sequence[Miss]) -> list[Miss]:
    """Give those that are worse than a grade."""
    return [miss for miss in misses if miss.grade > grade]


def told(misses: Sequence[Miss]) -> str:
    """Give parts with their errors, as a part of a sentence."""
    return ", ".join(f"{miss.name} by {miss.sized}" for miss in misses)
