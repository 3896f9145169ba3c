"""Which PWM pushes the error furthest, if all rounding were its mean: optimal control by successive approximations.

For a sequence of PWM the costate says what a disturbance at any time adds to the error at the end.  Every block of
samples takes the PWM that moves the state furthest along it, in as many blocks as improves the end (Krylov and
Chernousko); then the costate is taken anew.  The end of that is a local optimum, so many sequences go at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.attack.functional import Functional

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Shares of the blocks, by how much they promise, that take their better PWM at once.
_SHARES = (1.0, 0.6, 0.35, 0.2, 0.1, 0.05, 0.02, 0.0)


@dataclass
class Plan:
    """Sequences of modes, block by block, for L lanes.

    Attributes
    ----------
    modes
        Shape (L, blocks).
    sign
        Whether the error is pushed up (1) or down (-1), shape (L,).
    rise
        Start in K, shape (L,).
    states, costates
        W and the costate at each block's end, shape (blocks + 1, L, 2 n + 1).
    gain
        The error at the end times the sign, in K, shape (L,).
    """

    modes: Integers
    sign: Array
    rise: Array
    states: Array
    costates: Array
    gain: Array


class Sweep:
    """Plans for one functional over a number of blocks.

    Parameters
    ----------
    functional
        The error's linear system.
    block
        Samples in a block.
    blocks
        Their number.
    ends
        Lowest and highest start in K.
    """

    def __init__(self, functional: Functional, block: int, blocks: int, ends: tuple[float, float]) -> None:
        self._functional = functional
        self._blocks = blocks
        self._ends = ends
        self.steps = np.linalg.matrix_power(functional.steps, block)
        self._flat = np.ascontiguousarray(self.steps.transpose(1, 0, 2).reshape(self.steps.shape[1], -1))

    def plans(self, lanes: int, rounds: int, rng: np.random.Generator) -> Plan:
        """Improve random sequences until no block has a better PWM; lanes push up and down in turn."""
        count = len(self.steps)
        runs = rng.integers(1, max(2, self._blocks // 2), lanes)
        modes = np.stack(
            [np.repeat(rng.integers(0, count, self._blocks // run + 1), run)[: self._blocks] for run in runs]
        )
        sign = np.where(np.arange(lanes) % 2, -1.0, 1.0)
        rise = rng.choice([*self._ends, 0.0], lanes)
        plan = self._evaluated(modes, sign, rise)
        for _ in range(rounds):
            better = self._improved(plan)
            if not np.any(better.gain > plan.gain * (1.0 + 1e-6)):
                return better
            plan = better
        return plan

    def candidates(self, plan: Plan, count: int) -> Integers:
        """The most promising rows of each block and lane, the best first, shape (blocks, L, count)."""
        worth = self._worth(plan)
        rows = self._functional.row
        held = worth.shape[2] // (1 + (len(rows) > int(rows.max()) + 1))
        folded = worth.reshape(*worth.shape[:2], -1, held).max(axis=2)
        count = min(count, held)
        best = np.argpartition(-folded, count - 1, axis=2)[:, :, :count]
        order = np.argsort(-np.take_along_axis(folded, best, axis=2), axis=2)
        found: Integers = np.take_along_axis(best, order, axis=2)
        return found

    def _improved(self, plan: Plan) -> Plan:
        worth = self._worth(plan)  # (blocks, L, modes)
        best = worth.argmax(axis=2).T
        lanes = np.arange(len(best))
        promise = (worth.max(axis=2) - np.take_along_axis(worth, plan.modes.T[:, :, None], axis=2)[:, :, 0]).T
        slope = plan.costates[0][:, 0]
        rise = np.where(np.abs(slope) > 0.0, np.where(slope > 0.0, self._ends[1], self._ends[0]), plan.rise)
        order = np.argsort(np.argsort(-promise, axis=1), axis=1)
        trials = [np.where(order < np.ceil(share * self._blocks), best, plan.modes) for share in _SHARES]
        options = [(modes, start) for modes in trials for start in (plan.rise, rise)]
        modes = np.concatenate([m for m, _ in options])
        starts = np.concatenate([s for _, s in options])
        ended = self._ended(modes, np.tile(plan.sign, len(options)), starts).reshape(len(options), -1)
        choice = ended.argmax(axis=0)
        picked = choice * len(best) + lanes
        return self._evaluated(modes[picked], plan.sign, starts[picked])

    def _worth(self, plan: Plan) -> Array:
        """What each mode in each block would make of the end, shape (blocks, L, modes)."""
        blocks, lanes, size = plan.costates[1:].shape
        pushed = (plan.costates[1:].reshape(-1, size) @ self._flat).reshape(blocks, lanes, -1, size)
        worth: Array = (pushed @ plan.states[:-1][:, :, :, None])[..., 0]
        return worth

    def _ended(self, modes: Integers, sign: Array, rise: Array) -> Array:
        w = self._functional.start(rise)
        for block in range(self._blocks):
            w = (self.steps[modes[:, block]] @ w[:, :, None])[:, :, 0]
        gain: Array = sign * np.einsum("li,li->l", self._functional.output[modes[:, -1]], w)
        return gain

    def _evaluated(self, modes: Integers, sign: Array, rise: Array) -> Plan:
        states = [self._functional.start(rise)]
        for block in range(self._blocks):
            states.append((self.steps[modes[:, block]] @ states[-1][:, :, None])[:, :, 0])
        end = sign[:, None] * self._functional.output[modes[:, -1]]
        costates = [end]
        for block in reversed(range(self._blocks)):
            costates.append((costates[-1][:, None, :] @ self.steps[modes[:, block]])[:, 0, :])
        gain = np.einsum("li,li->l", end, states[-1])
        return Plan(modes, sign, rise, np.array(states), np.array(costates[::-1]), gain)
