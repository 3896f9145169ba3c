"""An ambient that moves, of a motor whose file holds it for fixed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.coefficients import Coefficients
from gen.refinement.judgement import LEAST_GAIN, LEVEL
from gen.refinement.network.anchored import Anchored
from gen.refinement.network.data import Data, make_data
from gen.refinement.network.fit import Bench
from gen.refinement.network.judged import Judged, judged, p_better
from gen.runs import AMBIENT, Run

MOVES_K = 0.3
"""Standard deviation of an ambient that moves."""


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
    coefficients: Coefficients, runs: Sequence[tuple[str, Run]], data: Data, file: Judged, null: Judged
) -> MovingAmbient | None:
    """Compare the file's fixed ambient with the measured one.

    The file's numbers are fitted with either: a motor that was identified in a room that stood still shows nothing of
    how it follows one that moves, and its file may predict that badly.

    Parameters
    ----------
    coefficients
        The file.
    runs, data
        The later runs, and their bins with the measured ambient.
    file, null
        The file as it is, judged on these, and its numbers fitted to them, without any effect.

    Returns
    -------
    MovingAmbient or None
        None where the file names a channel, not every run has one, it does not move, or nothing gets better.
    """
    if coefficients.model.ambient_channel is not None or any(run.ambient is None for _, run in runs):
        return None
    if float(np.std(data.inputs.ambient[data.is_later])) < MOVES_K:
        return None
    fixed = make_data(coefficients, runs, as_declared=True)
    bench = Bench(fixed)
    shape = Anchored(null.fitted.shape.network, null.fitted.shape.full_scale, fixed.columns)
    base = bench.first(shape)
    without = judged(fixed, base, bench.left_out(base))
    p = p_better(data, without, null)
    if p > LEVEL or null.score_K > (1.0 - LEAST_GAIN) * without.score_K:
        return None
    as_it_is = judged(fixed, base, bench.as_it_is(shape))
    return MovingAmbient(AMBIENT, without.score_K, null.score_K, p, file.score_K < as_it_is.score_K)
