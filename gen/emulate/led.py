"""Reading the indicator LED with a clock, as somebody with the emitted README beside the motor would.

The patterns are those of the emitted sketch: a short flash every two seconds (healthy), slow blinks whose number is an
alarm rule's, and a flicker (a sensor's sample is not believed).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.emulate.levels import Edges

_BLINK_S = 0.16  # a blink is on for 0.256 s, a flash or a flicker for 0.064 s
_GROUP_S = 0.6  # between the blinks of one number it is dark for 0.256 s
_FLICKER_S = 0.5  # flashes of a flicker are closer together than this, those of the healthy pattern are not


@dataclass(frozen=True)
class Seen:
    """What the LED said from a time on.

    Parameters
    ----------
    from_s
        When it began, s.
    pattern
        ``dark``, ``healthy``, ``sensor``, or ``alarm 2`` for two blinks.
    """

    from_s: float
    pattern: str


def read_led(edges: Edges, end_s: float) -> list[Seen]:
    """Tell what the LED said, in order; what goes on is told once.

    Parameters
    ----------
    edges
        The LED's changes.
    end_s
        When the observation ended, s.
    """
    on, lengths = _flashes(edges, end_s)
    seen: list[Seen] = []

    def say(from_s: float, pattern: str) -> None:
        if not seen or seen[-1].pattern != pattern:
            seen.append(Seen(from_s, pattern))

    i = 0
    while i < len(on):
        if lengths[i] >= _BLINK_S:
            last = i
            while last + 1 < len(on) and lengths[last + 1] >= _BLINK_S and on[last + 1] - on[last] < _GROUP_S:
                last += 1
            complete = last + 1 < len(on) or end_s - on[last] > _GROUP_S
            if complete:
                say(float(on[i]), f"alarm {last - i + 1}")
            i = last + 1
            continue
        near = (i > 0 and on[i] - on[i - 1] < _FLICKER_S and lengths[i - 1] < _BLINK_S) or (
            i + 1 < len(on) and on[i + 1] - on[i] < _FLICKER_S and lengths[i + 1] < _BLINK_S
        )
        say(float(on[i]), "sensor" if near else "healthy")
        i += 1
    return seen or [Seen(0.0, "dark")]


def _flashes(edges: Edges, end_s: float) -> tuple[np.ndarray[tuple[int], np.dtype[np.float64]], list[float]]:
    """When the LED went on, s, and for how long."""
    times, levels = edges.seconds, edges.levels
    rises = np.flatnonzero(levels)
    ends = np.append(times, end_s)
    return times[rises], [float(ends[i + 1] - times[i]) for i in rises]
