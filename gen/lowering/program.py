"""What the board holds: the one description that the templates print and the reference simulators execute."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, log10
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gen.lowering.formats import Format

Arithmetic = Literal["fixed", "float"]
ScheduleKind = Literal["table", "onboard"]
Integers = NDArray[np.int64]


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


@dataclass(frozen=True)
class FixedComponent:
    """One component in fixed point.

    Attributes
    ----------
    name, order
        From the coefficient file.
    substeps
        How many times the recursion runs in one sample (its rates are for Ts / substeps).
    layout
        The formats.
    rates
        Integers R[i] * 2^rate_fraction_bits[i] for each row of the domain, shape (rows, n), 0 <= R < 2^32.
    steady
        Integers S * 2^(fraction_bits[0] - 16), rounded down, shape (rows,).
    start_range_mK
        Lowest and highest rise to start from, in thousandths of a kelvin; others are limited and flagged.
    proof
        None if no range could be proven: then every addition saturates and is counted.
    """

    name: str
    order: int
    substeps: int
    layout: Format
    rates: Integers
    steady: Integers
    start_range_mK: tuple[int, int]
    proof: Proof | None

    @property
    def saturates(self) -> bool:
        """Whether the additions saturate because no range could be proven."""
        return self.proof is None

    @property
    def carries(self) -> bool:
        """Whether a change of PWM hands q/12 over (the carried form of orders 2 to 4)."""
        return self.order > 1 and not self.layout.corrected

    def describe(self) -> dict[str, Any]:
        """Formats and proof for the manifest; numbers from linear algebra rounded to two digits, upwards."""
        return {
            "name": self.name,
            "order": self.order,
            "substeps": self.substeps,
            "state_fraction_bits": list(self.layout.fraction_bits),
            "rate_fraction_bits": list(self.layout.rate_fraction_bits),
            "product_shifts": list(self.layout.product_shifts),
            "start_range_mK": list(self.start_range_mK),
            "proof": self.proof.describe() if self.proof else None,
        }


@dataclass(frozen=True)
class FixedProgram:
    """The whole model in fixed point; row r of every table is |PWM| = domain_pwm[0] + r."""

    domain_pwm: tuple[int, int]
    components: tuple[FixedComponent, ...]
