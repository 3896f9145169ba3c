"""The error as a linear system that PWM switches: what the search looks ahead with.

With y the board's state as a copy of the true state z, and e = y - z, one sample at a row p does

    z' = E(p) (z - s) + s,        e' = E(p) e + D(p) (z - s) + b(p) + (what rounding adds at random),

D being what coefficients and form do wrong, b the mean of all roundings.  D and b are measured, not derived: the
board's own words are stepped once from many states of ordinary runs, at each row, and a linear fit says what is
systematic.
Each row appears twice, reached by a change of PWM and held, since a change rounds as well.  A wrong fit costs the
attacker success and never makes a finding false: findings are judged by the exact solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.attack.board import Board, Copy
from benchmarks.attack.exact import ExactComponent

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: From how many states each row is stepped.
_PROBES = 96
#: How many states each lane of the run gives from which they are taken, and how long it holds PWM, in time constants.
_RUN = 150
_HELD = (0.003, 2.0)


@dataclass(frozen=True)
class Functional:
    """The linear system over w = (z - centre, e, 1), in K and K per sample^k.

    Attributes
    ----------
    steps
        w' = steps[mode] w, shape (modes, 2 n + 1, 2 n + 1).
    row
        The domain's row of each mode.
    output
        x1 - T = output[mode] . w after a sample in a mode, shape (modes, 2 n + 1).
    centre
        In K.
    slowest
        The slowest rate over all rows, 1/sample.
    """

    steps: Array
    row: Integers
    output: Array
    centre: float
    slowest: float

    @property
    def order(self) -> int:
        """n."""
        return int(self.steps.shape[1] - 1) // 2

    def start(self, rise: Array) -> Array:
        """W at rest at given rises, shape (lanes, 2 n + 1)."""
        w = np.zeros((len(rise), self.steps.shape[1]))
        w[:, 0] = rise - self.centre
        w[:, -1] = 1.0
        return w


def measured(board: Board, exact: ExactComponent, copy: Copy, rng: np.random.Generator) -> Functional:
    """Measure D and b at every row."""
    n, rows = exact.order, len(exact.steady)
    centre = float(exact.steady.min() + exact.steady.max()) / 2.0
    states = _visited(board, exact, rng)
    probes = states[rng.integers(0, len(states), (rows, _PROBES))]  # (rows, probes, n)
    row = np.repeat(np.arange(rows), _PROBES)
    true = probes.reshape(-1, n)
    both = board.component.order > 1
    steps, outputs = [], []
    for changed in (False, True)[: 1 + both]:
        before = row if not changed else np.clip(row + rng.choice([-1, 1], len(row)), 0, rows - 1)
        words = board.words(copy.board(true, before))
        moved = copy.true(board.values(board.sample(words, row, before)), row)
        held = copy.true(board.values(words), before)  # what the words themselves are a copy of
        away = held.copy()
        away[:, 0] -= exact.steady[row]
        residual = (moved - held) - (exact.growth[row] @ away[:, :, None])[:, :, 0]
        disturbance, constant = _fitted(residual.reshape(rows, _PROBES, n), away.reshape(rows, _PROBES, n))
        steps.append(_assembled(exact, disturbance, constant, centre))
        outputs.append(_output(copy, centre))
    slowest = _slowest(exact)
    return Functional(
        np.concatenate(steps), np.tile(np.arange(rows), 1 + both), np.concatenate(outputs), centre, slowest
    )


def _slowest(exact: ExactComponent) -> float:
    """The slowest pole over all rows, 1/sample, nearly: eigenvalues of exp(A Ts) - I in balanced coordinates."""
    rate = np.abs(np.linalg.det(exact.growth)) ** (1.0 / exact.order)  # geometric mean
    scale = rate[:, None] ** np.arange(exact.order)
    balanced = exact.growth * (scale[:, None, :] / scale[:, :, None])
    return float(np.abs(np.linalg.eigvals(balanced).real).min())


def _visited(board: Board, exact: ExactComponent, rng: np.random.Generator) -> Array:
    """True states that runs with steps and pauses of all lengths come by, shape (states, n)."""
    lanes, n = 24, exact.order
    low, high = (end / 1000.0 for end in board.component.start_range_mK)
    z = np.zeros((lanes, n))
    z[:, 0] = rng.choice([low, high, 0.0, float(exact.steady.max())], lanes)
    held = np.exp(rng.uniform(np.log(_HELD[0]), np.log(_HELD[1]), lanes)) / _slowest(exact)
    found = []
    row = rng.integers(0, len(exact.steady), lanes)
    stride = np.maximum(1, (held / 10.0).astype(np.int64))
    powers = _powers(exact, int(stride.max()).bit_length())
    for _ in range(_RUN):
        new = rng.random(lanes) < 0.1
        row = np.where(new, rng.integers(0, len(exact.steady), lanes), row)
        for bit, power in enumerate(powers):
            act = (stride >> bit & 1).astype(bool)
            away = z[act]
            steady = exact.steady[row[act]]
            away[:, 0] -= steady
            away = (power[row[act]] @ away[:, :, None])[:, :, 0]
            away[:, 0] += steady
            z[act] = away
        found.append(z.copy())
    return np.concatenate(found)


def _powers(exact: ExactComponent, count: int) -> list[Array]:
    """exp(A Ts 2^k) for k below ``count``."""
    powers = [exact.growth + np.eye(exact.order)]
    for _ in range(1, count):
        powers.append(powers[-1] @ powers[-1])
    return powers


def _fitted(residual: Array, away: Array) -> tuple[Array, Array]:
    """D and b at each row by least squares, in coordinates scaled to their own sizes."""
    size = np.maximum(np.abs(away).max(axis=(0, 1)), 1e-300)
    ones = np.ones((*away.shape[:2], 1))
    design = np.concatenate([away / size, ones], axis=2)
    normal = np.einsum("rki,rkj->rij", design, design)
    normal += 1e-9 * len(design[0]) * np.eye(normal.shape[1])  # directions that no run takes
    right = np.einsum("rki,rkj->rij", design, residual)
    solved = np.linalg.solve(normal, right)  # (rows, n + 1, n)
    return np.transpose(solved[:, :-1] / size[:, None], (0, 2, 1)), solved[:, -1]


def _assembled(exact: ExactComponent, disturbance: Array, constant: Array, centre: float) -> Array:
    n, rows = exact.order, len(exact.steady)
    steps = np.zeros((rows, 2 * n + 1, 2 * n + 1))
    off = centre - exact.steady
    transition = exact.growth + np.eye(n)
    steps[:, :n, :n] = transition
    steps[:, :n, -1] = exact.growth[:, :, 0] * off[:, None]
    steps[:, n:-1, :n] = disturbance
    steps[:, n:-1, n:-1] = transition
    steps[:, n:-1, -1] = constant + disturbance[:, :, 0] * off[:, None]
    steps[:, -1, -1] = 1.0
    return steps


def _output(copy: Copy, centre: float) -> Array:
    """x1 - T: the first row of M (y - s) + s - z, with y = z + e."""
    rows, n, _ = copy.maps.shape
    output = np.zeros((rows, 2 * n + 1))
    beyond = copy.maps[:, 0, :] - np.eye(n)[0]
    output[:, :n] = beyond
    output[:, n:-1] = copy.maps[:, 0, :]
    output[:, -1] = beyond[:, 0] * (centre - copy.steady)
    return output
