"""What is proven of a recursion: ranges and an error bound."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, log10
from typing import Any


@dataclass(frozen=True)
class Proof:
    """What is guaranteed for every PWM sequence in the declared domain, of any length.

    Attributes
    ----------
    rise_range_K
        Lowest and highest temperature rise that the board's state can reach.
    increment_range_K
        Largest magnitude of x2..xn, in K per sample^k.
    bound_K
        Largest possible difference between the board's temperature rise and the exact solution of the
        differential equation: rounding, coefficients, form and output together.
    """

    rise_range_K: tuple[float, float]
    increment_range_K: tuple[float, ...]
    bound_K: float

    def describe(self) -> dict[str, Any]:
        """The proof for the manifest, rounded outwards."""
        return {
            "rise_range_K": [floor(self.rise_range_K[0]), ceil(self.rise_range_K[1])],
            "increment_range_K": [rounded_up(value) for value in self.increment_range_K],
            "bound_K": rounded_up(self.bound_K),
        }


def rounded_up(value: float) -> float:
    """A positive value with two significant digits, not below it."""
    if value <= 0.0:
        return 0.0
    step = 10.0 ** (floor(log10(value)) - 1)
    return float(f"{ceil(value / step * (1.0 - 1e-9)) * step:.2g}")
