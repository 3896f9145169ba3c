"""A thermistor's temperature from a sum of conversions, as whole numbers that the board interpolates."""

from __future__ import annotations

from gen.coefficients.wiring import ENDS_degC, Thermistor

CONVERSIONS = 16
"""Are added up for a reading: a little noise then tells more than a step of the converter."""
FULL_SUM = 1024 * CONVERSIONS
"""What the supply itself would give."""
MOST_SUM = 1023 * CONVERSIONS
"""No sum is larger."""
SEGMENT_BITS = 5
"""Sums from one entry of the table to the next, as a power of two."""
FINE_BITS = 4
"""An entry has so many bits more than a count of 0.25 K."""
_RAIL_CODES = 2
"""A conversion so near to ground or to the supply is of a broken wire or a short."""
_FINE_K = 0.25 / 2**FINE_BITS
_BEYOND_K = 10.0


def fine_at(thermistor: Thermistor) -> tuple[int, ...]:
    """Give the temperature in 64ths of a degree Celsius at each 32nd sum, 0..16384, both included.

    Parameters
    ----------
    thermistor
        With its divider.

    Notes
    -----
    What is beyond `ENDS_degC` is held 10 K beyond: no sound sum is there.
    """
    low, high = ENDS_degC[0] - _BEYOND_K, ENDS_degC[1] + _BEYOND_K
    cold, hot = (low, high) if thermistor.to_supply else (high, low)
    inner = (thermistor.temperature_degC(at / FULL_SUM) for at in range(1 << SEGMENT_BITS, FULL_SUM, 1 << SEGMENT_BITS))
    return tuple(round(min(max(told, low), high) / _FINE_K) for told in (cold, *inner, hot))


def sound_sums(thermistor: Thermistor) -> tuple[int, int]:
    """Give the least and the largest sum that are neither a rail nor a temperature that no thermistor is for."""
    least = _RAIL_CODES * CONVERSIONS
    low, high = ENDS_degC
    sound = [
        at for at in range(least, MOST_SUM - least + 1) if low <= thermistor.temperature_degC(at / FULL_SUM) <= high
    ]
    return sound[0], sound[-1]
