"""A fault is not an effect: what looks like another motor is said, and not learnt."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.refinement.network.effects import HiddenNode, NetworkEffect, ScheduleError, SensorGain
from gen.refinement.network.effects.base import GROWN, WHOLE
from gen.refinement.network.fitting.data import Data

GROWN_EVERYWHERE, NEARLY_ALL = 1.01, 0.1
"""`GROWN` of all heat together, which runs tell better than that of one node, at all but this share of the speeds."""
FALLEN_EVERYWHERE = 0.97
"""The same of heat that has become less. Less is no fault: it takes more to be told as a change, and none is sought."""
PEAK = 3.0
"""Heat of the whole motor that has grown at a speed between by this factor more than at the lowest and the highest that
were run is that of a resonance, or of a schedule that was wrong there: what covers or loads a motor does not peak. Nor
does what asks for less heat."""
RISES = 0.5
"""What wear adds at the highest speed is at least this share of what it adds at any: what rubs, and the current that it
asks for, heat more the faster it turns. A resonance does not."""
OTHER_ROOM_K = 5.0
"""An ambient further than this beyond all that a file knows is another season's: what heats by a law of temperature
that nobody told the file (copper, grease) heats otherwise there."""
QUICK_S, WARM, HOT = 100.0, 1.0, 5.0
"""A part without a sensor is heat rather than mass if its heat would warm it this many times as fast as the motor's
warms the motor: more than `WARM` where it follows its node sooner than this, `HOT` however late it follows."""


def looks_like_a_change(effect: NetworkEffect, values: Sequence[float], data: Data) -> str:
    """Say why what was found may be another motor, or nothing.

    Parameters
    ----------
    effect, values
        What was found, and its numbers.
    data
        The runs, for the speeds that they hold.
    """
    speed = _turned(data)
    found = (
        has_grown(effect, values, data)
        or _fallen(effect, values, speed)
        or _of_the_only_sensor(effect, values, data)
        or effect.change(values)
    )
    if not found or not effect.of_the_motor:
        return found
    return (
        f"{found}: the motor has changed since the file was made, or the file was wrong there: run "
        f"{100.0 * float(np.median(speed)):.0f} % again as then{_other_room(data)}"
    )


def _other_room(data: Data) -> str:
    """Say that the later runs had another ambient than those of the file; nothing where they had not."""
    if data.identified_degC is None:
        return ""
    coldest, warmest = data.identified_degC
    room = float(np.median(data.inputs.ambient[data.is_later]))
    if coldest - OTHER_ROOM_K <= room <= warmest + OTHER_ROOM_K:
        return ""
    known = f"{coldest:.0f} to {warmest:.0f}" if warmest - coldest >= 1.0 else f"{coldest:.0f}"
    return (
        f", and in a room as then: it was {room:.0f} degC in these runs and {known} degC in those of the file, and "
        "grease, or copper, heats otherwise in another room without any fault"
    )


def has_grown(effect: NetworkEffect, values: Sequence[float], data: Data) -> str:
    """Say where heat has grown as that of a fault does; nothing where it has not.

    A wrong schedule is too high at some speeds and too low at others, or wrong at a few; a bearing or a brush that is
    worn heats more at all of them, the more the faster it turns, at one node alone; so does, everywhere and with no
    such order, a motor that is loaded or covered with dust.

    Parameters
    ----------
    effect, values, data
        As above.
    """
    grown = "" if _cools(effect, values, data) else _grown(effect, values, _turned(data))
    if not grown:
        return ""
    if effect.component == WHOLE:
        pattern = "as that of a motor that is worn, loaded more, or cools less (dust on it, a cover) does"
    elif effect.component in data.offered.hottest_degC:
        pattern = "and there alone, as a fault's does (a worn bearing or brush heats like that)"
    else:
        pattern = "as a fault's does (a worn bearing or brush heats like that), and so does what cools less there"
    return f"{effect.component}: its heat has grown {grown} at every speed that was run, {pattern}"


def _fallen(effect: NetworkEffect, values: Sequence[float], speed: FloatArray) -> str:
    """Say by how much the heat of the whole motor is less at ascending speeds, shape (L,); nothing where it is not."""
    if not isinstance(effect, ScheduleError) or effect.component != WHOLE:
        return ""
    factor = effect.factor(speed, values)
    most = float(np.quantile(factor, 1.0 - NEARLY_ALL))
    if most > FALLEN_EVERYWHERE or _peaks(1.0 - factor):
        return ""
    return (
        f"{WHOLE}: its heat is less by {1.0 - most:.0%} to {1.0 - factor.min():.0%} at every speed that was run, as of "
        "a motor with a lower supply, or with less load"
    )


def _of_the_only_sensor(effect: NetworkEffect, values: Sequence[float], data: Data) -> str:
    """Say that a sensor's gain is the motor's heat as well, where no other sensor tells the two apart."""
    if not isinstance(effect, SensorGain) or len(data.offered.hottest_degC) > 1:
        return ""
    return (
        f"{effect.component}: it reads {abs(values[0]):.0%} {'more' if values[0] > 0.0 else 'less'} of its "
        f"{effect.acts_by['of']}, and with this one sensor that is all of the motor's heat that has "
        f"{'grown' if values[0] > 0.0 else 'become less'} as well"
    )


def _turned(data: Data) -> FloatArray:
    """At which speeds the motor turned in the later runs, ascending, shape (L,)."""
    levels = data.inputs.levels
    turning = levels.turns & (data.columns.later(levels) > 0.5)
    return np.unique(np.round(levels.speed[turning], 2))


def _grown(effect: NetworkEffect, values: Sequence[float], speed: FloatArray) -> str:
    """By how much heat has grown at every one of ascending speeds, shape (L,); empty where it has not."""
    if isinstance(effect, HiddenNode):
        least = WARM if effect.follows_within_s(values) < QUICK_S else HOT
        added_W = effect.heat_W(speed, values) if effect.warming(values) > least else np.zeros(1)
        return f"by {added_W.min():.2g} to {added_W.max():.2g} W" if added_W[-1] > 0.0 and not _falls(added_W) else ""
    if not isinstance(effect, ScheduleError):
        return ""
    if not effect.replaces:
        return f"by {values[0]:.3g} W at full speed" if values[0] > 0.0 else ""
    factor = effect.factor(speed, values)
    everywhere = effect.component == WHOLE
    least = float(np.quantile(factor, NEARLY_ALL) if everywhere else factor.min())
    if least < (GROWN_EVERYWHERE if everywhere else GROWN):
        return ""
    if _peaks(factor - 1.0) if everywhere else _falls(effect.added_W(speed, values)):
        return ""
    return f"by {least - 1.0:.0%} to {factor.max() - 1.0:.0%}"


def _cools(effect: NetworkEffect, values: Sequence[float], data: Data) -> bool:
    """Whether a part that was added takes more heat off its node, hot, than it brings at full speed."""
    hottest = data.offered.hottest_degC.get(effect.component)
    if not isinstance(effect, HiddenNode) or hottest is None:
        return False
    later = data.is_later
    rise_K = hottest - float(np.median(data.inputs.ambient[later]))
    return effect.cools_W(rise_K, values) > float(effect.heat_W(np.ones(1), values)[0])


def _falls(added_W: FloatArray) -> bool:
    """Whether heat over ascending speeds, shape (L,), W, is much less at the last than at one before it."""
    return bool(added_W[-1] < RISES * added_W.max())


def _peaks(differs: FloatArray) -> bool:
    """Whether what differs over ascending speeds, shape (L,), does so between both ends by far more than at these."""
    return bool(differs.max() > PEAK * max(differs[0], differs[-1]))
