"""The sum of squares that is minimised: readings of all runs, weighed by what they can tell, and priors.

The vector of parameters begins with those that all runs share (see `structure`); then, run by run, each node's start
(K, from where the readings begin) and the hats of an unmeasured ambient (K).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
from scipy.linalg.blas import dsyrk

from gen.arrays import FloatArray, IntArray, SingleArray
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.fitting.physics import Begun, Physical, Shape
from gen.identification.network.fitting.priors import Prior
from gen.identification.network.fitting.simulation import Steps, sensitivities, simulate, steps_of


@dataclass(frozen=True, eq=False)
class Evaluated:
    """One vector of parameters along all runs.

    Attributes
    ----------
    residual
        Reading minus model, shape (N, S), K; 0 where nothing was read.
    cost
        Sum of the weighed squares, without the prior.
    after
        Temperatures at the ends of the bins, shape (N, n), degC.
    """

    residual: FloatArray
    cost: float
    after: FloatArray


@dataclass(frozen=True, eq=False)
class Passage:
    """All runs simulated with one vector of parameters, before anything is compared with readings.

    Attributes
    ----------
    vector
        Shape (P,).
    found, steps
        The network at each distinct input, and its steps over the bins.
    before, after
        Temperatures at the beginnings and at the ends of the bins, shape (N, n) each, degC.
    room
        The unknown part of the ambient, shape (N,), K.
    begun
        Starts of hidden nodes, where these follow from others.
    """

    vector: FloatArray
    found: Physical
    steps: Steps
    before: FloatArray
    after: FloatArray
    room: FloatArray
    begun: Begun | None


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations by run over the shared parameters and the run's own, without priors.

    Attributes
    ----------
    matrix
        J^T W J, shape (R, p, p).
    vector
        J^T W residual, shape (R, p).
    """

    matrix: FloatArray
    vector: FloatArray


def _square(lines: FloatArray) -> FloatArray:
    """L^T L, shape (p, p), of which only a half is computed."""
    half = dsyrk(1.0, lines.T)  # Fortran's order: no copy; 0 below the diagonal
    whole = np.asarray(half + half.T)
    np.fill_diagonal(whole, half.diagonal())
    return whole


S_co = TypeVar("S_co", bound=Shape, covariant=True)


@dataclass(frozen=True, eq=False)
class Problem(Generic[S_co]):
    """Runs, network and priors."""

    structure: S_co
    inputs: Inputs
    prior: Prior

    @property
    def runs(self) -> int:
        """How many."""
        return len(self.inputs.runs)

    @property
    def own(self) -> int:
        """Parameters of one run alone."""
        return self.structure.nodes + int(self.inputs.room.shape[-1])

    @property
    def size(self) -> int:
        """All parameters."""
        return self.structure.size + self.runs * self.own

    def columns(self, run: int) -> IntArray:
        """Where in the vector the shared parameters and a run's own stand, shape (p,)."""
        first = self.structure.size + run * self.own
        return np.concatenate([np.arange(self.structure.size), np.arange(first, first + self.own)])

    def per_run(self, vector: FloatArray) -> FloatArray:
        """Each run's own parameters, shape (R, own)."""
        return vector[self.structure.size :].reshape(self.runs, self.own)

    def _begin(self, vector: FloatArray) -> tuple[FloatArray, FloatArray, Begun | None]:
        """Temperatures at the start, shape (R, n), the unknown part of the ambient, shape (N,), and hidden starts."""
        own = self.per_run(vector)
        nodes, sensors = self.structure.nodes, self.structure.sensors
        begin = np.repeat(self.inputs.begin[:, -1:], nodes, axis=1)
        begin[:, :sensors] = self.inputs.begin[:, :sensors]
        room = np.einsum("nb,nb->n", self.inputs.room, own[self.inputs.run, nodes:])
        ambient = np.array([run.ambient[0] for run in self.inputs.runs])
        if self.inputs.room.shape[-1]:
            ambient = ambient + own[:, nodes]  # the first hat is 1 where the run begins
        begun = self.structure.begun(vector, begin[:, :sensors] + own[:, :sensors], ambient)
        if begun is not None:
            begin[:, sensors:] = begun.temperature
        return begin + own[:, :nodes], room, begun

    def let_begin(self, vector: FloatArray) -> FloatArray:
        """Where nodes begin beside what each run has of its own, shape (R, n), degC."""
        return self._begin(vector)[0] - self.per_run(vector)[:, : self.structure.nodes]

    def _with_starts(self, slopes: SingleArray, begun: Begun) -> None:
        """Let hidden nodes' starts go with what they follow from, in place.

        Parameters
        ----------
        slopes
            Derivatives with each start on its own, shape (N, S, p).
        begun
            The hidden nodes' starts.
        """
        size, nodes, sensors = self.structure.size, self.structure.nodes, self.structure.sensors
        runs, hidden = begun.temperature.shape
        by = np.zeros((runs, hidden, slopes.shape[-1]), dtype=slopes.dtype)
        by[..., :size] = begun.by_shared
        by[..., size : size + sensors] = begun.by_sensed
        if self.own > nodes:
            by[..., size + nodes] = begun.by_ambient
        for row, own in zip(self.inputs.rows, by, strict=True):
            slopes[row] += slopes[row][..., size + sensors : size + nodes] @ own

    def ambient(self, vector: FloatArray) -> FloatArray:
        """Ambient of each bin, with what is unknown of it, shape (N,), degC."""
        return self.inputs.ambient + self._begin(vector)[1]

    def evaluate(self, vector: FloatArray) -> Evaluated:
        """Simulate all runs, and compare."""
        return self.compared(self.passage(vector))

    def passage(self, vector: FloatArray) -> Passage:
        """Simulate all runs."""
        found = self.structure.physical(self.inputs.levels, vector)
        steps = steps_of(self.structure, self.inputs.levels, found)
        start, room, begun = self._begin(vector)
        return Passage(vector, found, steps, *simulate(self.inputs, steps, found, start, room), room, begun)

    def compared(self, passage: Passage) -> Evaluated:
        """Compare runs that were simulated with their readings."""
        inputs = self.inputs
        model = self.structure.shown(inputs, passage.vector, *self._at_readings(passage))
        residual = np.where(inputs.covered > 0.0, inputs.target - model, 0.0)
        return Evaluated(residual, self._cost(residual), passage.after)

    def _at_readings(self, passage: Passage) -> tuple[FloatArray, FloatArray]:
        """Sensed nodes' temperatures at the readings' time, and their changes, shape (N, S) each, degC and K/s."""
        sensors = self.structure.sensors
        old, new = passage.before[:, :sensors], passage.after[:, :sensors]
        return old + self.inputs.share * (new - old), (new - old) / self.inputs.width[:, None]

    def _cost(self, residual: FloatArray) -> float:
        return float(np.einsum("ns,ns->", self.inputs.weight, residual**2))

    def linearised(self, vector: FloatArray) -> tuple[Evaluated, Normal]:
        """Simulate, and give the normal equations."""
        return self.linearised_along(self.passage(vector))

    def linearised_along(self, passage: Passage) -> tuple[Evaluated, Normal]:
        """Give the normal equations of runs that were simulated."""
        return self.weighed_up(self.compared(passage), self.slopes_along(passage))

    def weighed_up(self, evaluated: Evaluated, slopes: SingleArray) -> tuple[Evaluated, Normal]:
        """Give the normal equations with this problem's weights, of whatever weights the same runs were evaluated."""
        evaluated = replace(evaluated, cost=self._cost(evaluated.residual))
        root = np.sqrt(self.inputs.weight)
        count = self.structure.size + self.own
        matrix, right = np.zeros((self.runs, count, count)), np.zeros((self.runs, count))
        weighed = root * evaluated.residual
        # One place for the lines of all runs, one after the other: new memory for each takes longer than they do.
        place = np.empty((max(row.size for row in self.inputs.rows), *slopes.shape[1:]))
        for r, row in enumerate(self.inputs.rows):
            if not root[row].any():
                continue  # left out
            lines = np.multiply(slopes[row], root[row][:, :, None], out=place[: row.size]).reshape(-1, count)
            matrix[r] = _square(lines)
            right[r] = lines.T @ weighed[row].ravel()
        return evaluated, Normal(matrix, right)

    def slopes(self, vector: FloatArray) -> tuple[Evaluated, SingleArray]:
        """Simulate, and give the derivatives of the modelled readings.

        Returns
        -------
        evaluated, slopes
            Derivatives by the shared parameters and the own ones of the bin's run, shape (N, S, p).
        """
        passage = self.passage(vector)
        return self.compared(passage), self.slopes_along(passage)

    def slopes_along(self, passage: Passage) -> SingleArray:
        """Give the derivatives alone, of runs that were simulated."""
        structure, inputs, vector = self.structure, self.inputs, passage.vector
        path = passage.before, passage.after
        slopes, changes = sensitivities(structure, inputs, passage.found, passage.steps, path, passage.room)
        if passage.begun is not None:
            self._with_starts(slopes, passage.begun)
        structure.through_sensors(inputs, vector, slopes, changes)
        for sensor, column, each in structure.by_reading(inputs, vector, *self._at_readings(passage)):
            slopes[:, sensor, column] += each
        return slopes

    def assembled(self, normal: Normal, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Normal equations of all parameters with priors.

        Returns
        -------
        matrix, right
            Shapes (P, P) and (P,); the step solves matrix * step = right.
        """
        shared = self.structure.size
        matrix, right = self.prior.precision.copy(), self.prior.precision @ (self.prior.mean - vector)
        matrix[:shared, :shared] += normal.matrix[:, :shared, :shared].sum(axis=0)
        right[:shared] += normal.vector[:, :shared].sum(axis=0)
        for r in range(self.runs):
            own = slice(shared + r * self.own, shared + (r + 1) * self.own)
            matrix[:shared, own] += normal.matrix[r, :shared, shared:]
            matrix[own, :shared] += normal.matrix[r, shared:, :shared]
            matrix[own, own] += normal.matrix[r, shared:, shared:]
            right[own] += normal.vector[r, shared:]
        implausible, slopes = self.structure.implausible(vector)
        matrix[:shared, :shared] += slopes.T @ slopes
        right[:shared] -= slopes.T @ implausible
        return matrix, right

    def penalty(self, vector: FloatArray) -> float:
        """Give the prior's part of the cost."""
        away = vector - self.prior.mean
        implausible, _ = self.structure.implausible(vector)
        return float(away @ self.prior.precision @ away + implausible @ implausible)

    def weighed(self, weight: FloatArray) -> Problem[S_co]:
        """Give the same problem with other weights of the readings."""
        return replace(self, inputs=replace(self.inputs, weight=weight))
