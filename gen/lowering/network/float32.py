"""A network in float32: states are whole numbers, sums are float32 in units of what is read of a state.

A state is a 40-bit word of 2^-(8 + f) degC, of which the upper 32 bits are read; differences are taken in whole
numbers, and so cost no digits. The standard model of rounding applies to the rest (Higham, Accuracy and Stability of
Numerical Algorithms, 2.2 and 3.1).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.network.defect import Roundings
from gen.lowering.network.factors import FactorProgram
from gen.lowering.network.laws import LawProgram
from gen.lowering.network.program import HeatProgram, TermProgram
from gen.lowering.network.ranges import Ranges
from gen.lowering.network.terms import Term, Terms

LOW_BITS = 8
"""Of a state's word below what is read."""
UNIT = 2.0**-24
"""Unit roundoff of float32."""
_AMBIENT = 1.75
_REFERENCE = 1.5


def term_program(term: Term, bits: int) -> TermProgram:
    """A term's rate as float32."""
    return TermProgram(term, term.rate.astype(np.float32), round(term.reference * 2.0**bits))


def heat_programs(terms: Terms, target: int, bits: int) -> list[HeatProgram]:
    """A state's heats, in words of a state per sample."""
    return [HeatProgram(heat, (heat.heat * 2.0**bits).astype(np.float32), 0) for heat in terms.heats_of(target)]


def roundings(
    terms: Terms,
    ranges: Ranges,
    bits: int,
    factors: tuple[FactorProgram, ...],
    first: FloatArray,
    orders: int,
    laws: Sequence[LawProgram] = (),
) -> Roundings:
    """What float32 does; `first` bounds y1, K, shape (rows, n)."""
    lsb = 2.0**-bits

    def relative(own: tuple[int, ...]) -> float:
        return sum(factors[k].error / max(float(terms.spans[k, 1]), 1e-30) + 2.0 * UNIT for k in own)

    def rate(order: int, term: Term) -> FloatArray:
        largest = term.rate * terms.largest(term.factors)
        if term.law is not None and order > 1:
            # Times the slope at words that are rounded down, as float32, rounded once more.
            slope, off = term.law.slopes[1], laws[term.law.index].slope_error + term.law.steepest * 2.0 * lsb
            more = (slope + off) * (relative(term.factors) + 3.0 * UNIT) + off
            return np.asarray(largest * more * (1.0 + 1e-6), dtype=np.float64)
        return np.asarray(largest * (relative(term.factors) + UNIT) * (1.0 + 1e-6), dtype=np.float64)

    def gathered(count: int, magnitude: FloatArray) -> FloatArray:
        """Each product, the conversion of its difference, and each addition."""
        return np.asarray(magnitude * ((count + 2) * UNIT * (1.0 + 1e-6)), dtype=np.float64)

    counts = [len(terms.of(k)) + len(terms.heats_of(k)) for k in range(len(terms.states))]
    error = np.zeros_like(first)
    total = np.zeros_like(first)
    for term in terms.terms:
        largest = term.rate * terms.largest(term.factors)
        words = {"state": 1.0, "ambient": _AMBIENT, "reference": _REFERENCE}[term.source]
        if term.law is not None:
            words = words * term.law.slopes[1] + laws[term.law.index].error / lsb
        error[:, term.target] += rate(1, term) * ranges.difference(term) + largest * words * lsb
        total[:, term.target] += largest * ranges.difference(term)
    for heat in terms.heats:
        largest = heat.heat * terms.largest(heat.factors)
        error[:, heat.target] += largest * (relative(heat.factors) + UNIT) * (1.0 + 1e-6)
        total[:, heat.target] += largest
    for target, count in enumerate(counts):
        error[:, target] += gathered(count, total[:, target])
    return Roundings(
        first=error,
        rate=rate,
        sum=lambda _, state, magnitude: gathered(counts[state] + 2, magnitude),
        kept=(0.0,) * orders,
        # y1 + y2 + ..: each addition, of magnitudes that sum to little more than y1.
        added=first * (orders * UNIT * 1.1) + 2.0 ** -(LOW_BITS + bits),
    )
