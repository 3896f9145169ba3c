"""One component in float32, as the templates print it and the reference executes it."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.arrays import IntArray, SingleArray
from gen.lowering.recursion.guarantee import Proof

#: Bits of an accumulator below its 32-bit word.
LOW_BITS = 8
#: Without a proof a word stops at 2^30, so that no difference or sum of two leaves 32 bits.
LIMIT_BITS = 30
#: A steady rise that is computed on board is a multiple of this power of two of its unit: 2^23 of them span the word.
ONBOARD_STEADY_SHIFT = 9
#: Share of q that x[n-1] carries (:data:`gen.lowering.recursion.increments.CARRY`) in float32.
CARRY = np.float32(1.0 / 12.0)


@dataclass(frozen=True)
class FloatComponent:
    """One component in float32.

    Attributes
    ----------
    name, order
        From the coefficient file.
    substeps
        How many times the recursion runs in one sample (its rates are for Ts / substeps).
    fraction_bits
        F of x1 .. xn, not decreasing: a word w of x[i] means w * 2^-F[i] K (per sample^(i-1)).
    rates
        R0 .. R[n-1] for each row of the domain, shape (rows, n), dimensionless.
    steady
        S as words with the fraction bits of x1, shape (rows,).
    start_range_mK
        Lowest and highest rise to start from, in thousandths of a kelvin; others are limited and flagged.
    proof
        None if no range could be proven.
    unproven
        Why there is no proof.
    """

    name: str
    order: int
    substeps: int
    fraction_bits: tuple[int, ...]
    rates: SingleArray
    steady: IntArray
    start_range_mK: tuple[int, int]
    proof: Proof | None
    unproven: str = ""

    @property
    def saturates(self) -> bool:
        """Whether the accumulators stop at their ends because no range could be proven."""
        return self.proof is None

    @property
    def chain_shifts(self) -> tuple[int, ...]:
        """By how many bits the unit of x[i+1] is finer than that of x[i], length n - 1."""
        return tuple(b - a for a, b in itertools.pairwise(self.fraction_bits))

    @property
    def rate_words(self) -> SingleArray:
        """The rates as the board multiplies with them: from one word's unit to the next one's, shape (rows, n)."""
        scale = np.float32(2.0) ** np.array([*self.chain_shifts, 0], dtype=np.float32)
        result: SingleArray = self.rates * scale
        return result

    @property
    def carry_factor(self) -> np.float32:
        """1/12 from the unit of q (that of xn) to the unit of x[n-1] (orders 2 to 4)."""
        return np.float32(CARRY * np.float32(2.0 ** -self.chain_shifts[-1]))

    @property
    def steady_constant(self) -> np.float32:
        """In K: in a sum with it, any S has the exponent of this one, so that its bits are a fixed-point number."""
        return np.float32(1.5 * 2.0 ** (23 + ONBOARD_STEADY_SHIFT - self.fraction_bits[0]))

    def steady_words(self, kelvins: SingleArray) -> IntArray:
        """S as the board converts it where it computes S itself: to multiples of 2^9 units."""
        bits = np.asarray(kelvins + self.steady_constant, dtype=np.float32).view(np.int32).astype(np.int64)
        result: IntArray = bits - int(self.steady_constant.view(np.int32)) << ONBOARD_STEADY_SHIFT
        return result

    def describe(self) -> dict[str, Any]:
        """Formats and proof for the manifest."""
        return {
            "name": self.name,
            "order": self.order,
            "substeps": self.substeps,
            "word_fraction_bits": list(self.fraction_bits),
            "start_range_mK": list(self.start_range_mK),
            "proof": self.proof.describe() if self.proof else None,
        }

    @staticmethod
    def literal(value: float) -> str:
        """A float32 in C++ source: 9 significant digits determine it (gnu++11 has no hexadecimal floats)."""
        text = f"{np.float32(value):.9g}"
        return f"{text if set(text) & set('.e') else text + '.0'}f"
