"""Runs that begin while the inside of a motor is warmer than its sensors say.

The fit gives each run a start of its own, so that what is sought as an effect is not a start. Whoever uses the file has
no such choice: hidden nodes start where the file says. So, last of all, the runs are followed once more from there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.refinement.gains import LEAST_GAIN, LEVEL
from gen.refinement.network.effects.walls import Walls
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data
from gen.refinement.network.fitting.fit import Fitted
from gen.refinement.network.tracing.judged import Judged, judged, p_better
from gen.refinement.network.tracing.search import PLAIN, PLAIN_LEVEL
from gen.refinement.verdict import EXPLAINED

SPREAD = 1.0
"""Standard deviation of a factor about what the file says."""
LEAST, MOST = 0.0, 8.0
"""What a file may hold, times the shares that its nodes start from."""
MARGIN = 1e-3
LEAST_K = 2.0
"""A hidden node that would rest less than this above the ambient, at the start of every run, tells nothing of one."""


@dataclass(frozen=True, eq=False)
class WarmStart:
    """How the later runs go on from where the file lets hidden nodes start.

    Attributes
    ----------
    file
        As the file says.
    factors
        By hidden node: what the file should say; empty if it need not.
    with_factors
        Judged with factors from the other runs.
    p_value
        That it is chance.
    by_the_room
        Whether hidden nodes begin no further from the ambient than it moves in that run: then what they still have is
        the room's past, not the motor's.
    walls
        Judged with walls that begin as warm as the air, as the file has them; None without any.
    """

    file: Judged
    factors: dict[str, float]
    with_factors: Judged
    p_value: float
    by_the_room: bool = False
    walls: Judged | None = None

    @property
    def named(self) -> bool:
        """Whether it is an effect of its own."""
        return bool(self.factors) and not self.by_the_room

    @property
    def as_the_file(self) -> WarmStart:
        """Without factors: those that were found beside an effect are right beside that effect only."""
        return replace(self, factors={}, with_factors=self.file)

    @property
    def warnings(self) -> list[str]:
        """What is written without a name, and what walls begin at, a sentence each."""
        return [*self._by_the_room(), *self._walls()]

    def _by_the_room(self) -> list[str]:
        if not self.factors or self.named:
            return []
        each = ", ".join(f"{name} {factor:.2g}" for name, factor in self.factors.items())
        return [
            "runs begin while parts without a sensor still follow the room as it was before: what they begin at "
            f"(`start_factor`) is fitted to that ({each})"
        ]

    def _walls(self) -> list[str]:
        if self.walls is None or self.walls.floors <= EXPLAINED:
            return []
        return [
            "the file lets walls begin as warm as the air, as nobody knows how warm they are: from there the runs are "
            f"missed by {self.walls.score_K:.2g} K, by less as hours pass; begin when the room has stood still"
        ]

    @property
    def floors(self) -> float:
        """Error of what will be written, in noise floors."""
        own = (self.with_factors if self.factors else self.file).floors
        return own if self.walls is None else max(own, self.walls.floors)


def warm_start(data: Data, final: Judged) -> WarmStart:
    """Compare the starts that the file says with others: of the file's own hidden nodes, and of walls.

    Parameters
    ----------
    data
        The runs.
    final
        With all that was found.
    """
    return replace(_of_hidden(data, final.fitted), walls=_of_walls(data, final.fitted))


def _of_walls(data: Data, fitted: Fitted) -> Judged | None:
    """Let walls begin as warm as the air, all else as it was fitted: how warm they are is in no sensor."""
    shape = fitted.shape
    walls = [place.node for effect, place in zip(shape.effects, shape.places, strict=True) if isinstance(effect, Walls)]
    if not walls:
        return None
    vector = fitted.vector.copy()
    own = vector[shape.size :].reshape(fitted.problem.runs, fitted.problem.own)
    let = fitted.problem.let_begin(vector)
    own[: data.later, walls] = _ambient(data)[:, None] - let[: data.later, walls]
    seen = data.is_later[:, None] & (data.inputs.covered > 0.0)
    return judged(data, fitted, np.where(seen, fitted.problem.evaluate(vector).residual, np.nan))


def _of_hidden(data: Data, fitted: Fitted) -> WarmStart:
    """The same of the file's own hidden nodes, walls beginning as they were fitted."""
    shape, problem = fitted.shape, fitted.problem
    hidden = np.arange(shape.sensors, shape.base_nodes)
    rises = _rises(shape, data, fitted)
    vector = fitted.vector.copy()
    own = vector[shape.size :].reshape(problem.runs, problem.own)
    said = np.array([shape.network.nodes[shape.order[k]].start_factor for k in hidden])
    let = problem.let_begin(vector)
    own[: data.later, hidden] = _ambient(data)[:, None] + said * rises - let[: data.later, hidden]
    evaluated, slopes = problem.slopes(vector)
    seen = data.is_later[:, None] & (data.inputs.covered > 0.0)
    file = judged(data, fitted, np.where(seen, evaluated.residual, np.nan))
    if not hidden.size or float(rises.max(initial=0.0)) < LEAST_K or data.later < 2:
        return WarmStart(file, {}, file, 1.0)
    # The starts enter linearly: what a unit of each factor adds to each reading.
    each = np.where(data.is_later[:, None], rises[np.minimum(data.inputs.run, data.later - 1)], 0.0)
    unit = np.asarray(slopes[:, :, shape.size + hidden] * each[:, None, :], dtype=np.float64)
    error = np.full(evaluated.residual.shape, np.nan)
    weight = problem.inputs.weight
    most = MOST / np.maximum(shape.network.expected_at_start.sum(axis=1), 1.0) - MARGIN
    free = _free(unit, evaluated.residual, weight, seen, said, most)
    for run in range(data.later):
        of = data.inputs.run == run
        change = free * _change(unit * free, evaluated.residual, weight, seen & ~of[:, None], said, most)
        error[of] = (evaluated.residual - unit @ change)[of]
    found = judged(data, fitted, np.where(seen, error, np.nan))
    p = p_better(data, file, found)
    chance = p > LEVEL and not (found.score_K < PLAIN * file.score_K and p < PLAIN_LEVEL)
    if chance or found.score_K > (1.0 - LEAST_GAIN) * file.score_K:
        return WarmStart(file, {}, file, p)
    factors = said + free * _change(unit * free, evaluated.residual, weight, seen, said, most)
    names = [shape.names[k] for k in hidden]
    moves = np.array([np.ptp(run.ambient) for run in data.inputs.runs[: data.later]])
    by_the_room = data.offered.room_moves and bool(np.all(np.abs(factors * rises) <= moves[:, None]))
    return WarmStart(file, dict(zip(names, factors.tolist(), strict=True)), found, p, by_the_room)


def _ambient(data: Data) -> FloatArray:
    """At the start of each later run, degC."""
    return np.array([run.ambient[0] for run in data.inputs.runs[: data.later]])


def _rises(shape: Anchored, data: Data, fitted: Fitted) -> FloatArray:
    """Where the file's hidden nodes begin in each later run but for their factor, over the ambient, shape (R, h), K."""
    sensors = shape.sensors
    own = fitted.problem.per_run(fitted.vector)[: data.later, :sensors]
    sensed = data.inputs.begin[: data.later, :sensors] + own - _ambient(data)[:, None]
    return np.asarray(sensed @ shape.network.expected_at_start.T)


def _free(
    unit: FloatArray,
    residual: FloatArray,
    weight: FloatArray,
    seen: BoolArray,
    said: FloatArray,
    most: FloatArray,
) -> FloatArray:
    """Say which factors may differ, 1 or 0, shape (h,): one that would end at the most that a file holds is none."""
    free = np.ones(said.size)
    while True:
        factors = said + free * _change(unit * free, residual, weight, seen, said, most)
        ends = (factors >= most) & (free > 0.0)
        if not ends.any():
            return free
        free[ends] = 0.0


def _change(
    unit: FloatArray,
    residual: FloatArray,
    weight: FloatArray,
    seen: BoolArray,
    said: FloatArray,
    most: FloatArray,
) -> FloatArray:
    """By how much the factors should differ, least squares with what is known of them, shape (h,)."""
    used = np.where(seen, weight, 0.0)
    matrix = np.einsum("nsh,ns,nsk->hk", unit, used, unit) + np.eye(said.size) / SPREAD**2
    right = np.einsum("nsh,ns,ns->h", unit, used, residual)
    return np.asarray(np.clip(said + np.linalg.solve(matrix, right), LEAST, most) - said)
