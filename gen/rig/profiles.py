"""What PWM is commanded when."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

FULL_SCALE = 255  #: Counts of full PWM.


@dataclass(frozen=True)
class Profile:
    """Levels held one after the other.

    Attributes
    ----------
    starts_s
        When each level begins; the first at 0, increasing.
    levels
        PWM, -255..255.
    duration_s
        When the last level ends.
    """

    starts_s: tuple[float, ...]
    levels: tuple[int, ...]
    duration_s: float

    def __post_init__(self) -> None:
        if not self.levels or len(self.starts_s) != len(self.levels) or self.starts_s[0] != 0.0:
            raise ValueError("a profile needs as many starts as levels, the first start at 0")
        ends = (*self.starts_s[1:], self.duration_s)
        if not all(a < b for a, b in zip(self.starts_s, ends, strict=True)):
            raise ValueError("a profile's starts and its duration must increase")
        if any(not -FULL_SCALE <= level <= FULL_SCALE for level in self.levels):
            raise ValueError(f"a profile's levels must be within -{FULL_SCALE}..{FULL_SCALE}")

    def at(self, time_s: float) -> int:
        """PWM at a time; after the end the last level."""
        return self.levels[max(0, bisect_right(self.starts_s, time_s) - 1)]

    def then(self, other: Profile) -> Profile:
        """Put another profile behind this one."""
        later = tuple(self.duration_s + start for start in other.starts_s)
        return Profile(self.starts_s + later, self.levels + other.levels, self.duration_s + other.duration_s)


def counts(percent: float) -> int:
    """PWM of a speed in percent of the rated one; the sign is kept."""
    return round(percent / 100.0 * FULL_SCALE)


def staircase(levels: Sequence[int], hold_s: float) -> Profile:
    """Hold each level equally long."""
    return Profile(tuple(k * hold_s for k in range(len(levels))), tuple(levels), len(levels) * hold_s)


def step(pwm: int, duration_s: float = 10_800.0) -> Profile:
    """Hold one level: the study's experiment."""
    return staircase([pwm], duration_s)


def cut_off(pwm: int, heat_s: float = 7200.0, cool_s: float = 3600.0) -> Profile:
    """Run, then stop and cool."""
    return step(pwm, heat_s).then(step(0, cool_s))


def random_levels(
    seed: int,
    duration_s: float = 10_800.0,
    hold_s: tuple[float, float] = (300.0, 1800.0),
    low: int = 26,
    high: int = FULL_SCALE,
) -> Profile:
    """Hold uniformly random levels of ``low..high`` for uniformly random times."""
    random = np.random.default_rng(seed)
    starts, levels, t = [], [], 0.0
    while t < duration_s:
        starts.append(t)
        levels.append(int(random.integers(low, high + 1)))
        t += float(round(random.uniform(*hold_s)))
    return Profile(tuple(starts), tuple(levels), duration_s)
