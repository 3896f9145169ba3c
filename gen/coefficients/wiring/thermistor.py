"""A thermistor of negative temperature coefficient in a divider from the supply: what the pin's voltage means."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

ENDS_degC = (-55.0, 300.0)
"""No thermistor is for more."""
_STEPS = 1024
_ZERO_K = 273.15
_ROOM_K = 298.15


@dataclass(frozen=True)
class Thermistor:
    """1/T = a + b ln R + c (ln R)^3, with T in K and R in ohm (Steinhart and Hart, 1968), and its divider.

    Attributes
    ----------
    a, b, c
        Of the equation; with c = 0 it is the one with beta.
    series_ohm
        The other resistor of the divider, ohm.
    to_supply
        Whether the thermistor is between the pin and the supply, not between the pin and ground.
    """

    a: float
    b: float
    c: float
    series_ohm: float
    to_supply: bool = False

    @classmethod
    def of_beta(cls, r25_ohm: float, beta_K: float, series_ohm: float, *, to_supply: bool) -> Thermistor:
        """R = r25 exp(beta (1/T - 1/298.15 K)), with r25 in ohm and beta in K."""
        return cls(1.0 / _ROOM_K - math.log(r25_ohm) / beta_K, 1.0 / beta_K, 0.0, series_ohm, to_supply)

    def temperature_degC(self, share: float) -> float:
        """Give its temperature where the pin has a share of the supply, 0..1 without both."""
        ratio = (1.0 - share) / share if self.to_supply else share / (1.0 - share)
        logarithm = math.log(self.series_ohm * ratio)
        inverse = self.a + self.b * logarithm + self.c * logarithm**3
        return 1.0 / inverse - _ZERO_K if inverse > 0.0 else math.inf

    def range_degC(self) -> tuple[float, float] | None:
        """Where a step of the converter is no more than 1 K; None if it is so nowhere within `ENDS_degC`."""
        low, high = ENDS_degC
        told = [self.temperature_degC(code / _STEPS) for code in range(1, _STEPS)]
        fine = [
            end
            for pair in itertools.pairwise(told)
            if abs(pair[1] - pair[0]) <= 1.0 and all(low <= end <= high for end in pair)
            for end in pair
        ]
        return (min(fine), max(fine)) if fine else None
