"""Fitting hypotheses to the residual by simulation error, all folds and components of a problem at once.

Levenberg-Marquardt with numeric derivatives; each fold's fit and each derivative is one more lane of one simulation.
A constant offset within the sensor's tolerance is fitted beside every hypothesis, the empty one included, so that
no effect is bought with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.model.effects import Effect, Free, Variant
from gen.model.effects.integrate import Slot, readings
from gen.refinement.parts.stacked_runs import StackedRuns

_ITERATIONS = 14
_STEP = 1e-4
_ABSURD_K = 1e4
_HOPELESS = 0.985
"""After a few steps a hypothesis that has not lowered any component's squared error below this share is given up."""


@dataclass(frozen=True)
class Term:
    """One effect of a hypothesis, and where its fit starts."""

    effect: Effect
    variant: Variant
    start: tuple[float, ...]


@dataclass(frozen=True)
class HypothesisFit:
    """A hypothesis fitted to C components; F folds.

    Parameters
    ----------
    terms
        The hypothesis.
    numbers
        Free parameters in order, fitted to all runs, shape (C, n).
    spread
        Their standard errors in the fit's own scale (relative for logarithmic ones), shape (C, n).
    folds
        Free parameters of each fold's fit, in the fit's own scale, shape (C, F, n).
    offset
        The tolerated sensor offset, K, shape (C,).
    error
        Residual left on all runs, K, shape (K, C, R).
    left_out
        Residual left in each bin by the fit that did not see it, K, shape (K, C, R).
    loss
        Mean of left_out squared, K^2, shape (C,).
    """

    terms: tuple[Term, ...]
    numbers: FloatArray
    spread: FloatArray
    folds: FloatArray
    offset: FloatArray
    error: FloatArray
    left_out: FloatArray
    loss: FloatArray

    @property
    def free(self) -> tuple[Free, ...]:
        """All free parameters, in order."""
        return tuple(free for term in self.terms for free in term.variant.free)

    def first_free(self, at: int) -> int:
        """Give the place of a term's first free parameter among all of them."""
        return sum(len(term.variant.free) for term in self.terms[:at])

    def size(self, at: int) -> int | None:
        """Give the place of the number that says how large a term is among all of them, None for a term without."""
        place = self.terms[at].variant.size
        return None if place is None else self.first_free(at) + place

    def values(self, component: int) -> list[dict[str, object]]:
        """Parameters of each term for a component."""
        made, at = [], 0
        for term in self.terms:
            count = len(term.variant.free)
            made.append(term.variant.values([float(x) for x in self.numbers[component, at : at + count]]))
            at += count
        return made


def fit(problem: StackedRuns, terms: Sequence[Term]) -> HypothesisFit:
    """Fit a hypothesis.

    Parameters
    ----------
    problem
        Residuals and drive.
    terms
        The effects; none is the empty hypothesis.
    """
    free = [f for term in terms for f in term.variant.free]
    start = [x for term in terms for x in term.start]
    lanes = 1 + problem.left_out.shape[0]
    count = len(problem.components)
    low = np.array([_to(f, f.low) for f in free])
    high = np.array([_to(f, f.high) for f in free])
    tolerance = 0.0 if any(term.effect.tolerance_K is not None for term in terms) else problem.tolerance_K
    scale = np.array([1.0 if f.log else max(abs(s), 1e-9) for f, s in zip(free, start, strict=True)])
    u = np.broadcast_to(np.array([_to(f, s) for f, s in zip(free, start, strict=True)]), (count, lanes, len(free)))
    weights = _weights(problem)
    state = _State(problem, terms, free, weights, tolerance, scale)
    best = state.evaluate(u.copy())
    first = best.loss.copy()
    damping = np.full((count, lanes), 1e-3)
    null = state.null
    for iteration in range(_ITERATIONS if free else 0):
        trial_u = np.clip(state.step(best, damping), low, high)
        moved = np.max(np.abs(trial_u - best.u) / scale, axis=-1)
        trial = state.evaluate(trial_u)
        better = trial.loss < best.loss
        settled = (moved < 1e-3) | (np.abs(trial.loss - best.loss) < 1e-4 * (best.loss + 1e-12))
        best = best.replaced(trial, better)
        damping = np.where(better, damping * 0.2, damping * 8.0)
        if np.all(settled):
            break
        if iteration == 4 and np.all(best.loss[:, 0] > _HOPELESS * np.minimum(null[:, 0], first[:, 0])):
            break
    return _finished(problem, tuple(terms), free, best, state)


def _to(free: Free, value: float) -> float:
    return float(np.log(max(value, 1e-12))) if free.log else value


def _weights(problem: StackedRuns) -> FloatArray:
    """Samples of each bin that a lane is fitted to, shape (C, L, K R); lane 0 sees all."""
    w = problem.weight[:, :, 0, :]
    seen = np.concatenate([np.ones((1, *problem.left_out.shape[1:]), dtype=bool), ~problem.left_out])
    made = w[None] * seen[:, :, None, :]  # (L, K, C, R)
    return np.ascontiguousarray(np.moveaxis(made, 2, 0)).reshape(w.shape[1], seen.shape[0], -1)


@dataclass
class _Point:
    u: FloatArray  # (C, L, n)
    offset: FloatArray  # (C, L)
    loss: FloatArray  # (C, L)
    residual: FloatArray  # (C, L, K R)
    slopes: FloatArray  # (C, L, n, K R)

    def replaced(self, other: _Point, where: np.ndarray) -> _Point:
        def pick(new: FloatArray, old: FloatArray) -> FloatArray:
            return np.where(where.reshape(where.shape + (1,) * (new.ndim - 2)), new, old)

        return _Point(
            pick(other.u, self.u),
            pick(other.offset, self.offset),
            pick(other.loss, self.loss),
            pick(other.residual, self.residual),
            pick(other.slopes, self.slopes),
        )


class _State:
    def __init__(
        self,
        problem: StackedRuns,
        terms: Sequence[Term],
        free: Sequence[Free],
        weights: FloatArray,
        tolerance: float,
        scale: FloatArray,
    ) -> None:
        self.problem, self.terms, self.free = problem, terms, free
        self.weights, self.tolerance, self.scale = weights, tolerance, scale
        track = problem.track
        base = track.base + track.ambient
        self.base = base
        fade = 0.5 * (track.fading[1:] + track.fading[:-1])
        self.column = _flat(1.0 - fade, problem)  # (C, 1, K R)
        self.residual = _flat(problem.residual, problem)
        self.null = self._loss(np.broadcast_to(self.residual, weights.shape))[1]

    def evaluate(self, u: FloatArray) -> _Point:
        count, lanes, n = u.shape
        steps = _STEP * self.scale
        grid = np.repeat(u[:, :, None, :], n + 1, axis=2)
        for i in range(n):
            grid[:, :, i + 1, i] += steps[i]
        numbers = grid.reshape(count, lanes * (n + 1), n)
        slots: list[Slot] = []
        at = 0
        for term in self.terms:
            width = len(term.variant.free)
            columns = [
                (np.exp(numbers[:, :, at + i]) if f.log else numbers[:, :, at + i])[:, :, None]
                for i, f in enumerate(term.variant.free)
            ]
            slots.append((term.effect, term.variant.values(columns)))
            at += width
        predicted = self.predict(slots)
        if predicted.shape[1] == 1 and lanes * (n + 1) > 1:
            predicted = np.broadcast_to(predicted, (predicted.shape[0], lanes * (n + 1), predicted.shape[2]))
        predicted = predicted.reshape(count, lanes, n + 1, -1)
        residual = self.residual - predicted[:, :, 0]
        offset, loss = self._loss(residual)
        slopes = (predicted[:, :, 1:] - predicted[:, :, :1]) / steps[:, None]
        return _Point(u, offset, loss, residual - offset[:, :, None] * self.column, slopes)

    def predict(self, slots: Sequence[Slot]) -> FloatArray:
        """Change of the reading, K, shape (C, lanes, K R)."""
        if not slots:
            return np.zeros((len(self.problem.components), 1, self.residual.shape[-1]))
        # A trial step may make a part heat itself without limit: no failure, only a bad fit.
        with np.errstate(over="ignore", invalid="ignore"):
            change = readings(slots, self.problem.track)[1] - self.base
            change = np.clip(np.nan_to_num(change, nan=_ABSURD_K), -_ABSURD_K, _ABSURD_K)
        return _flat(0.5 * (change[1:] + change[:-1]), self.problem)

    def _loss(self, residual: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Best tolerated offset, and the weighted mean square that it leaves."""
        w = self.weights
        wc = w * self.column
        offset = np.sum(wc * residual, axis=-1) / np.maximum(np.sum(wc * self.column, axis=-1), 1e-9)
        offset = np.clip(offset, -self.tolerance, self.tolerance)
        left = residual - offset[..., None] * self.column
        return offset, np.sum(w * left * left, axis=-1) / np.maximum(np.sum(w, axis=-1), 1e-9)

    def normal(self, point: _Point) -> tuple[FloatArray, FloatArray]:
        """J'WJ and J'Wr with the offset as the last parameter where it is inside its tolerance."""
        n = point.u.shape[-1]
        w = self.weights
        if self.tolerance > 0.0:
            inside = (np.abs(point.offset) < self.tolerance).astype(float)[:, :, None, None]
            column = np.broadcast_to(self.column[:, :, None, :], (*w.shape[:2], 1, w.shape[-1])) * inside
            jacobian = np.concatenate([point.slopes, column], axis=2)
        else:
            jacobian = point.slopes
        weighted = jacobian * w[:, :, None, :]
        a = weighted @ np.swapaxes(jacobian, -1, -2)
        g = (weighted @ point.residual[..., None])[..., 0]
        size = a.shape[-1]
        if size > n:
            a[..., n, n] += 1e-9 + (a[..., n, n] == 0.0)
        return a, g

    def step(self, point: _Point, damping: FloatArray) -> FloatArray:
        a, g = self.normal(point)
        n = point.u.shape[-1]
        diagonal = np.einsum("...ii->...i", a)
        floor = 1e-12 * np.max(diagonal, axis=-1, keepdims=True) + 1e-30
        a = a + np.eye(a.shape[-1]) * ((damping[..., None] + 1e-10) * diagonal + floor)[..., None, :]
        return point.u + np.linalg.solve(a, g[..., None])[..., :n, 0]


def _flat(array: FloatArray, problem: StackedRuns) -> FloatArray:
    """(K, C, lanes, R) -> (C, lanes, K R)."""
    full = np.broadcast_to(array, (array.shape[0], len(problem.components), array.shape[2], problem.residual.shape[-1]))
    return np.ascontiguousarray(np.moveaxis(full, 0, 2)).reshape(full.shape[1], full.shape[2], -1)


def _finished(
    problem: StackedRuns,
    terms: tuple[Term, ...],
    free: Sequence[Free],
    best: _Point,
    state: _State,
) -> HypothesisFit:
    bins, count, _, runs = problem.residual.shape
    residual = best.residual.reshape(count, best.residual.shape[1], bins, runs)
    left_out = residual[:, 0].copy()
    for f, mask in enumerate(problem.left_out):
        left_out[:, mask] = residual[:, f + 1][:, mask]
    w = np.moveaxis(problem.weight[:, :, 0, :], 1, 0)
    loss = np.sum(w * left_out**2, axis=(1, 2)) / np.maximum(np.sum(w, axis=(1, 2)), 1e-9)
    numbers = best.u[:, 0].copy()
    spread = np.full(numbers.shape, np.inf)
    if free:
        spread = _spread(state, best, residual[:, 0], w)
    for i, parameter in enumerate(free):
        if parameter.log:
            numbers[:, i] = np.exp(numbers[:, i])
    return HypothesisFit(
        terms=terms,
        numbers=numbers,
        spread=spread,
        folds=best.u[:, 1:].copy(),
        offset=best.offset[:, 0],
        error=np.moveaxis(residual[:, 0], 0, 1),
        left_out=np.moveaxis(left_out, 0, 1),
        loss=loss,
    )


def _spread(state: _State, best: _Point, residual: FloatArray, w: FloatArray) -> FloatArray:
    """Standard errors for residuals that are correlated from bin to bin (first-order), shape (C, n)."""
    a, _ = state.normal(best)
    a = a[:, 0]
    n = best.u.shape[-1]
    both = (w[:, 1:] > 0) & (w[:, :-1] > 0)
    power = np.sum(np.where(w > 0, residual**2, 0.0), axis=(1, 2)) + 1e-30
    next_to = np.sum(np.where(both, residual[:, 1:] * residual[:, :-1], 0.0), axis=(1, 2))
    rho = np.clip(next_to / power, 0.0, 0.98)
    used = np.maximum(np.sum(w > 0, axis=(1, 2)), 2)
    # Each bin counts once: its samples share one error of the model, and the weights only say how many rows it had.
    mean_weight = np.sum(w, axis=(1, 2)) / used
    variance = power / np.maximum(used - n, 1) * (1.0 + rho) / (1.0 - rho)
    size = np.sqrt(np.maximum(np.einsum("cii->ci", a), 1e-300))
    inverse = np.linalg.pinv(a / (size[:, :, None] * size[:, None, :]), rcond=1e-10, hermitian=True)
    diagonal = np.maximum(np.einsum("cii->ci", inverse) / size**2 * mean_weight[:, None], 0.0)[:, :n]
    scaled = np.asarray(np.sqrt(diagonal * variance[:, None]))
    return np.where(np.einsum("cii->ci", a)[:, :n] > 0.0, scaled, np.inf)
