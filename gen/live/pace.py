"""How fast simulated time goes here, for one source or for two that run abreast."""

from __future__ import annotations

import threading

from gen.live.control import Control

FASTEST = 100_000.0
_AHEAD_S = 1.0
_AHEAD_HERE_S = 0.02


class Pace:
    """A pace that sources share, and where each of them is.

    Parameters
    ----------
    speed
        Simulated seconds in a second here.
    fastest
        The largest that somebody may set.

    Attributes
    ----------
    speed
        See above; changed at will.
    """

    def __init__(self, speed: float, fastest: float = FASTEST) -> None:
        self.speed = speed
        self._fastest = fastest
        self._reached: dict[int, float] = {}
        self._lock = threading.Lock()

    @property
    def control(self) -> Control:
        """What sets it."""
        return Control("pace", "times as fast", "number", self.speed, 0.1, self._fastest, 0.1)

    def join(self) -> int:
        """Take part from time 0 on; gives a number to tell one's time with."""
        with self._lock:
            who = max(self._reached, default=0) + 1
            self._reached[who] = 0.0
            return who

    def reach(self, who: int, seconds: float) -> None:
        """Tell one's own simulated time, s."""
        with self._lock:
            if who in self._reached:
                self._reached[who] = seconds

    def leave(self, who: int) -> None:
        """Take part no more: nobody waits for this one."""
        with self._lock:
            self._reached.pop(who, None)

    def too_far(self, who: int) -> bool:
        """Whether the slowest of the others is so far behind that one should wait for it."""
        with self._lock:
            if who not in self._reached:
                return False
            behind_s = self._reached[who] - min(self._reached.values())
        return behind_s > max(_AHEAD_S, _AHEAD_HERE_S * self.speed)
