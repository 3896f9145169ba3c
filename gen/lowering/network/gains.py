"""Errors of sensors' gains as the board holds them: shares of how far a temperature, or a reading, lies from a base.

A reading is T + g (T - base) and the offset, so that a start from a reading x without its offset puts the node at
x - g / (1 + g) (x - base). Each share is one product of a signed with an unsigned 32-bit word, to nearest; of a
negative gain the distance is taken the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, log2

from gen.arrays import IntArray
from gen.lowering.network.series import WHOLE
from gen.model.network_parts import Sensor

_SPARE = 8 * WHOLE.unit
"""Bits that a product leaves out."""
_AMBIENT_WORDS = 1.0
"""The ambient's word is at most so many words from what it stands for: to nearest of a scale that is itself rounded."""
_START_WORDS = 2.0
"""The same of a start's, less its offset."""


@dataclass(frozen=True)
class Gain:
    """A sensor's error of its gain.

    Attributes
    ----------
    error
        g, as the file has it.
    about_ambient
        Whether the base is the ambient; else it is 0 degC.
    word, back
        |g| and |g| / (1 + g).
    """

    error: float
    about_ambient: bool
    word: int
    back: int

    @property
    def opposite(self) -> bool:
        """Whether g is negative."""
        return self.error < 0.0

    def over(self, temperature: IntArray, ambient: IntArray) -> IntArray:
        """What the shares are of, in words, any shape."""
        base = ambient if self.about_ambient else 0 * ambient
        return base - temperature if self.opposite else temperature - base

    def reading_error(self, bits: int) -> float:
        """By how many words a reading may be off for its share alone; the state's word is rounded down by up to one."""
        return abs(self.error) * (1.0 + (_AMBIENT_WORDS if self.about_ambient else 0.0)) + _share_error(bits)

    def start_error(self, bits: int) -> float:
        """By how many words a start may be off from what it stands for."""
        back = abs(self.error) / (1.0 + self.error)
        return _START_WORDS * (1.0 + back) + back * _AMBIENT_WORDS + _share_error(bits)


@dataclass(frozen=True)
class GainFormat:
    """Where the binary points of all gains' words are.

    Attributes
    ----------
    shown, back
        Fraction bits of |g| and of |g| / (1 + g).
    """

    shown: int
    back: int

    def describe(self) -> dict[str, int]:
        """For the templates: what the products are shifted down by, and what rounds them to nearest."""
        made = {"shown": self.shown - _SPARE, "back": self.back - _SPARE}
        return {**made, **{f"{name}_half": 1 << (shift - 1) for name, shift in made.items()}}


def lower_gains(sensors: Sequence[Sensor]) -> tuple[list[Gain | None], GainFormat | None]:
    """Words of the gains, in the sensors' order; None for sensors without an error, and no format without any."""
    errors = [sensor.gain_error for sensor in sensors]
    if not any(errors):
        return [None for _ in sensors], None
    shape = GainFormat(_bits(max(map(abs, errors))), _bits(max(abs(_back(g)) for g in errors)))
    return [
        Gain(g, sensor.about_ambient, _word(abs(g), shape.shown), _word(abs(_back(g)), shape.back)) if g else None
        for g, sensor in zip(errors, sensors, strict=True)
    ], shape


def share(over: IntArray, part: int, bits: int) -> IntArray:
    """A share of words, to nearest, any shape; `part` counts in 2^-bits."""
    made: IntArray = (WHOLE.of(over, 0 * over + part) + (1 << (bits - _SPARE - 1))) >> bits - _SPARE
    return made


def _back(error: float) -> float:
    return error / (1.0 + error)


def _bits(most: float) -> int:
    """Fraction bits of unsigned 32-bit words up to a number."""
    return 32 - max(0, ceil(log2(most * (1.0 + 2.0**-40))))


def _word(value: float, bits: int) -> int:
    return min(round(value * 2.0**bits), 2**32 - 1)


def _share_error(bits: int) -> float:
    """Words by which a share may be off: to nearest, what its product leaves out, and its own word's rounding."""
    return 0.5 + WHOLE.dropped * 2.0 ** (_SPARE - bits) + 2.0 ** (31 - bits - 1) + 2.0**-10
