"""Formats and rounding of the corrected form (:mod:`gen.lowering.fixed.correction`).

Its short numbers lie on whole bytes if x3 has ten bits more than x2 and the last two products are kept from bits 32 and
24 on; a component for which that cannot be has the carried form.  Words and products are those of
:mod:`gen.lowering.fixed.formats`, with two differences:

* Roundings are all down, so what they lose lies between 0 and a known sum.  Its middle acts like a wrong steady rise
  and is taken off S; only the half enters the bound.
* The first product goes without its lowest six byte products instead of three.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.lowering.fixed.formats import Format, corrected_gain, dropped_error, largest_formats, with_products
from gen.lowering.recursion.bounds import StateRanges

_LAST_GAP = 10
_LAST_PRODUCTS = (32, 24)
#: Columns of byte products that the first product leaves out.
FIRST_DROPPED = 3
#: How many fewer bits x2 may have than it could.
_COARSER = 3


@dataclass(frozen=True)
class Rounding:
    """What the board loses in a sample.

    Attributes
    ----------
    steady
        What to take off the steady rise, in K, shape (rows,).
    q
        Bound on what is left as an error of q, S's own rounding included, in K, shape (rows,).
    chain
        Bounds on the additions' rounding, in K, shape (rows, 3).
    """

    steady: FloatArray
    q: FloatArray
    chain: FloatArray


def candidates(ranges: FloatArray, rate_maxima: FloatArray) -> list[Format]:
    """Formats of the corrected form that hold the ranges, the finest first.

    Parameters
    ----------
    ranges
        Largest magnitude of each high word and of what is added to it before a product, in K, shape (3,).
    rate_maxima
        Largest R[i] over the domain, shape (3,).
    """
    finest = largest_formats(ranges)
    found = []
    for second in range(finest[1], finest[1] - _COARSER, -1):
        bits = (finest[0], second, second + _LAST_GAP)
        if bits[2] > finest[2] or second < finest[0]:
            continue
        layout = with_products(bits, rate_maxima)
        if layout is None or layout.product_shifts[1:] != _LAST_PRODUCTS or not 0 <= layout.first_rate_cut < 8:
            continue
        found.append(replace(layout, corrected=True))
    return found


def rounding(layout: Format, rates: FloatArray, integers: IntArray) -> Rounding:
    """Worst rounding of one sample.

    Parameters
    ----------
    layout
        The formats.
    rates
        R(p), shape (rows, 3).
    integers
        The board's rates, shape (rows, 3).
    """
    high, low = layout.high_lsb, layout.residue_lsb
    k = layout.product_shifts
    loss = high[0] * np.ones(len(rates))  # x1 is rounded down
    # The state's and the product's floor, and what the product leaves out.
    loss = high[1] * (2.0 + first_product_error(k[0])) + rates[:, 0] * loss
    loss = high[2] * (2.0 + dropped_error(k[1], wide=False)) + rates[:, 1] * loss
    loss = low[2] * (1.0 + dropped_error(k[2], wide=True)) + rates[:, 2] * loss
    half = loss / 2.0
    drive = rates.prod(axis=1)
    chain = np.zeros(rates.shape)
    chain[:, 0] = low[0]
    chain[:, 1] = low[1] + _correction_error(layout, integers)
    return Rounding(steady=half / drive, q=half + drive * 0.5 * high[0], chain=chain)


def first_product_error(shift: int) -> float:
    """Upper bound of what the first product leaves out, in units of bit ``shift``."""
    return sum((s + 1) * 255.0 * 255.0 * 256.0**s for s in range(FIRST_DROPPED)) / 2.0**shift


def fits(layout: Format, ranges: StateRanges, q_range: float, integers: IntArray) -> bool:
    """Whether the short numbers that d is computed with hold their ranges: two of 16 bits, F of 8."""
    unit, first = _short_lsb(layout), _first_byte(layout, integers)
    inner = ranges.magnitude[2] / unit + first * (ranges.magnitude[1] / (layout.high_lsb[1] * 2.0**24) + 1.0) + 2.0
    total = inner * float((integers[:, 1] >> 24).max()) / 256.0 + q_range / (unit / 2.0**10) + 4.0
    return bool(max(inner, total) < 2.0**15 and int(corrected_gain(integers[:, 2]).max()) < 256)


def _short_lsb(layout: Format) -> float:
    """Weight of the lowest bit of the 16-bit x3 + E0 x2, in K."""
    return layout.high_lsb[2] * 2.0**17


def _first_byte(layout: Format, integers: IntArray) -> int:
    return int((integers[:, 0] >> 24 + layout.first_rate_cut).max())


def _correction_error(layout: Format, integers: IntArray) -> FloatArray:
    """Bound on d's error against its own factors, in K: short x3 and x2, short product, short q, and d's last bit."""
    unit = _short_lsb(layout)
    from_state = unit * (1.0 + _first_byte(layout, integers)) * (integers[:, 1] >> 24) / 2.0**18
    from_floors = 3.0 * unit / 2.0**10
    error: FloatArray = corrected_gain(integers[:, 2]) / 2.0**20 * (from_state + from_floors) + layout.residue_lsb[1]
    return error
