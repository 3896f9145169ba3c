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
        Error of the file on the later runs with either.
    p_value
        That it is chance.
    """

    channel: str
    fixed_K: float
    measured_K: float
    p_value: float


def moving_ambient(
    coefficients: Coefficients, runs: Sequence[tuple[str, Run]], data: Data, file: Judged
) -> MovingAmbient | None:
    """Compare the file's fixed ambient with the measured one.

    Parameters
    ----------
    coefficients
        The file.
    runs, data
        The later runs, and their bins with the measured ambient.
    file
        The file as it is, judged on these.

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
    shape = Anchored(file.fitted.shape.network, file.fitted.shape.full_scale, fixed.columns)
    as_it_is = judged(fixed, file.fitted, Bench(fixed).as_it_is(shape))
    p = p_better(data, as_it_is, file)
    if p > LEVEL or file.score_K > (1.0 - LEAST_GAIN) * as_it_is.score_K:
        return None
    return MovingAmbient(AMBIENT, as_it_is.score_K, file.score_K, p)
