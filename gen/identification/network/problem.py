"""The sum of squares that is minimised: readings of all runs, weighed by what they can tell, and priors.

The vector of parameters begins with those that all runs share (see `structure`); then, run by run, each node's start
(K, from where the readings begin) and the hats of an unmeasured ambient (K).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.identification.network.bins import FloatArray, IntArray
from gen.identification.network.inputs import Inputs
from gen.identification.network.priors import Prior
from gen.identification.network.simulation import Slopes, physical, sensitivities, simulate, steps_of
from gen.identification.network.structure import Structure


@dataclass(frozen=True, eq=False)
class Evaluated:
    """One vector of parameters along all runs.

    Attributes
    ----------
    residual
        Reading minus model, shape (R, T, S), K; 0 where nothing was read.
    cost
        Of each run, without the prior, shape (R,).
    states
        Temperatures at the ends of the bins, shape (R, T + 1, n), degC.
    """

    residual: FloatArray
    cost: FloatArray
    states: FloatArray


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


@dataclass(frozen=True, eq=False)
class Problem:
    """Runs, network and priors."""

    structure: Structure
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

    def _begin(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Temperatures at the start, shape (R, n), and the unknown part of the ambient, shape (R, T)."""
        own = self.per_run(vector)
        nodes, sensors = self.structure.nodes, len(self.structure.sensed)
        begin = np.repeat(self.inputs.begin.mean(axis=1)[:, None], nodes, axis=1)
        begin[:, :sensors] = self.inputs.begin
        room = np.einsum("rtb,rb->rt", self.inputs.room, own[:, nodes:])
        return begin + own[:, :nodes], room

    def evaluate(self, vector: FloatArray) -> Evaluated:
        """Simulate all runs."""
        found = physical(self.structure, self.inputs.levels, vector)
        steps = steps_of(self.structure, self.inputs.levels, found)
        start, room = self._begin(vector)
        states = simulate(self.inputs, steps, found, start, room)
        return self._evaluated(vector, states)

    def _evaluated(self, vector: FloatArray, states: FloatArray) -> Evaluated:
        inputs, sensors = self.inputs, len(self.structure.sensed)
        shown = states[..., :sensors]
        model = shown[:, :-1] * (1.0 - inputs.share) + shown[:, 1:] * inputs.share + vector[self.structure.offsets]
        residual = np.where(inputs.weight > 0.0, inputs.target - model, 0.0)
        cost = np.einsum("rts,rts->r", inputs.weight, residual**2)
        return Evaluated(residual, cost, states)

    def linearised(self, vector: FloatArray) -> tuple[Evaluated, Normal]:
        """Simulate, and give the normal equations."""
        structure, inputs = self.structure, self.inputs
        found = physical(structure, inputs.levels, vector)
        steps = steps_of(structure, inputs.levels, found)
        start, room = self._begin(vector)
        states = simulate(inputs, steps, found, start, room)
        evaluated = self._evaluated(vector, states)
        slopes = sensitivities(structure, inputs, found, steps, states, room)
        root = np.sqrt(inputs.weight)
        count = self.structure.size + self.own
        matrix, right = np.empty((self.runs, count, count)), np.empty((self.runs, count))
        for r in range(self.runs):
            k = int(inputs.length[r])
            used = root[r, :k] > 0.0
            rows = self._shown(slopes[: k + 1, r], inputs.share[r, :k])[used] * root[r, :k][used][:, None]
            matrix[r] = rows.T @ rows
            right[r] = rows.T @ (evaluated.residual[r, :k][used] * root[r, :k][used])
        return evaluated, Normal(matrix, right)

    def jacobian(self, vector: FloatArray) -> FloatArray:
        """Derivatives of the modelled readings by the shared parameters and each run's own, shape (R, T, S, p)."""
        found = physical(self.structure, self.inputs.levels, vector)
        steps = steps_of(self.structure, self.inputs.levels, found)
        start, room = self._begin(vector)
        states = simulate(self.inputs, steps, found, start, room)
        slopes = sensitivities(self.structure, self.inputs, found, steps, states, room)
        shares = self.inputs.share
        return np.array([self._shown(slopes[:, r], shares[r]) for r in range(self.runs)])

    def _shown(self, slopes: Slopes, share: FloatArray) -> FloatArray:
        """From temperatures at the ends of one run's bins to readings in them, the offsets' columns put in.

        Parameters
        ----------
        slopes
            Shape (T + 1, S, own columns).
        share
            Shape (T, S).
        """
        structure = self.structure
        shared = structure.size - len(structure.sensed)
        late = share[..., None].astype(np.float32)
        between = slopes[:-1] + late * (slopes[1:] - slopes[:-1])
        made = np.zeros((*share.shape, structure.size + self.own))
        made[..., :shared] = between[..., :shared]
        made[..., structure.size :] = between[..., shared:]
        for s, column in enumerate(structure.offsets.tolist()):
            made[:, s, column] = 1.0
        return made

    def assembled(self, normal: Normal, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Normal equations of all parameters with priors.

        Returns
        -------
        matrix, right
            Shapes (P, P) and (P,); the step solves matrix * step = right.
        """
        matrix, right = np.zeros((self.size, self.size)), np.zeros(self.size)
        for r in range(self.runs):
            at = self.columns(r)
            matrix[np.ix_(at, at)] += normal.matrix[r]
            right[at] += normal.vector[r]
        matrix += self.prior.precision
        right -= self.prior.precision @ (vector - self.prior.mean)
        return matrix, right

    def penalty(self, vector: FloatArray) -> float:
        """Give the prior's part of the cost."""
        off = vector - self.prior.mean
        return float(off @ self.prior.precision @ off)

    def weighed(self, weight: FloatArray) -> Problem:
        """Give the same problem with other weights of the readings."""
        return replace(self, inputs=replace(self.inputs, weight=weight))
