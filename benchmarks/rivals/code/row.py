"""What is measured of one way to have the model on the board."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.rivals.code.profiles import NAMES
from gen.verification.profiles import Profile


@dataclass(frozen=True)
class Row:
    """One row of the table.

    Attributes
    ----------
    title, lacks
        As the table has them.
    error_K
        By profile and part, the largest error along the run, K; infinite where the model left all bounds.
    proven_K
        The largest error of any part that is proven, or None.
    cycles_held, cycles_change
        Most cycles of a step at the PWM of the sample before, and at another.
    flash_bytes, ram_bytes, stack_bytes
        Of the model alone.
    equal
        Whether the board computed what its reference does, bit for bit.
    missing
        Why nothing was measured.
    """

    title: str
    lacks: str
    error_K: dict[str, dict[str, float]] = field(default_factory=dict)
    proven_K: float | None = None
    cycles_held: int = 0
    cycles_change: int = 0
    flash_bytes: int = 0
    ram_bytes: int = 0
    stack_bytes: int = 0
    equal: bool = False
    missing: str | None = None


def errors(rises: NDArray[np.float64], exact: dict[str, NDArray[np.float64]]) -> dict[str, dict[str, float]]:
    """Compare rises, shape (L, N, components), with exact ones, shape (L, N + 1) each; by profile and part, K."""
    found = {}
    for lane, profile in enumerate(NAMES):
        found[profile] = {
            name: _largest(rises[lane, :, number] - truth[lane, 1:])
            for number, (name, truth) in enumerate(exact.items())
        }
    return found


def _largest(error: NDArray[np.float64]) -> float:
    return float(np.abs(error).max()) if np.all(np.isfinite(error)) else float("inf")


def held_and_changed(profile: Profile, cycles: NDArray[np.int64]) -> tuple[int, int]:
    """Give most cycles of a step at the PWM of the sample before, and at another."""
    magnitude = np.abs(profile.pwm)
    changed = np.ones(magnitude.shape, dtype=bool)
    changed[:, 1:] = magnitude[:, 1:] != magnitude[:, :-1]
    return int(cycles[~changed].max()), int(cycles[changed].max())
