"""A network in fixed point: words, sums, and what they are off by.

A state is a 64-bit word of 2^-(32 + f) degC, of which the upper 32 bits are read. A rate is an unsigned word of
2^-(32 + g), g of its state's own, so that the fastest of the state's terms fills it; its product with a difference of
upper words goes into a 64-bit sum of 2^-(64 + f + g - 32) without any rounding. The sum is rounded once where the state
takes it up, and once where it is handed on to the next term of the series.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, log2

import numpy as np
from numpy.typing import NDArray

from gen.lowering.kinds import Integers
from gen.lowering.network.defect import Roundings, magnitudes
from gen.lowering.network.factors import FactorProgram
from gen.lowering.network.program import HeatProgram, TermProgram
from gen.lowering.network.ranges import Ranges
from gen.lowering.network.terms import Term, Terms

Array = NDArray[np.float64]
LOW_BITS = 32
"""Of a state's word below what is read."""
_SUM_BITS = 62
"""No sum of magnitudes reaches this many bits."""
_UNIT_BITS = 30
_AMBIENT = 1.75
"""Largest difference of a state's upper word and the ambient's from what they stand for, in words: the state's is
rounded down, the ambient's to nearest of a scale that is itself rounded."""
_REFERENCE = 1.5


@dataclass(frozen=True, eq=False)
class FixedFormat:
    """Where the binary points are.

    Attributes
    ----------
    bits
        Fraction bits f of a state's upper word.
    shifts
        g of each state.
    """

    bits: int
    shifts: tuple[int, ...]


def fraction_bits(ranges: Ranges, offsets: list[float]) -> int:
    """f: temperatures, their differences and readings fit 31 bits."""
    ends = [*ranges.low, *ranges.high, *ranges.ambient]
    widest = max(abs(min(ends)), abs(max(ends)), max(ends) - min(ends)) + max(map(abs, offsets), default=0.0)
    return 31 - ceil(log2(widest + 1e-6))


def choose_format(terms: Terms, ranges: Ranges, bits: int) -> FixedFormat:
    """g of each state: as much as its rates' words and its sum's magnitude allow."""
    shifts = []
    for target in range(len(terms.states)):
        largest, total = 2.0**-40, 0.0
        for term in terms.of(target):
            rate = float(term.rate.max()) * terms.largest(term.factors)
            largest = max(largest, rate)
            total += rate * max(ranges.difference(term), 1.0)
        total += sum(float(h.heat.max()) * terms.largest(h.factors) for h in terms.heats_of(target))
        by_word = -(ceil(log2(largest * (1.0 + 1e-9))))
        by_sum = _SUM_BITS - (LOW_BITS + bits) - ceil(log2(total))
        # A factor's product may come out a unit higher than the rate that it stands for.
        shifts.append(max(0, min(by_word, by_sum) - (1 if terms.factors else 0)))
    return FixedFormat(bits, tuple(shifts))


def term_program(term: Term, shape: FixedFormat) -> TermProgram:
    """A term's rate in words."""
    scale = 2.0 ** (32 + shape.shifts[term.target])
    words = np.rint(term.rate * scale).astype(np.int64)
    return TermProgram(term, np.minimum(words, 2**32 - 1), round(term.reference * 2.0**shape.bits))


def heat_programs(
    terms: Terms, target: int, shape: FixedFormat, factors: tuple[FactorProgram, ...]
) -> list[HeatProgram]:
    """A state's heats in words."""
    made = []
    scale = LOW_BITS + shape.bits + shape.shifts[target]
    for heat in terms.heats_of(target):
        if heat.factors:
            unit_bits = factors[heat.factors[0]].bits
        else:
            top = log2(max(float(heat.heat.max()), 2.0**-60)) + scale
            unit_bits = min(_UNIT_BITS, max(0, ceil(top + 1e-9) - 32))
        # Further factors are multiplied into the word, each with its own bits taken off.
        words: Integers = np.rint(heat.heat * 2.0 ** (scale - unit_bits)).astype(np.int64)
        made.append(HeatProgram(heat, np.minimum(words, 2**32 - 1), 1 << unit_bits))
    return made


def series_bits(terms: Terms, first: Array, shape: FixedFormat, orders: int) -> tuple[int, ...]:
    """Fraction bits of y1, y2, ..: each difference fits 31 bits, each sum 62.

    From y3 on the state takes up the word itself, at a whole byte of its own.
    """
    rates = np.zeros(len(terms.states))
    for term in terms.terms:
        rates[term.target] += 2.0 * float(term.rate.max()) * terms.largest(term.factors)
    chosen: list[int] = []
    for k, bound in enumerate(magnitudes(terms, first, orders), start=1):
        largest = max(float(bound.max()), 2.0**-60) * (2.0 if k > 1 else 1.0)  # a third is taken of a word, rounded up
        by_word = floor(30 - log2(largest)) - 1
        by_sum = [
            _SUM_BITS - 32 - g - ceil(log2(max(rate * largest, 2.0**-60)))
            for rate, g in zip(rates, shape.shifts, strict=True)
        ]
        best = min(by_word, *by_sum, LOW_BITS + shape.bits)
        if k > 2:
            best -= (best - shape.bits) % 8
        chosen.append(best)
    return tuple(chosen)


def roundings(
    terms: Terms, ranges: Ranges, shape: FixedFormat, factors: tuple[FactorProgram, ...], kept: tuple[int, ...]
) -> Roundings:
    """What the words above are off by."""
    lsb = 2.0**-shape.bits

    def relative(own: tuple[int, ...]) -> float:
        """Of a product of factors, absolute."""
        exact, off = 1.0, 0.0
        for k in own:
            largest = float(terms.spans[k, 1])
            exact, off = exact * largest, off * (largest + factors[k].error) + exact * factors[k].error
        return off

    def rate(term: Term) -> Array:
        unit = 2.0 ** -(32 + shape.shifts[term.target])
        own = 0.5 * unit * terms.largest(term.factors) + len(term.factors) * unit
        return np.asarray(own + term.rate * relative(term.factors), dtype=np.float64)

    first = np.zeros((terms.terms[0].rate.size, len(terms.states)))
    for term in terms.terms:
        largest = term.rate * terms.largest(term.factors)
        words = {"state": 1.0, "ambient": _AMBIENT, "reference": _REFERENCE}[term.source]
        first[:, term.target] += rate(term) * (ranges.difference(term) + 2.0 * lsb) + largest * words * lsb
    for target in range(len(terms.states)):
        scale = LOW_BITS + shape.bits + shape.shifts[target]
        for heat, program in zip(terms.heats_of(target), heat_programs(terms, target, shape, factors), strict=True):
            unit = program.unit * 2.0**-scale
            bound = max(1.0, terms.largest(heat.factors))
            first[:, target] += (0.5 + len(heat.factors)) * unit * bound + heat.heat * relative(heat.factors)
    return Roundings(
        first=first,
        rate=rate,
        sum=lambda _, magnitude: np.zeros_like(magnitude),
        kept=tuple(2.0**-bits for bits in kept),
        added=8 * 2.0 ** -(LOW_BITS + shape.bits),
    )
