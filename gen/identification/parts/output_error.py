"""Output-error fit of one component: transfer functions at the identified speeds, all runs at once.

At each node (an identified speed) the structure's parameters and the steady rise are free; between nodes they are
interpolated linearly over |PWM|, with no rise at PWM 0. Runs of one held speed are then fits of their own; staircases,
coolings and ramps are handled by the same equations. The initial state of each run is estimated too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from gen.arrays import FloatArray, IntArray
from gen.errors import InputError
from gen.identification.logs.records import Record, levels_of
from gen.identification.parts.response import mixed_poles, simulate
from gen.identification.parts.structure import PoleArray, Structure

_STEP = 1e-5
"""Difference quotient's step in a logarithm; the second order it neglects is 1e-5 of the derivative."""
SPREAD = 1.5
"""Prior standard deviation of a logarithm about its mean over speed: a factor of 4.5. It only matters where the
data say nothing."""
OFFSET_PRIOR = 1.1
"""Prior standard deviation of a sensor's offset, K: the tolerance of a type K thermocouple with its amplifier."""

LARGEST_ZETA = 4.0
"""A pair with more damping is two real poles a factor of 60 apart: no pair."""

SLOWEST = 100.0
"""Longest time constant that is looked for, over the longest run."""


class Simulator:
    """Simulates one record for many parameter sets given by |PWM| level.

    Parameters
    ----------
    record
        What was measured.
    levels
        All |PWM| levels, increasing.
    raw
        At the samples instead of the blocks.
    """

    def __init__(self, record: Record, levels: IntArray, *, raw: bool = False) -> None:
        self.record = record
        self.since, self.piece = record.since(raw=raw)
        self._over = record.raw_over if raw else record.over
        segments = record.segments
        self._level = np.searchsorted(levels, np.maximum(segments.pwm, 0))
        self._mixed = {}
        for j, shares in segments.mixed.items():
            share = np.zeros(len(levels))
            share[np.searchsorted(levels, list(shares))] = list(shares.values())
            self._mixed[j] = share
        used = {int(self._level[j]) for j in range(len(segments.start)) if segments.pwm[j] >= 0}
        used |= {int(i) for share in self._mixed.values() for i in np.flatnonzero(share)}
        self.used = np.array(sorted(used), dtype=np.int64)

    def __call__(self, poles: PoleArray, steady: FloatArray, start: FloatArray) -> FloatArray:
        """Simulate.

        Parameters
        ----------
        poles
            Shape (B, L, n), rad/s.
        steady
            Steady rise by level, shape (B, L), K.
        start
            Rise and derivatives at the beginning, shape (B, n), K/s^k.

        Returns
        -------
        array
            Rise over the ambient, whose changes pass the dynamics, shape (B, M), K.
        """
        p: PoleArray = poles[:, self._level]
        s = steady[:, self._level].copy()
        if self._mixed:
            p = p.astype(np.complex128)
            places, share = list(self._mixed), np.array(list(self._mixed.values()))
            every = np.asarray(poles, dtype=np.complex128)
            p[:, places] = mixed_poles(every, share)
            last = np.abs(np.prod(every, axis=2))
            s[:, places] = (last * steady) @ share.T / (last @ share.T)
        pieces = self.record.pieces
        of = pieces.segment
        temperature = simulate(p[:, of], s[:, of] + pieces.over, start, pieces.length, self.piece, self.since)
        return temperature - self._over


@dataclass(frozen=True)
class Layout:
    """Where each parameter lies in the vector.

    Attributes
    ----------
    structure
        Of the transfer functions.
    nodes
        Identified |PWM|, increasing; PWM 0 may be among them (cooling).
    warm
        For each record how many initial values are estimated: 1 (the rise) or the order.
    offset
        Whether a constant error of the sensor is estimated.
    """

    structure: Structure
    nodes: IntArray
    warm: tuple[int, ...]
    offset: bool = False

    @property
    def order(self) -> int:
        """Number of poles."""
        return self.structure.order

    @cached_property
    def positive(self) -> IntArray:
        """The nodes that have a gain."""
        return self.nodes[self.nodes > 0]

    @property
    def thetas(self) -> int:
        """Number of structure parameters."""
        return len(self.nodes) * self.order

    @property
    def size(self) -> int:
        """Length of the vector."""
        return self.thetas + len(self.positive) + sum(self.warm) + self.offset

    def theta(self, vector: FloatArray) -> FloatArray:
        """Structure parameters, shape (..., nodes, order)."""
        return vector[..., : self.thetas].reshape(*vector.shape[:-1], len(self.nodes), self.order)

    def steady(self, vector: FloatArray) -> FloatArray:
        """Steady rise at the positive nodes, shape (..., nodes), K."""
        return vector[..., self.thetas : self.thetas + len(self.positive)]

    def start_slice(self, record: int) -> slice:
        """Where a record's initial values lie."""
        first = self.thetas + len(self.positive) + sum(self.warm[:record])
        return slice(first, first + self.warm[record])


def interpolation(nodes: IntArray, levels: IntArray) -> FloatArray:
    """Give the weights of linear interpolation, held outside, shape (levels, nodes)."""
    eye = np.eye(len(nodes))
    return np.stack([np.interp(levels, nodes, row) for row in eye], axis=1)


def rise_interpolation(positive: IntArray, levels: IntArray) -> FloatArray:
    """Give the same for the steady rise: zero at PWM 0, proportional to PWM beyond the last node."""
    anchored = np.append(0, positive)
    weights = interpolation(anchored, levels)[:, 1:]
    beyond = levels > positive[-1]
    weights[beyond] = 0.0
    weights[beyond, -1] = levels[beyond] / positive[-1]
    return weights


@dataclass(frozen=True, eq=False)
class OutputErrorFit:
    """A fitted layout.

    Attributes
    ----------
    layout
        The parameters' meaning.
    vector
        Their values.
    jacobian
        Of the weighted residuals, rows of all records after each other, shape (M, P).
    residuals
        Measured minus model by record, K.
    cost
        Weighted sum of squares (no prior).
    """

    layout: Layout
    vector: FloatArray
    jacobian: FloatArray
    residuals: tuple[FloatArray, ...]
    cost: float

    @property
    def theta(self) -> FloatArray:
        """Structure parameters at the nodes, shape (nodes, order)."""
        return self.layout.theta(self.vector)

    @property
    def steady(self) -> FloatArray:
        """Steady rise at the positive nodes, K."""
        return self.layout.steady(self.vector)

    @property
    def offset(self) -> float:
        """The sensor's estimated constant error, K."""
        return float(self.vector[-1]) if self.layout.offset else 0.0


class OutputErrorProblem:
    """The records of one component and what a fit of them needs.

    Parameters
    ----------
    records
        One per run.
    nodes
        Identified |PWM|.
    fastest
        Shortest time constant that is looked for, s.
    """

    def __init__(self, records: Sequence[Record], nodes: IntArray, fastest: float = 0.0) -> None:
        self.records = tuple(records)
        self.fastest = max(fastest, 2.0 * min(record.sample_s for record in records))
        longest = max(record.duration for record in records)
        if SLOWEST * longest <= 2.0 * LARGEST_ZETA * self.fastest:
            raise InputError(
                f"{records[0].run}: the longest run takes {longest:.3g} s, and no time constant below "
                f"{self.fastest:.3g} s is looked for: log longer, or give a shorter --sample-time"
            )
        self.nodes = nodes
        self.levels = levels_of(records)
        self.simulators = [Simulator(record, self.levels) for record in records]
        self.weights = [np.sqrt(record.weight) for record in records]
        self._theta_weights = interpolation(nodes, self.levels)
        positive = nodes[nodes > 0]
        self._steady_weights = rise_interpolation(positive, self.levels)
        self.rows = np.cumsum([0, *(len(record.time) for record in records)])

    def layout(self, structure: Structure, *, offset: bool = False) -> Layout:
        """Give the layout of a structure for these records."""
        warm = tuple(structure.order if is_warm(record) else 1 for record in self.records)
        return Layout(structure, self.nodes, warm, offset)

    def by_level(self, layout: Layout, vectors: FloatArray) -> tuple[PoleArray, FloatArray]:
        """Poles (B, L, n) and steady rise (B, L) of a batch of vectors, shape (B, P)."""
        theta = np.einsum("ln,bnk->blk", self._theta_weights, layout.theta(vectors))
        steady = layout.steady(vectors) @ self._steady_weights.T
        return layout.structure.poles(theta), steady

    def _relevant(self, layout: Layout, r: int) -> IntArray:
        """Which parameters the record depends on."""
        used = self.simulators[r].used
        nodes = np.flatnonzero(self._theta_weights[used].any(axis=0))
        thetas = (nodes[:, None] * layout.order + np.arange(layout.order)).ravel()
        gains = layout.thetas + np.flatnonzero(self._steady_weights[used].any(axis=0))
        start = np.arange(layout.size)[layout.start_slice(r)]
        extra = [layout.size - 1] if layout.offset else []
        return np.concatenate([thetas, gains, start, np.array(extra, dtype=np.int64)]).astype(np.int64)

    def start_state(self, layout: Layout, vectors: FloatArray, r: int) -> FloatArray:
        """Initial rise and derivatives of a record, shape (B, n); the vector holds T, T' tau, T'' tau^2 .."""
        state = np.zeros((len(vectors), layout.order))
        values = vectors[:, layout.start_slice(r)]
        scale = (self.records[r].duration / 10.0) ** np.arange(values.shape[1])
        state[:, : values.shape[1]] = values / scale
        return state

    def model(self, layout: Layout, vectors: FloatArray, r: int) -> FloatArray:
        """Simulated rise of record r, with the sensor's offset, shape (B, m)."""
        poles, steady = self.by_level(layout, vectors)
        result = self.simulators[r](poles, steady, self.start_state(layout, vectors, r))
        return result + vectors[:, -1:] if layout.offset else result

    def evaluate(self, layout: Layout, vector: FloatArray) -> tuple[list[FloatArray], FloatArray]:
        """Residuals by record (K) and the weighted Jacobian of the residuals, shape (M, P)."""
        jacobian = np.zeros((int(self.rows[-1]), layout.size))
        residuals = []
        for r, record in enumerate(self.records):
            which = self._relevant(layout, r)
            batch = np.repeat(vector[None, :], len(which) + 1, axis=0)
            step = np.where(which < layout.thetas, _STEP, 1e-3)
            batch[np.arange(len(which)) + 1, which] += step
            simulated = self.model(layout, batch, r)
            rows = slice(int(self.rows[r]), int(self.rows[r + 1]))
            jacobian[rows, which] = -((simulated[1:] - simulated[0]) / step[:, None]).T * self.weights[r][:, None]
            residuals.append(record.rise - simulated[0])
        return residuals, jacobian

    def fit(self, layout: Layout, start: FloatArray, mask: FloatArray | None = None, most: int = 40) -> OutputErrorFit:
        """Minimise the weighted sum of squares from a start.

        Parameters
        ----------
        layout, start
            What is fitted, and from where.
        mask
            1 for rows that count, 0 for those left out, shape (M,).
        most
            Largest number of steps.
        """
        selected = np.ones(int(self.rows[-1])) if mask is None else mask
        prior = _Prior(layout)
        last: dict[str, Any] = {}

        def both(vector: FloatArray) -> tuple[FloatArray, FloatArray]:
            if last.get("key") != vector.tobytes():
                residuals, jacobian = self.evaluate(layout, vector)
                weighted = np.concatenate([w * e for w, e in zip(self.weights, residuals, strict=True)])
                last["value"] = (
                    np.concatenate([weighted * selected, prior.residual(vector)]),
                    np.concatenate([jacobian * selected[:, None], prior.jacobian]),
                )
                last["key"] = vector.tobytes()
            return last["value"]  # type: ignore[no-any-return]

        def value(vector: FloatArray) -> FloatArray:
            return both(vector)[0]

        def slope(vector: FloatArray) -> FloatArray:
            return both(vector)[1]

        longest = max(record.duration for record in self.records)
        low = np.full(layout.size, -np.inf)
        high = np.full(layout.size, np.inf)
        low[: layout.thetas], high[: layout.thetas] = np.log(self.fastest), np.log(SLOWEST * longest)
        if layout.structure.pair:
            # The pair's faster pole is up to 2 zeta omega.
            omega, zeta = np.arange(layout.thetas).reshape(-1, layout.order)[:, -2:].T
            low[omega] = np.log(self.fastest * 2.0 * LARGEST_ZETA)
            low[zeta], high[zeta] = np.log(0.02), np.log(LARGEST_ZETA)
        start = np.clip(start, low + 1e-6, high - 1e-6)
        found = least_squares(
            value,
            start,
            jac=slope,
            bounds=(low, high),
            x_scale="jac",
            ftol=1e-7,
            xtol=1e-6,
            gtol=1e-10,
            max_nfev=most,
        )
        vector = np.asarray(found.x, dtype=np.float64)
        residuals, jacobian = self.evaluate(layout, vector)
        cost = sum(float(np.sum((w * e) ** 2)) for w, e in zip(self.weights, residuals, strict=True))
        return OutputErrorFit(layout, vector, jacobian, tuple(residuals), cost)


class _Prior:
    """Weak prior residuals: logarithms about their mean over speed, and the sensor's offset about zero."""

    def __init__(self, layout: Layout) -> None:
        n, k = len(layout.nodes), layout.order
        centre = (np.eye(n) - 1.0 / n) / SPREAD
        rows = np.zeros((n * k + layout.offset, layout.size))
        for j in range(k):
            rows[j * n : (j + 1) * n, j : layout.thetas : k] = centre
        if layout.offset:
            rows[-1, -1] = 1.0 / OFFSET_PRIOR
        self.jacobian = rows

    def residual(self, vector: FloatArray) -> FloatArray:
        return np.asarray(self.jacobian @ vector, dtype=np.float64)


def is_warm(record: Record) -> bool:
    """Whether the run starts so far from ambient that its initial derivatives matter too."""
    first = record.rise[: min(3, len(record.rise))]
    moved = float(np.ptp(record.rise))
    return bool(abs(float(np.mean(first))) > max(3.0, 0.1 * moved))
