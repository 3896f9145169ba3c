"""What runs offer to explain an error with."""

from __future__ import annotations

from dataclasses import dataclass

AMPERE, VOLT = ("_A", "_mA"), ("_V", "_mV")
ELSE = ("_degC", "_degF", "_K", "_pct_RH")


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
    room_moves
        Whether the ambient was measured and moves.
    """

    ranges: dict[str, tuple[float, float]]
    typical: dict[str, float]
    backwards: bool
    rests: bool
    room_moves: bool

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
