"""The fixed-point formats of one component and the rounding error that each operation makes with them.

A state word has 48 bits.  Its upper 32 bits ("high word") are what gets multiplied and read out; the lower 16 bits
carry the residue of every addition on to the next sample, so nothing is lost by adding a small increment to a large
temperature.  ``fraction_bits`` counts the whole word's bits after the binary point: a word w means w * 2^-f kelvin.

Products are 32 x 32 bits, signed by unsigned.  ``product_high`` keeps 32 of the product's bits from bit k on,
``product_wide`` all from bit k on; both leave out the byte products that lie far below bit k (:func:`dropped_bytes`),
which the board then need not compute.  k is a multiple of 8, so that on an 8-bit machine the shift is free.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.lowering.recursion.bounds import StateRanges

WORD_BITS = 48
RESIDUE_BITS = 16
#: 2^16 / 12: the share of q that x[n-1] carries (:mod:`gen.lowering.recursion.increments`), as the board multiplies.
CARRY_FACTOR = 5461
#: 2^7 times 4/3, a little more for what the byte of R2 has lost: how the corrected form takes a twelfth of R2.
GAIN_FACTOR = 172
_PRODUCT_SHIFTS = (32, 24, 16)


@dataclass(frozen=True)
class Format:
    """Formats of one component of order n.

    Attributes
    ----------
    fraction_bits
        Bits after the binary point of the 48-bit state words, length n, not decreasing.
    product_shifts
        k of each product, length n; the last is a ``product_wide``, the others are ``product_high``.
    rate_fraction_bits
        Bits after the binary point of the 32-bit unsigned rates, length n.
    carry_byte
        At a change of PWM, 32 bits of q from this byte of its word on are carried over, 1 or 2.
    corrected
        Whether every sample corrects itself (:mod:`gen.lowering.fixed.correction`), so that nothing happens at a change
        of PWM.
    """

    fraction_bits: tuple[int, ...]
    product_shifts: tuple[int, ...]
    rate_fraction_bits: tuple[int, ...]
    carry_byte: int = 2
    corrected: bool = False

    @property
    def order(self) -> int:
        """The component's order n."""
        return len(self.fraction_bits)

    @property
    def first_rate_cut(self) -> int:
        """By how many bits the corrected form shortens R0's uppermost byte."""
        return self.rate_fraction_bits[0] - self.chain_shifts[-1] - 31

    @property
    def chain_shifts(self) -> tuple[int, ...]:
        """By how many bits x[i+1] is shifted right before it is added to x[i], length n - 1."""
        return tuple(b - a for a, b in itertools.pairwise(self.fraction_bits))

    @property
    def output_bits(self) -> int:
        """Bits after the binary point of x1's high word, which is what starts and is read out."""
        return self.fraction_bits[0] - RESIDUE_BITS

    @property
    def high_lsb(self) -> tuple[float, ...]:
        """Weight of the lowest bit of each high word, in K."""
        return tuple(2.0 ** (RESIDUE_BITS - f) for f in self.fraction_bits)

    @property
    def residue_lsb(self) -> tuple[float, ...]:
        """Weight of the lowest bit of each whole word, in K."""
        return tuple(2.0**-f for f in self.fraction_bits)

    @property
    def odd_shift_bits(self) -> int:
        """Bits by which the chain's shifts miss whole bytes, from above or below: each costs the board some cycles."""
        return sum(min(shift % 8, -shift % 8) if shift > 8 else shift % 8 for shift in self.chain_shifts)


@dataclass(frozen=True)
class Target:
    """What a choice of formats disturbs.

    Attributes
    ----------
    c, rates
        C0..C[n-1] and R0..R[n-1], shape (rows, n).
    distance
        Largest |x - s| of every coordinate at every PWM, in K per sample^k, shape (rows, n).
    """

    c: FloatArray
    rates: FloatArray
    distance: FloatArray

    def of_states(self, layout: Format) -> float:
        """Estimate of what the last bits of the states mean as an error of the steady rise, in K."""
        return float(self._share.max(axis=0) @ np.array(layout.high_lsb))

    def of_all(self, layout: Format) -> float:
        """The same with the last bits of the rates and of what is carried at a change of PWM."""
        # A rate is a factor of its own C and of all before it.
        halves = 0.5 / (self.rates * 2.0 ** np.array(layout.rate_fraction_bits))
        rates = (halves * self._moved).sum(axis=1).max()
        carried = self._share[:, -1].max() * carry_error(layout, 0.0) if layout.order > 1 else 0.0
        return self.of_states(layout) + float(rates + carried)

    @cached_property
    def _share(self) -> FloatArray:
        """C[i]/C0, shape (rows, n): what a rounding of x[i+1] means."""
        share: FloatArray = self.c / self.c[:, :1]
        return share

    @cached_property
    def _moved(self) -> FloatArray:
        """What a whole rate R[i] means, through its own C and all before it, shape (rows, n)."""
        return np.cumsum(self._share * self.distance, axis=1)


def dropped_bytes(shift: int, *, wide: bool) -> int:
    """Byte products d[i] * r[j] with i + j below this are left out of a product kept from bit ``shift`` on.

    Only two variants exist, so that the board needs only two multiplication routines: without the lowest byte
    product, and without the lowest three.
    """
    return 2 if shift == 32 or (wide and shift == 24) else 1


def dropped_error(shift: int, *, wide: bool) -> float:
    """Upper bound of what is left out, in units of bit ``shift``."""
    rank = dropped_bytes(shift, wide=wide)
    return sum((s + 1) * 255.0 * 255.0 * 256.0**s for s in range(rank)) / 2.0**shift


def corrected_gain(last_rates: IntArray) -> IntArray:
    """F of the corrected form, R2/12 from R2's uppermost byte (:mod:`gen.lowering.fixed.correction`)."""
    gain: IntArray = (last_rates >> 24) * 2 * GAIN_FACTOR >> 8
    return gain


def choose(ranges: FloatArray, drive: float | None, target: Target, tolerance: float) -> Format | None:
    """The formats with the fewest odd shifts whose rounding stays within a tolerance.

    Parameters
    ----------
    ranges
        Largest magnitude of each high word and of what is added to it before a product, in K, shape (n,).
    drive
        Largest |q| in K, or None where no ranges are proven.
    target
        What the rounding disturbs.
    tolerance
        In K of steady rise.

    Returns
    -------
    Format or None
        None if a range cannot be held together with the others' (chain shifts would have to be negative or > 31).
    """
    finest = largest_formats(ranges)
    best: tuple[tuple[float, ...], Format] | None = None
    for coarser in itertools.product(range(8), repeat=len(finest)):
        bits = tuple(f - c for f, c in zip(finest, coarser, strict=True))
        shifts = [b - a for a, b in itertools.pairwise(bits)]
        if any(not 0 <= s <= 31 for s in shifts):
            continue
        candidate = with_products(bits, target.rates.max(axis=0))
        if candidate is None:
            continue
        if drive is None:  # ranges that nobody proved are too wide to weigh the rest with
            error = target.of_states(candidate)
        else:
            candidate = replace(candidate, carry_byte=carry_byte(candidate, drive))
            error = target.of_all(candidate)
        within = error <= tolerance
        key = (0.0 if within else 1.0, candidate.odd_shift_bits if within else 0, error)
        if best is None or key < best[0]:
            best = (key, candidate)
    return best[1] if best else None


def largest_formats(ranges: FloatArray) -> list[int]:
    """Most bits after the binary point that the states' words can have, not decreasing."""
    finest = [WORD_BITS - 1 - _bits(value) for value in ranges]
    for i in reversed(range(len(finest) - 1)):
        finest[i] = min(finest[i], finest[i + 1])
    return finest


def with_products(bits: tuple[int, ...], rate_maxima: FloatArray) -> Format | None:
    """The finest rates for given bits of the states, None if a rate is too large for any product."""
    shifts, rate_bits = [], []
    for i, largest in enumerate(rate_maxima):
        gap = bits[i + 1] - bits[i] if i + 1 < len(bits) else RESIDUE_BITS
        for k in _PRODUCT_SHIFTS:
            if largest * 2.0 ** (gap + k) < 2.0**32 - 1:
                shifts.append(k)
                rate_bits.append(gap + k)
                break
        else:
            return None
    return Format(bits, tuple(shifts), tuple(rate_bits))


def _bits(magnitude: float) -> int:
    """Smallest b with magnitude < 2^b, with a little room for the last bit."""
    return int(np.ceil(np.log2(magnitude * (1.0 + 1e-6))))


def rounding(
    layout: Format, rates: FloatArray, steady_excess: FloatArray | float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Worst rounding of one sample: of q, and of each chain addition; :func:`carry_error` comes on top.

    Parameters
    ----------
    layout
        The formats.
    rates
        R(p), shape (m, n).
    steady_excess
        By how many units of its last bit the integer S lies outside of [S - 1, S], shape (m,) or one for all.

    Returns
    -------
    q, chain
        Bounds in K: shape (m,) for q, shape (n,) for the rows of the chain.
    """
    n = layout.order
    # x1 and S are both rounded down: their difference is known to +-1.
    error = layout.high_lsb[0] * (np.ones(rates.shape[0]) + steady_excess)
    for i in range(n - 1):
        # The state's and the product's floor are offset by one unit: together +-1, and what the product leaves out.
        own = layout.high_lsb[i + 1] * (1.0 + dropped_error(layout.product_shifts[i], wide=False))
        error = own + rates[:, i] * error
    k = layout.product_shifts[-1]
    error = rates[:, -1] * error + layout.residue_lsb[-1] * (1.0 + dropped_error(k, wide=True))
    # Rounded down by each chain addition.
    additions = {1: (0,), 2: (2, 0), 3: (1, 1, 0), 4: (2, 1, 1, 0)}[n]
    chain = np.array([count * lsb for count, lsb in zip(additions, layout.residue_lsb, strict=True)])
    return error, chain


def carry_error(layout: Format, q_error: float) -> float:
    """Worst rounding of what x[n-1] takes over at a change of PWM, in K, given that of q."""
    unit = layout.residue_lsb[-1] * 2.0 ** (8 * layout.carry_byte)
    shifted = unit * 2.0 ** (layout.chain_shifts[-1] % 8)
    # Both q, and what is cut off below carry_byte, below the shift, below the product, and below the word.
    return CARRY_FACTOR / 2.0**16 * (2.0 * q_error + unit + shifted) + shifted + layout.residue_lsb[-2]


def carry_byte(layout: Format, q_range: float) -> int:
    """The finest :attr:`Format.carry_byte` with which the change of a q within +-``q_range`` (in K) fits 32 bits."""
    return 1 if carry_fits(replace(layout, carry_byte=1), q_range) else 2


def carry_fits(layout: Format, q_range: float) -> bool:
    """Whether the change of a q within +-``q_range`` (in K) fits 32 bits from the layout's ``carry_byte`` on."""
    return 2.0 * q_range < (2.0**31 - 4.0) * 2.0 ** (8 * layout.carry_byte) * layout.residue_lsb[-1]


def nested_ranges(ranges: StateRanges, rates: FloatArray) -> FloatArray:
    """Largest magnitude that each high word position has to hold: state, or state plus product, shape (n,)."""
    largest = rates.max(axis=0)
    difference = float(ranges.distance[:, 0].max())
    result = [max(difference, float(ranges.magnitude[0]))]
    inner = difference
    for i in range(len(ranges.magnitude) - 1):
        inner = float(ranges.magnitude[i + 1]) + float(largest[i]) * inner
        result.append(inner)
    return np.array(result)


def steady_excess(steady: IntArray, exact: FloatArray, layout: Format) -> FloatArray:
    """By how many units each S leaves the interval [exact - 1, exact] that the step's proof assumes, shape (rows,).

    Parameters
    ----------
    steady
        The board's integers.
    exact
        Steady rises in K.
    layout
        The formats that hold.
    """
    deviation = steady - exact / layout.high_lsb[0]
    excess: FloatArray = np.maximum(0.0, np.maximum(deviation, -1.0 - deviation))
    return excess
