"""A network in fixed point: words, sums, and what they are off by.

A state is a 48-bit word of 2^-(16 + f) degC, of which the upper 32 bits are read. A rate is an unsigned word of
2^-(32 + g), g of its state's own, so that the fastest of the state's terms fills it. Its products with differences of
upper words leave out their lightest bytes (:class:`~gen.lowering.network.series.Product`); their sum is rounded once
where the state takes it up, and once where it is handed on to the next term of the series. Later terms are of shorter
words: the upper bytes of the rates, and differences that fill as many.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, log2

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.lowering.network.defect import Roundings, magnitudes
from gen.lowering.network.factors import WORD_BITS, FactorProgram
from gen.lowering.network.laws import LawProgram
from gen.lowering.network.program import HeatProgram, TermProgram
from gen.lowering.network.ranges import Ranges
from gen.lowering.network.series import EXTRA_SHIFT, FIRST, WEIGHT, Product
from gen.lowering.network.terms import Term, Terms

LOW_BITS = 16
"""Of a state's word below what is read."""
_FIRST_BITS = 32 - 8 * FIRST.unit
"""Of the first sum, at g = 0, below what is read of a state."""
_ROOM = 1.02
"""A word has room for so much more than is proven of it without its errors, which are then proven to fit."""
_BYTE_ROOM = 1.25
"""The same of a single byte."""
_AMBIENT = 1.8
"""Largest difference of a state's upper word and the ambient's from what they stand for, in words: the state's is
rounded down, the ambient's to nearest of a scale that is itself rounded, less what its product leaves out."""
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


def fraction_bits(ranges: Ranges, offsets: list[float], driven: float = 0.0) -> int:
    """f: temperatures, their differences, what laws make of these, and readings fit 31 bits."""
    ends = [*ranges.low, *ranges.high, *ranges.ambient]
    widest = max(abs(min(ends)), abs(max(ends)), max(ends) - min(ends)) + max(map(abs, offsets), default=0.0)
    widest = max(widest, driven)
    return 31 - ceil(log2(widest + 1e-6))


def choose_format(terms: Terms, factors: Sequence[FactorProgram], first: FloatArray, bits: int) -> FixedFormat:
    """g of each state: as much as its rates' and heats' words, and the sum of its first order, allow.

    Parameters
    ----------
    terms, factors
        The network, and its factors' words.
    first
        Bound on y1, K, shape (rows, n).
    bits
        f.
    """
    shifts = []
    for target in range(len(terms.states)):
        rates = [
            float(term.rate.max()) * 2.0 ** _raised(term.factors, factors) * _later(term) for term in terms.of(target)
        ]
        by_word = -ceil(log2(max(2.0**-40, *rates) * (1.0 + 1e-9)))
        by_sum = (
            8 * FIRST.sum_bytes - 1 - (_FIRST_BITS + bits) - ceil(log2(_ROOM * float(first[:, target].max()) + 1e-9))
        )
        by_heat = [
            32 + factors[heat.factors[0]].bits - (32 + bits) - ceil(log2(most))
            for heat in terms.heats_of(target)
            if heat.factors
            and (most := float(heat.heat.max()) * 2.0 ** _raised(heat.factors[1:], factors) * (1.0 + 1e-9))
        ]
        shifts.append(max(0, min(by_word, by_sum, *by_heat)))
    return FixedFormat(bits, tuple(shifts))


def _later(term: Term) -> float:
    """By how much a rate may grow in later terms of the series."""
    return 1.0 if term.law is None else max(1.0, term.law.slopes[1])


def _raised(own: Sequence[int], factors: Sequence[FactorProgram]) -> int:
    """By how many bits a word has to be raised for the factors that scale it: they count as fractions of 2^30."""
    return sum(WORD_BITS - factors[k].bits for k in own)


def term_program(term: Term, shape: FixedFormat, factors: Sequence[FactorProgram]) -> TermProgram:
    """A term's rate in words."""
    scale = 2.0 ** (32 + shape.shifts[term.target] + _raised(term.factors, factors))
    words = np.rint(term.rate * scale).astype(np.int64)
    return TermProgram(term, np.minimum(words, 2**32 - 1), round(term.reference * 2.0**shape.bits))


def heat_programs(terms: Terms, target: int, shape: FixedFormat, factors: Sequence[FactorProgram]) -> list[HeatProgram]:
    """A state's heats in words."""
    made = []
    unit = _FIRST_BITS + shape.bits + shape.shifts[target]
    for heat in terms.heats_of(target):
        if heat.factors:
            # The first factor's product with the word loses the bytes that every product does.
            left, raised = 0, 8 * FIRST.unit - factors[heat.factors[0]].bits + _raised(heat.factors[1:], factors)
        else:
            left = max(0, ceil(log2(max(float(heat.heat.max()), 2.0**-60)) + unit + 1e-9) - 32)
            raised = -left
        words: IntArray = np.rint(heat.heat * 2.0 ** (unit + raised)).astype(np.int64)
        made.append(HeatProgram(heat, np.minimum(words, 2**32 - 1), left))
    return made


def series_bits(terms: Terms, first: FloatArray, shape: FixedFormat, products: Sequence[Product]) -> tuple[int, ...]:
    """Fraction bits of y1, y2, .. as the next term's product takes them: each word, each difference and each sum fits.

    Parameters
    ----------
    terms, first, shape
        The network, a bound on y1, and its words.
    products
        Of the series' terms from the first on.
    """
    bounds = magnitudes(terms, first, len(products))
    chosen = []
    for k, product in enumerate(products[1:], start=2):
        # A third is taken of a word that itself has no room for differences.
        room = 1 if k in WEIGHT else 2
        largest = max(float(bounds[k - 2].max()), 1e-30) * (_ROOM if product.width > 1 else _BYTE_ROOM)
        by_word = floor(log2((2.0 ** (8 * product.width - room) - 4.0) / largest))
        by_sum = [
            8 * product.width - 1 - g - EXTRA_SHIFT[k] - ceil(log2(_ROOM * max(float(most), 1e-30)))
            for most, g in zip(bounds[k - 1].max(axis=0), shape.shifts, strict=True)
        ]
        chosen.append(min(by_word, *by_sum))
    return tuple(chosen)


def sum_bits(products: Sequence[Product], series: Sequence[int], bits: int, order: int) -> int:
    """Fraction bits of a sum at g = 0, the half, third and so on of its order counted in."""
    product = products[order - 1]
    given = bits if order == 1 else series[order - 2]
    return given + 8 * product.width - 8 * product.unit + EXTRA_SHIFT.get(order, 0)


def fit(
    shape: FixedFormat,
    products: Sequence[Product],
    series: Sequence[int],
    first: FloatArray,
    words: Sequence[FloatArray],
) -> bool:
    """Whether every sum fits its bytes, and every y its word with room for the difference of two.

    Parameters
    ----------
    shape, products, series
        The words.
    first
        Bound on y1 as the board has it, K, shape (rows, n).
    words
        The same of y1, y2, ..
    """
    for order, (product, word) in enumerate(zip(products, (first, *words[1:]), strict=False), start=1):
        unit = sum_bits(products, series, shape.bits, order)
        largest = word.max(axis=0) * 2.0 ** (unit + np.array(shape.shifts))
        if np.any(largest >= 2.0 ** (8 * product.sum_bytes - 1)):
            return False
    for k, (product, bits, word) in enumerate(zip(products[1:], series, words, strict=False), start=2):
        largest, half = float(word.max()) * 2.0**bits + 2.0, 2.0 ** (8 * product.width - 1)
        if largest > half or largest / (k if k in WEIGHT else 1) > half / 2.0:
            return False
    return True


def _kept(order: int, product: Product) -> float:
    """What a word for a term of the series is short of what it stands for, in its units, before its third is taken."""
    if order not in WEIGHT:
        return 1.0
    # A third or a fifth is cut twice: at a byte below the word, where there is one.
    return order * (1.01 if product.width < 4 else 2.5)


def roundings(
    terms: Terms,
    ranges: Ranges,
    shape: FixedFormat,
    factors: Sequence[FactorProgram],
    products: Sequence[Product],
    series: Sequence[int],
    laws: Sequence[LawProgram] = (),
) -> Roundings:
    """What the words above are off by."""
    lsb = 2.0**-shape.bits
    # Sums are of products that leave out up to so many of their units, and heats among them.
    counts = [len(terms.of(k)) for k in range(len(terms.states))]

    def relative(own: Sequence[int]) -> float:
        """Of a product of factors, absolute."""
        exact, off = 1.0, 0.0
        for k in own:
            largest = float(terms.spans[k, 1])
            exact, off = exact * largest, off * (largest + factors[k].error) + exact * factors[k].error
        return off

    def rate(order: int, term: Term) -> FloatArray:
        unit = 2.0 ** -(32 + shape.shifts[term.target])
        # A word is rounded to nearest, raised; each product with a factor is cut, and leaves out less than a unit.
        own = 0.5 * unit + 1.1 * len(term.factors) * unit
        cut = 2.0 ** (32 - 8 * products[order - 1].width) * unit if products[order - 1].width < 4 else 0.0
        if term.law is not None and order > 1:
            # Times the slope at words that are rounded down, cut once more.
            slope, off = term.law.slopes[1], laws[term.law.index].slope_error + term.law.steepest * 2.0 * lsb
            own = own * (slope + off) + 1.1 * unit
            most = relative(term.factors) * (slope + off) + terms.largest(term.factors) * off
            return np.asarray(own + cut + term.rate * most, dtype=np.float64)
        return np.asarray(own + cut + term.rate * relative(term.factors), dtype=np.float64)

    def summed(order: int, state: int, magnitude: FloatArray) -> FloatArray:
        unit = 2.0 ** -(sum_bits(products, series, shape.bits, order) - EXTRA_SHIFT.get(order, 0) + shape.shifts[state])
        # A third or a fifth is taken of the word before, so that the sum's own error is not divided by it.
        whole = order if order in WEIGHT else 1
        return np.full_like(magnitude, counts[state] * products[order - 1].dropped * unit * whole)

    first = np.zeros((terms.terms[0].rate.size, len(terms.states)))
    for term in terms.terms:
        largest = term.rate * terms.largest(term.factors)
        words = {"state": 1.0, "ambient": _AMBIENT, "reference": _REFERENCE}[term.source]
        if term.law is not None:
            words = words * term.law.slopes[1] + laws[term.law.index].error / lsb
        first[:, term.target] += rate(1, term) * (ranges.difference(term) + 2.0 * lsb) + largest * words * lsb
    for target in range(len(terms.states)):
        first[:, target] += summed(1, target, first[:, target])
        unit = 2.0 ** -(_FIRST_BITS + shape.bits + shape.shifts[target])
        for heat, program in zip(terms.heats_of(target), heat_programs(terms, target, shape, factors), strict=True):
            if heat.factors:
                # The word is rounded, then cut by each further factor; the first factor's product leaves bytes out.
                word = 2.0 ** (factors[heat.factors[0]].bits - 8 * FIRST.unit) * unit
                rounded = (0.5 + 1.1 * (len(heat.factors) - 1)) * word * float(terms.spans[heat.factors[0], 1])
                first[:, target] += rounded + FIRST.dropped * unit + heat.heat * relative(heat.factors)
            else:
                first[:, target] += 0.5 * 2.0**program.left * unit
    further = enumerate(zip(products[1:], series, strict=True), start=2)
    return Roundings(
        first=first,
        rate=rate,
        sum=summed,
        kept=tuple(_kept(k, product) * 2.0**-bits for k, (product, bits) in further),
        added=len(products) * 2.0 ** -(LOW_BITS + shape.bits),
    )
