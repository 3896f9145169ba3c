"""What runs offer to explain an error with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import BoolArray, FloatArray

AMPERE, VOLT = ("_A", "_mA"), ("_V", "_mV")
ELSE = ("_degC", "_degF", "_K", "_pct_RH")

LONG_S = 120.0
"""A speed that was held for less has warmed nothing."""


@dataclass(frozen=True)
class Offered:
    """Channels that every later run has and that move, and what the motor did.

    Attributes
    ----------
    ranges
        Least and greatest value of each channel.
    typical
        Median of each.
    backwards, rests
        Whether it turned backwards, and stood still, for long enough.
    room_measured, room_moves
        Whether the ambient was measured in every run, and whether it moves.
    turned_s
        For how long it turned at 0, 1 .. 100 % of full speed, s.
    hottest_degC
        How warm each node became whose sensor read anything.
    """

    ranges: dict[str, tuple[float, float]]
    typical: dict[str, float]
    backwards: bool
    rests: bool
    room_measured: bool
    room_moves: bool
    turned_s: tuple[float, ...]
    hottest_degC: dict[str, float]

    def hottest(self, name: str) -> float:
        """How warm a node became, degC: one without a sensor at least as warm as the warmest that has one."""
        return self.hottest_degC.get(name, max(self.hottest_degC.values(), default=-np.inf))

    @property
    def currents(self) -> list[str]:
        """Channels in ampere."""
        return [name for name in self.ranges if name.endswith(AMPERE)]

    @property
    def voltages(self) -> list[str]:
        """Channels in volt."""
        return [name for name in self.ranges if name.endswith(VOLT)]

    @property
    def flows(self) -> list[str]:
        """Channels that may be a flow of air: all in other units, but no temperatures."""
        return [name for name in self.ranges if not name.endswith((*AMPERE, *VOLT, *ELSE))]

    def was_run(self, speeds: FloatArray, within: float) -> BoolArray:
        """Say which speeds, shape (K,), it turned at for long enough, or at some within a share of full speed."""
        percent = np.linspace(0.0, 1.0, len(self.turned_s))
        near = np.abs(speeds[:, None] - percent) < within + 1e-9
        return np.asarray(near @ np.array(self.turned_s) > LONG_S)
