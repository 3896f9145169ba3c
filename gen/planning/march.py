"""One hypothesis along many runs of a few levels, fast, with its sensitivities.

At one level and one width of bins the temperatures and their derivatives go on by the same affine map, bin by bin:
the map is made once for each level, from the fit's own derivatives, and runs are but a row of such maps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.network.fitting.inputs import START_K
from gen.identification.network.fitting.priors import Prior
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.simulation import sources_of, steps_of
from gen.planning.hypotheses import Hypothesis
from gen.planning.stage import Stage
from gen.refinement.network.fitting.anchored import Anchored


@dataclass(frozen=True, eq=False)
class Predicted:
    """One hypothesis along K runs of T bins.

    Attributes
    ----------
    reading
        Shape (K, T S), degC.
    slopes
        By its numbers and each node's start, shape (K, T S, p).
    hottest
        Of each of the file's nodes, shape (K, n), degC.
    """

    reading: FloatArray
    slopes: FloatArray
    hottest: FloatArray


def problem_of(hypothesis: Hypothesis, stage: Stage, pwm: IntArray, density: FloatArray) -> Problem[Anchored]:
    """Give the problem of a hypothesis in runs, its numbers known as well as the runs before tell.

    Parameters
    ----------
    hypothesis, stage
        What is run, and where.
    pwm
        Shape (K, T), counts.
    density
        Of errors, shape (S,), K^2 s.
    """
    shape, runs = hypothesis.shape, pwm.shape[0]
    own = runs * shape.nodes
    precision = np.zeros((shape.size + own, shape.size + own))
    precision[: shape.size, : shape.size] = hypothesis.precision
    starts = np.arange(shape.size, shape.size + own)
    precision[starts, starts] = START_K**-2
    inputs = stage.inputs(pwm)
    problem = Problem(shape, inputs, Prior(np.concatenate([hypothesis.shared, np.zeros(own)]), precision))
    return problem.weighed(inputs.covered / density)


class March:
    """A hypothesis at some levels.

    Parameters
    ----------
    hypothesis, stage
        What is run, and where.
    levels
        PWM, counts.
    """

    def __init__(self, hypothesis: Hypothesis, stage: Stage, levels: tuple[int, ...]) -> None:
        shape = hypothesis.shape
        self._hypothesis, self._stage, self._levels = hypothesis, stage, np.array(levels, dtype=np.int64)
        inputs = stage.inputs(self._levels[:, None])
        found = shape.physical(inputs.levels, hypothesis.shared)
        steps = steps_of(shape, inputs.levels, found)
        at, nodes, room = inputs.level, shape.nodes, np.zeros(self._levels.size)
        driven = np.einsum("lij,lj->li", steps.gain, steps.outside * stage.ambient + found.heat)
        self._matrix, self._driven = steps.matrix[at], driven[at]
        still = np.zeros((self._levels.size, nodes))
        constant = sources_of(shape, inputs, found, steps, still, room).astype(np.float64)
        by_state = [
            sources_of(shape, inputs, found, steps, still + unit, room).astype(np.float64) - constant
            for unit in 100.0 * np.eye(nodes)  # single precision: far from nothing
        ]
        # (L, p, n + 1, n): what a state, and 1, add to the derivatives.
        self._sources = np.stack([*(one / 100.0 for one in by_state), constant], axis=-1)

    def hottest(self, index: IntArray) -> FloatArray:
        """Give the hottest temperature of each of the file's nodes, shape (K, n), degC.

        Parameters
        ----------
        index
            Which level in each bin, shape (K, T).
        """
        shape = self._hypothesis.shape
        state = np.full((len(index), shape.nodes), self._stage.ambient)
        hottest = state.copy()
        for now in index.T:
            state = np.einsum("kij,kj->ki", self._matrix[now], state) + self._driven[now]
            np.maximum(hottest, state, out=hottest)
        return hottest[:, : shape.base_nodes]

    def predicted(self, index: IntArray) -> Predicted:
        """Simulate with sensitivities; the argument is that of :meth:`hottest`."""
        shape = self._hypothesis.shape
        runs, bins, nodes, sensors = *index.shape, shape.nodes, shape.sensors
        state = np.full((runs, nodes), self._stage.ambient)
        hottest = state.copy()
        slope = np.zeros((runs, nodes, self._sources.shape[2]))
        slope[:, :, shape.size : shape.size + nodes] = np.eye(nodes)
        at = np.empty((bins, runs, sensors))
        change = np.empty_like(at)
        slopes = np.empty((bins, runs, sensors, slope.shape[-1]))
        lagging = list(shape.lagging)
        changing = np.empty((bins, runs, len(lagging), slope.shape[-1]))
        for k, now in enumerate(index.T):
            after = np.einsum("kij,kj->ki", self._matrix[now], state) + self._driven[now]
            known = np.concatenate([state, np.ones((runs, 1))], axis=1)
            grown = self._matrix[now] @ slope + (self._sources[now] @ known[:, None, :, None])[..., 0]
            at[k] = 0.5 * (state + after)[:, :sensors]
            change[k] = (after - state)[:, :sensors] / self._stage.bin_s
            slopes[k] = 0.5 * (slope + grown)[:, :sensors]
            changing[k] = (grown - slope)[:, lagging] / self._stage.bin_s
            state, slope = after, grown
            np.maximum(hottest, state, out=hottest)
        inputs = self._stage.inputs(self._levels[index])
        flat, changes = at.reshape(-1, sensors), change.reshape(-1, sensors)
        reading = shape.shown(inputs, self._hypothesis.shared, flat, changes).reshape(bins, runs, sensors)
        every = slopes.reshape(bins * runs, sensors, -1)
        shape.through_sensors(
            inputs, self._hypothesis.shared, every, changing.reshape(bins * runs, len(lagging), slope.shape[-1])
        )
        for sensor, column, each in shape.by_reading(inputs, self._hypothesis.shared, flat, changes):
            every[:, sensor, column] += each
        return Predicted(
            np.swapaxes(reading, 0, 1).reshape(runs, -1),
            np.swapaxes(slopes, 0, 1).reshape(runs, bins * sensors, -1),
            hottest[:, : shape.base_nodes],
        )
