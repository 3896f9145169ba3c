"""One component in fixed point, as the templates print it and the reference executes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gen.arrays import IntArray
from gen.lowering.fixed.formats import Format
from gen.lowering.recursion.guarantee import Proof


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
    unproven
        Why there is no proof.
    """

    name: str
    order: int
    substeps: int
    layout: Format
    rates: IntArray
    steady: IntArray
    start_range_mK: tuple[int, int]
    proof: Proof | None
    unproven: str = ""

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
