"""A platinum resistor's temperature from a ratio of resistances, as whole counts that the board interpolates."""

from __future__ import annotations

import math

CODES = 32768
"""A ratio of 1, resistor over reference, in a MAX31865's word."""
SEGMENT_BITS = 10
"""Codes from one entry of the table to the next, as a power of two."""
LOWEST_COUNTS, HIGHEST_COUNTS = -800, 3400
"""-200 and 850 degC, where the equation ends: beyond it the resistor is shorted, or open."""
_A, _B, _C = 3.9083e-3, -5.775e-7, -4.183e-12
"""Callendar and Van Dusen's equation, as IEC 60751 has it."""
_LOWEST_degC, _HIGHEST_degC = -250.0, 1000.0


def resistance(temperature_degC: float) -> float:
    """Give a platinum resistor's resistance at a temperature, degC, over that at 0 degC (IEC 60751)."""
    t = temperature_degC
    below = _C * (t - 100.0) * t**3 if t < 0.0 else 0.0
    return 1.0 + _A * t + _B * t * t + below


def counts_at(platinum_ohm: float, reference_ohm: float) -> tuple[int, ...]:
    """Give the temperature in counts of 0.25 degC at each 1024th code, 0..32768, both included.

    Parameters
    ----------
    platinum_ohm
        The resistor at 0 degC, ohm.
    reference_ohm
        What the chip compares it with, ohm.

    Notes
    -----
    Between two entries the board goes straight; with a reference of 4.3 times the resistor the curve is 0.05 K away
    from that at most, and rounding 0.25 K.
    """
    ratios = (code * reference_ohm / CODES / platinum_ohm for code in range(0, CODES + 1, 1 << SEGMENT_BITS))
    return tuple(round(_temperature(ratio) / 0.25) for ratio in ratios)


def _temperature(ratio: float) -> float:
    """Invert `resistance` within its ends, which lie beyond what the chip is for."""
    low, high = _LOWEST_degC, _HIGHEST_degC
    while not math.isclose(low, high, abs_tol=1e-6):
        middle = (low + high) / 2.0
        low, high = (middle, high) if resistance(middle) < ratio else (low, middle)
    return low
