"""Reading the indicator LED with a clock, as somebody with the emitted README beside the motor would.

The patterns are those of the emitted sketch: a short flash every two seconds (healthy), slow blinks whose number is an
alarm rule's, a flicker (a sensor's sample is not believed), and a second on, a second off (the board acts on
something).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.emulate.wiring.levels import Edges

_BLINK_S = 0.16  # a blink is on for 0.256 s, a flash or a flicker for 0.064 s
_ACTS_S = 0.6  # acting it is on for 1.024 s
_GROUP_S = 0.6  # between the blinks of one number it is dark for 0.256 s
_OVER_S = 1.0  # after its last blink has begun, a number is over: the next blink would have ended by then
_PAUSE_S = 2.5  # behind a number it is dark for 1.792 s, or flickers
_STILL_S = 3.0  # no pattern stands still for so long
_SENSOR = "sensor"
LONGEST_CYCLE_S = 30.0
"""Sixteen blinks and what follows take 10 s; a few numbers that take turns come anew within this."""
_FLICKER_S = 0.5  # flashes of a flicker are closer together than this, those of the healthy pattern are not


@dataclass(frozen=True)
class Seen:
    """What the LED said from a time on.

    Parameters
    ----------
    from_s
        When it began, s.
    pattern
        ``dark``, ``lit`` (and nothing else), ``healthy``, ``sensor``, ``acts``, or ``alarm 2`` for two blinks.
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
        When the observation ended, s. What was not over by then is not told.
    """
    on, lengths = _flashes(edges)
    seen: list[Seen] = []

    def say(from_s: float, pattern: str) -> None:
        if not seen or seen[-1].pattern != pattern:
            seen.append(Seen(from_s, pattern))

    i = 0
    while i < len(on):
        if lengths[i] >= _ACTS_S:
            say(float(on[i]), "acts")
            i += 1
            continue
        if lengths[i] >= _BLINK_S:
            last = i
            while last + 1 < len(on) and _BLINK_S <= lengths[last + 1] < _ACTS_S and on[last + 1] - on[last] < _GROUP_S:
                last += 1
            complete = last + 1 < len(on) or end_s - on[last] > _OVER_S
            if complete:
                say(float(on[i]), f"alarm {last - i + 1}")
            i = last + 1
            continue
        near = (i > 0 and on[i] - on[i - 1] < _FLICKER_S and lengths[i - 1] < _BLINK_S) or (
            i + 1 < len(on) and on[i + 1] - on[i] < _FLICKER_S and lengths[i + 1] < _BLINK_S
        )
        if near or i + 1 < len(on) or end_s - on[i] > _FLICKER_S:
            say(float(on[i]), _SENSOR if near else "healthy")
        i += 1
    return seen or [Seen(0.0, "dark")]


def shown_now(edges: Edges, end_s: float) -> tuple[str, ...]:
    """What the LED says at a time: its pattern, or those that take turns.

    Parameters
    ----------
    edges
        The LED's changes in the last `LONGEST_CYCLE_S` and some seconds before.
    end_s
        The present, s.

    Returns
    -------
    tuple of str
        As :attr:`Seen.pattern` has them; those that take turns in the order in which they came.
    """
    times, levels = edges.seconds, edges.levels
    latest = float(times[-1]) if times.size else 0.0
    if end_s - latest > _STILL_S:
        return ("lit",) if times.size and levels[-1] else ("dark",)
    seen = read_led(edges, end_s)
    last = seen[-1]
    if not _takes_turns(last) or end_s - last.from_s > (_PAUSE_S if last.pattern == _SENSOR else LONGEST_CYCLE_S):
        return (last.pattern,)
    turns: list[str] = []
    for item in reversed(seen[:-1]):
        if not _takes_turns(item) or item.pattern == last.pattern or end_s - item.from_s > LONGEST_CYCLE_S:
            break
        if item.pattern not in turns:
            turns.insert(0, item.pattern)
    return (*turns, last.pattern)


def _takes_turns(item: Seen) -> bool:
    return item.pattern == _SENSOR or item.pattern.startswith("alarm")


def _flashes(edges: Edges) -> tuple[np.ndarray[tuple[int], np.dtype[np.float64]], list[float]]:
    """When the LED went on, s, and for how long; without one that is not over."""
    times, levels = edges.seconds, edges.levels
    rises = np.flatnonzero(levels[:-1])
    return times[rises], [float(times[i + 1] - times[i]) for i in rises]
