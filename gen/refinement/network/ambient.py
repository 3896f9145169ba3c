"""An ambient that moves, of a motor whose file holds it for fixed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gen.coefficients import Coefficients
from gen.refinement.gains import LEAST_GAIN, LEVEL
from gen.refinement.network.effects.walls import Walls
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data, make_data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.tracing.judged import Judged, judged, p_better
from gen.refinement.network.tracing.trace import Traced
from gen.runs import AMBIENT, Run


@dataclass(frozen=True)
class MovingAmbient:
    """That the measured ambient tells what the fixed one does not.

    Attributes
    ----------
    channel
        The column.
    fixed_K, measured_K
        Error on what was left out of the later runs, the file's numbers fitted to the rest with either.
    p_value
        That it is chance.
    as_it_is
        Whether the file as it is, its numbers not fitted, predicts better with it, too.
    """

    channel: str
    fixed_K: float
    measured_K: float
    p_value: float
    as_it_is: bool


def moving_ambient(
    coefficients: Coefficients, runs: Sequence[tuple[str, Run]], data: Data, traced: Traced
) -> MovingAmbient | None:
    """Compare the file's fixed ambient with the measured one.

    The file's numbers are fitted with either: a motor that was identified in a room that stood still shows nothing of
    how it follows one that moves, and its file may predict that badly. Where that says nothing, the same is asked with
    the effects that were found on both sides. Where walls were found that lag behind the air, they and the air together
    are compared with a fixed ambient, all else that was found on both sides.

    Parameters
    ----------
    coefficients
        The file.
    runs, data
        The later runs, and their bins with the measured ambient.
    traced
        What was found in these.

    Returns
    -------
    MovingAmbient or None
        None where the file names a channel, not every run has one, it does not move, or nothing gets better.
    """
    if coefficients.model.ambient_channel is not None or not data.offered.room_moves:
        return None
    fixed = make_data(coefficients, runs, as_declared=True)
    bench = Bench(fixed)
    shape = Anchored.of(traced.null.fitted.shape.network, traced.null.fitted.shape.full_scale, fixed.columns)
    base = bench.first(shape)
    found = traced.final.fitted.shape.effects
    others = [effect for effect in found if not isinstance(effect, Walls)]
    through_walls = len(others) < len(found)
    as_it_is = not through_walls and traced.file.score_K < judged(fixed, base, bench.as_it_is(shape)).score_K
    if not through_walls:
        told = _told(fixed, judged(fixed, base, bench.left_out(base)), traced.null, as_it_is=as_it_is)
        if told is not None or not others:
            return told
    # What else is wrong may hide how far the room has moved.
    beside = bench.fit(shape.with_effects(*others), base) if others else base
    return _told(fixed, judged(fixed, beside, bench.left_out(beside)), traced.final, as_it_is=as_it_is)


def _told(data: Data, without: Judged, measured: Judged, *, as_it_is: bool) -> MovingAmbient | None:
    p = p_better(data, without, measured)
    if p > LEVEL or measured.score_K > (1.0 - LEAST_GAIN) * without.score_K:
        return None
    return MovingAmbient(AMBIENT, without.score_K, measured.score_K, p, as_it_is)
