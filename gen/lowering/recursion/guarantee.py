"""What is proven of a recursion: ranges and an error bound."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil, floor, log10
from typing import Any

from gen.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Invariant:
    """The polytopes that a proof rests on, in the true state's coordinates (T, Ts T', Ts^2 T'', ..), Ts of a substep.

    Attributes
    ----------
    directions
        One row c for each pair of faces, shape (J, n), in K per K of the state's coordinates.
    reach
        Largest ``|c . (z - (centre, 0, ..))|`` of the state z, shape (J,), in K.
    error
        Largest ``|c . (y - z)|`` of the disturbed copy y of the state that the board follows, shape (J,), in K.
    centre
        Rise about which the state's polytope lies, in K.
    map
        How the true state becomes the board's but for the share of q that is carried, shape (n, n).
    shape
        The directions times this are unit vectors, among whose hull's facets they combine, shape (n, n).
    """

    directions: FloatArray
    reach: FloatArray
    error: FloatArray
    centre: float
    map: FloatArray
    shape: FloatArray


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
    invariant
        What a checker can prove the same from.
    """

    rise_range_K: tuple[float, float]
    increment_range_K: tuple[float, ...]
    bound_K: float
    invariant: Invariant = field(compare=False, repr=False)

    def describe(self) -> dict[str, Any]:
        """The proof for the manifest, rounded outwards."""
        return {
            "rise_range_K": [floor(self.rise_range_K[0]), ceil(self.rise_range_K[1])],
            "increment_range_K": [rounded_up(value) for value in self.increment_range_K],
            "bound_K": rounded_up(self.bound_K),
        }


def rounded_up(value: float, digits: int = 2) -> float:
    """A positive value with so many significant digits, not below it (but for what float64 hides)."""
    if value <= 0.0:
        return 0.0
    step = 10.0 ** (floor(log10(value)) + 1 - digits)
    return float(f"{ceil(value / step * (1.0 - 1e-9)) * step:.{digits}g}")
