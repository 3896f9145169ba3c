"""Paths with a law as the board evaluates them: the difference that counts, and its slope, from two temperatures.

Horner's scheme in a share of the widest difference, or powers of a share of a power of two in kelvin, in the products
of :mod:`gen.lowering.network.factors`; float32 builds share it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, log2
from typing import ClassVar

import numpy as np

from gen.arrays import IntArray
from gen.errors import CheckFailed
from gen.lowering.network.factors import CUT, SHARE_BITS, WORD_BITS, filling, high, scaled
from gen.lowering.network.ranges import Ranges
from gen.lowering.network.terms import PathLaw, Terms
from gen.model.laws import ZERO_C, Convection, Radiation

_LEAST_SLOPE = 1e-6
"""A law that is flatter has no word of its own for that: its path carries next to nothing."""


@dataclass(frozen=True)
class LawProgram:
    """One path's law.

    Attributes
    ----------
    path
        Its position in the file.
    first, second
        States at its ends; None for the ambient.
    scale
        What drives, and its slope, count as that much less, and the rates of its path as that much more.
    left, up
        By how many bits what is told, and what is found, is shifted up: to be a share, and a temperature's word.
    error
        Largest difference of what drives from the law between the same two words, K.
    slope_error
        Of the slope, whose word is of 2^-30.
    label
        What it is, for people.
    """

    path: int
    first: int
    second: int | None
    scale: float
    left: int
    up: int
    error: float
    slope_error: float
    label: str

    kind: ClassVar[str]

    def evaluate(self, one: IntArray, other: IntArray) -> tuple[IntArray, IntArray]:
        """What drives heat from the first end to the second one, as a temperature's word, and its slope.

        Parameters
        ----------
        one, other
            Words of both temperatures, of any one shape.
        """
        raise NotImplementedError


@dataclass(frozen=True)
class ConvectionProgram(LawProgram):
    """Of natural convection: polynomials in t = difference / widest.

    Attributes
    ----------
    share
        ``t = difference * 2^left x share >> 16`` in 2^-30.
    driving, slopes
        Coefficients as words, highest power first; that of the power 0 of what drives is 0 and left out.
    """

    share: int
    driving: tuple[int, ...]
    slopes: tuple[int, ...]

    kind: ClassVar[str] = "convection"

    def evaluate(self, one: IntArray, other: IntArray) -> tuple[IntArray, IntArray]:  # noqa: D102
        difference = one - other
        share = high(np.abs(difference) << self.left, self.share)
        value = scaled(share, _horner(self.driving, share)) << self.up
        return np.where(difference < 0, -value, value), np.maximum(_horner(self.slopes, share), 0)


@dataclass(frozen=True)
class RadiationProgram(LawProgram):
    """Of radiation: fourth powers of t = T / 2^n kelvin, in 2^-30.

    Attributes
    ----------
    drop
        Bits of a temperature's word below those of t; it is rounded to these.
    zero
        0 degC in kelvin, in such bits.
    driving, slopes
        What the difference of fourth powers, and the third power, are multiplied by.
    """

    drop: int
    zero: int
    driving: int
    slopes: int

    kind: ClassVar[str] = "radiation"

    def evaluate(self, one: IntArray, other: IntArray) -> tuple[IntArray, IntArray]:  # noqa: D102
        half = 1 << self.drop >> 1
        warm, cold = (((word + half >> self.drop) + self.zero) << self.left for word in (one, other))
        square, beside = scaled(warm, warm), scaled(cold, cold)
        fourth = scaled(square, square) - scaled(beside, beside)
        driving = scaled(np.full(one.shape, self.driving, dtype=np.int64), fourth) << self.up
        return driving, scaled(np.full(one.shape, self.slopes, dtype=np.int64), scaled(warm, square))


def _horner(coefficients: Sequence[int], share: IntArray) -> IntArray:
    value = np.full(share.shape, coefficients[0], dtype=np.int64)
    for coefficient in coefficients[1:]:
        value = coefficient + scaled(share, value)
    return value


def limited(terms: Terms, ranges: Ranges) -> Terms:
    """The same terms, every law with what it can be in the ranges, and raised so that its slope has a word.

    Raises
    ------
    CheckFailed
        If heat falls somewhere as a difference that can be reached grows.
    """
    found = []
    for own in terms.laws:
        ends = _ends(own, ranges)
        least, most = own.law.slope_ends(*ends)
        if not least >= 0.0:
            kind = type(own.law).__name__.lower()
            raise CheckFailed(
                f"$.network.paths[{own.path}].{kind}: differences of up to {_widest(own, ranges):.4g} K can be "
                "reached, and the heat falls before that as the difference grows"
            )
        # A slope's word has 2^-30 and 32 bits; so have those that it is made of.
        scale = 2.0 ** ceil(log2(max(most, _within(own, ends), _LEAST_SLOPE) * (1.0 + 1e-6) / 2.0))
        found.append(own.with_limits(scale, (least / scale, most / scale), own.law.steepest(*ends) / scale))
    return terms.with_laws(tuple(found))


def _ends(own: PathLaw, ranges: Ranges) -> tuple[float, float]:
    """Of what a law's slope depends on: the difference's magnitude, or the first end's temperature, degC."""
    if isinstance(own.law, Radiation):
        return float(ranges.low[own.first]), float(ranges.high[own.first])
    return 0.0, _widest(own, ranges)


def _widest(own: PathLaw, ranges: Ranges) -> float:
    (low, high), (least, most) = _range(own.first, ranges), _range(own.second, ranges)
    return max(high - least, most - low)


def _range(place: int | None, ranges: Ranges) -> tuple[float, float]:
    return ranges.ambient if place is None else (float(ranges.low[place]), float(ranges.high[place]))


def _within(own: PathLaw, ends: tuple[float, float]) -> float:
    """What a slope is put together of, so that no word of it is too large."""
    if isinstance(own.law, Convection):
        return float(np.polyval(np.abs(own.law.slopes), ends[1]))
    return _kelvins(ends[1]) ** 3 / (own.law.reference + ZERO_C) ** 3 / 2.0


def _kelvins(highest: float) -> float:
    """A power of two above a temperature in degC, K."""
    return float(2.0 ** ceil(log2(highest + ZERO_C + 1.0)))


def widest_word(terms: Terms, ranges: Ranges) -> float:
    """Largest magnitude of a temperature plus or minus what a law makes of it, and of what that is made of, K."""
    found = 0.0
    for own in terms.laws:
        both = [max(map(abs, _range(place, ranges))) for place in (own.first, own.second)]
        largest = own.largest(_range(own.first, ranges), _range(own.second, ranges))
        found = max(found, max(both) + largest, _parts(own, ranges))
    return found


def _parts(own: PathLaw, ranges: Ranges) -> float:
    """Sum of the magnitudes that what drives is the sum of, K."""
    if isinstance(own.law, Convection):
        widest = _widest(own, ranges)
        return widest * float(np.polyval(np.abs(own.law.polynomial), widest)) / own.scale
    fourth = sum((_range(place, ranges)[1] + ZERO_C) ** 4 for place in (own.first, own.second))
    return fourth / (4.0 * (own.law.reference + ZERO_C) ** 3 * own.scale)


def lower_law(own: PathLaw, ranges: Ranges, bits: int) -> LawProgram:
    """Choose a law's words.

    Parameters
    ----------
    own
        Between which states, within its limits.
    ranges
        What temperatures there are.
    bits
        Fraction bits of a temperature's word.
    """
    label = f"paths[{own.path}].{type(own.law).__name__.lower()}"
    if isinstance(own.law, Convection):
        return _convection(own, own.law, _widest(own, ranges), bits, label)
    return _radiation(own, own.law, ranges, bits, label)


def _convection(own: PathLaw, law: Convection, widest: float, bits: int, label: str) -> ConvectionProgram:
    most = ceil(widest * 2.0**bits) + 4
    width = most * 2.0**-bits
    powers = range(len(law.polynomial), 0, -1)
    exact = [c * width**k / own.scale for k, c in zip(powers, law.polynomial, strict=True)]
    slopes = [k * c / width for k, c in zip(powers, exact, strict=True)]
    kept = min(bits, WORD_BITS - ceil(log2(sum(map(abs, exact)) + 1e-9)))
    left = filling(most)
    scale = min((1 << (SHARE_BITS + 32)) // (most << left), (1 << 32) - 1)  # down, so that t never passes 1
    share = (0.5 + CUT) * 2.0**-SHARE_BITS * width
    steps = (0.5 + CUT) * (len(exact) + 1)
    return ConvectionProgram(
        own.path,
        own.first,
        own.second,
        own.scale,
        left,
        bits - kept,
        own.slopes[1] * share + steps * 2.0**-kept,
        own.steepest * share + steps * 2.0**-WORD_BITS,
        label,
        scale,
        tuple(round(c * 2.0**kept) for c in exact),
        tuple(round(c * 2.0**WORD_BITS) for c in slopes),
    )


def _radiation(own: PathLaw, law: Radiation, ranges: Ranges, bits: int, label: str) -> RadiationProgram:
    kelvins = _kelvins(max(float(ranges.high[own.first]), ranges.ambient[1]))
    reference = (law.reference + ZERO_C) ** 3 * own.scale
    whole, third = kelvins**4 / (4.0 * reference), kelvins**3 / reference
    kept = min(bits, 31 - ceil(log2(max(whole / 2.0, _parts(own, ranges)) * (1.0 + 1e-6))))
    finest = WORD_BITS - round(log2(kelvins))
    drop, left = max(0, bits - finest), max(0, finest - bits)
    unit = 2.0**-WORD_BITS
    zero = (0.5 + (0.5 if drop else 0.0)) * 2.0 ** -(finest - left)
    return RadiationProgram(
        own.path,
        own.first,
        own.second,
        own.scale,
        left,
        bits - kept,
        # Squares of squares: each cut is doubled once, and two of them are subtracted.
        2.0 * own.slopes[1] * zero + 6.0 * CUT * unit * whole + (0.5 + CUT) * 2.0**-kept,
        own.steepest * zero + 2.0 * CUT * unit * third + (0.5 + CUT) * unit,
        label,
        drop,
        round(ZERO_C * 2.0 ** (finest - left)),
        round(whole * 2.0**kept),
        round(third * 2.0**WORD_BITS),
    )
