"""The exact solution of the model's differential equations by matrix exponential, in float64.

It judges everything else in kelvin and so shares no code with the lowering or the reference simulators.

Two things keep its own error far below 1e-9 K over hours at 0.25 s. The state is (T, tau T', tau^2 T'', ...),
with one tau per component (its state is continuous when PWM changes, so tau must not depend on PWM): the
entries are of one magnitude. And a step adds ``(exp(M h) - 1) x`` instead of multiplying by ``exp(M h)``,
which is 1 up to 1e-4: the increment carries its own relative precision.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.model.dynamics import MAX_PWM, PWM_LEVELS, Component, ThermalModel

_CHUNK = 1 << 15
"""Matrices exponentiated at once, to bound the memory of long irregular runs."""


@dataclass(frozen=True)
class _Steps:
    """Step matrices of one component: x += increment[i] x + forced[i]."""

    increment: FloatArray  # (n, order, order)
    forced: FloatArray  # (n, order)


class ExactSolution:
    """Exact rises of all components of a model for an input that is held over each interval.

    Parameters
    ----------
    model
        The model; it may be simulated for every |PWM| 0..255.
    """

    def __init__(self, model: ThermalModel) -> None:
        self.model = model
        self._known: list[BoolArray] = [np.zeros(PWM_LEVELS, dtype=np.bool_) for _ in model.components]
        self._table = [
            _Steps(np.zeros((PWM_LEVELS, c.order, c.order)), np.zeros((PWM_LEVELS, c.order))) for c in model.components
        ]
        self._intervals: dict[tuple[str, int, float], _Steps] = {}

    def simulate(
        self,
        pwm_samples: ArrayLike,
        initial_rise: Mapping[str, ArrayLike] | None = None,
        over: FloatArray | None = None,
    ) -> dict[str, FloatArray]:
        """Solve on the grid of the sample time.

        Parameters
        ----------
        pwm_samples
            Integer PWM, -255..255, shape (N,), or (L, N) for L independent lanes.
        initial_rise
            Rise at the start in K by component, a number or shape (L,); 0 where not given.
            Derivatives start at 0.
        over
            The ambient of each sample over the temperature that rises count from, in K, shape as the PWM: it passes the
            components' dynamics, A(d/dt) T = K |PWM| + A(0) over. None: rises count from the ambient itself.

        Returns
        -------
        dict
            Rise in K by component, shape (N + 1,) or (L, N + 1); entry k is at k Ts, before sample k acts.
        """
        counts = magnitude(pwm_samples)
        start = self._start(initial_rise)
        used = np.unique(counts)
        solved: dict[str, FloatArray] = {}
        for position, component in enumerate(self.model.components):
            steps = self._grid_steps(position, used)
            x = np.zeros((*counts.shape[:-1], component.order))
            x[..., 0] = np.asarray(start.get(component.name, 0.0), dtype=np.float64)
            out = np.empty((*counts.shape[:-1], counts.shape[-1] + 1, 1))
            if counts.ndim == 1:
                _run(steps, counts, x, out, over)
            else:
                _run_lanes(steps, counts, x, out, over)
            solved[component.name] = out[..., 0]
        return solved

    def simulate_times(
        self,
        time_s: ArrayLike,
        pwm: ArrayLike,
        initial_rise: Mapping[str, float] | None = None,
        over: FloatArray | None = None,
    ) -> dict[str, FloatArray]:
        """Solve at the irregular times of a run, its PWM held until the next row.

        Parameters
        ----------
        time_s
            Strictly increasing times in s, shape (N,).
        pwm
            Integer PWM, -255..255, shape (N,); the last one has no effect.
        initial_rise
            Rise at the first time in K by component; 0 where not given. Derivatives start at 0.
        over
            As :meth:`simulate`, held until the next row as PWM is, shape (N,).

        Returns
        -------
        dict
            Rise in K by component, shape (N,), at the given times.
        """
        time = np.asarray(time_s, dtype=np.float64)
        counts = magnitude(pwm)
        if time.shape != counts.shape or time.ndim != 1:
            raise ValueError(f"time {time.shape} and pwm {counts.shape} must be vectors of one length")
        step = np.diff(time)
        if np.any(step <= 0.0):
            raise ValueError("time must increase strictly")
        pairs, index = np.unique(np.stack([counts[:-1].astype(np.float64), step]), axis=1, return_inverse=True)
        start = self._start(initial_rise)
        result: dict[str, FloatArray] = {}
        for component in self.model.components:
            tau = _time_scale(component)
            x = np.zeros(component.order)
            x[0] = float(np.asarray(start.get(component.name, 0.0)))
            out = np.empty(time.size)
            if time.size:
                steps = _step_matrices(component, tau, pairs[0].astype(np.int64), pairs[1])
                _run(steps, index.ravel(), x, out[:, None], None if over is None else over[:-1])
            result[component.name] = out
        return result

    def over_ambient(
        self,
        time_s: ArrayLike,
        pwm: ArrayLike,
        ambient: FloatArray,
        initial_rise: Mapping[str, float] | None = None,
    ) -> dict[str, FloatArray]:
        """Solve at a run's own times where the ambient may move.

        Parameters
        ----------
        time_s, pwm
            As :meth:`simulate_times`.
        ambient
            In degC, held until the next row, shape (N,). Its changes pass the components' dynamics, or act at once: as
            the model has it.
        initial_rise
            Rise over the ambient at the first time in K by component; 0 where not given.

        Returns
        -------
        dict
            Rise over the ambient at each of the given times in K by component, shape (N,).
        """
        if not self.model.ambient_passes:
            return self.simulate_times(time_s, pwm, initial_rise)
        over = np.asarray(ambient, dtype=np.float64) - self.model.ambient_reference
        given = initial_rise or {}
        start = {name: float(given.get(name, 0.0) + over[0]) for name in self.model.component_names}
        solved = self.simulate_times(time_s, pwm, start, over)
        return {name: rise - over for name, rise in solved.items()}

    def begin(self, initial_rise: Mapping[str, float] | None = None) -> dict[str, FloatArray]:
        """States for :meth:`advance`, at rest: by component, shape (order,), the first entry its rise in K.

        Parameters
        ----------
        initial_rise
            In K by component; 0 where not given.
        """
        start = self._start(initial_rise)
        states = {component.name: np.zeros(component.order) for component in self.model.components}
        for name, state in states.items():
            state[0] = float(np.asarray(start.get(name, 0.0)))
        return states

    def advance(
        self, states: Mapping[str, FloatArray], pwm: int, step_s: float, over: Mapping[str, float]
    ) -> dict[str, FloatArray]:
        """States after one interval of constant inputs.

        Parameters
        ----------
        states
            From :meth:`begin`, or from here.
        pwm
            -255..255.
        step_s
            How long, s.
        over
            By component what it tends to beside K |PWM| / A(0), in K: A(d/dt) T = K |PWM| + A(0) over. The ambient over
            the temperature that rises count from is such a thing, and so is further heat.
        """
        counts = int(magnitude([pwm])[0])
        after = {}
        for component in self.model.components:
            steps = self._interval(component, counts, step_s)
            away = states[component.name].copy()
            away[0] -= over[component.name]
            after[component.name] = states[component.name] + (steps.increment[0] @ away + steps.forced[0])
        return after

    def _interval(self, component: Component, counts: int, step_s: float) -> _Steps:
        key = (component.name, counts, step_s)
        if key not in self._intervals:
            self._intervals[key] = _step_matrices(
                component, _time_scale(component), np.array([counts]), np.array([step_s])
            )
        return self._intervals[key]

    def _start(self, initial_rise: Mapping[str, ArrayLike] | None) -> Mapping[str, ArrayLike]:
        unknown = set(initial_rise or {}) - set(self.model.component_names)
        if unknown:
            raise KeyError(f"no component {', '.join(sorted(unknown))}")
        return initial_rise or {}

    def _grid_steps(self, position: int, used: IntArray) -> _Steps:
        component, known, table = (
            self.model.components[position],
            self._known[position],
            self._table[position],
        )
        new = used[~known[used]]
        if new.size:
            step = np.full(new.size, self.model.sample_time)
            made = _step_matrices(component, _time_scale(component), new, step)
            table.increment[new] = made.increment
            table.forced[new] = made.forced
            known[new] = True
        return table


def magnitude(pwm: ArrayLike) -> IntArray:
    """|PWM| of integer PWM, -255..255, any shape.

    Raises
    ------
    TypeError, ValueError
        If it is none.
    """
    array = np.asarray(pwm)
    if array.dtype.kind not in "iu":
        raise TypeError(f"PWM is an integer, not {array.dtype}")
    counts = np.abs(array.astype(np.int64))
    if counts.size and counts.max() > MAX_PWM:
        raise ValueError(f"PWM is -{MAX_PWM}..{MAX_PWM}")
    return counts


def _time_scale(component: Component) -> float:
    """A power of two (exact to scale by) near the geometric mean of the component's time constants, in s."""
    lo, hi = component.validity
    last = component.denominator(np.arange(lo, hi + 1))[:, -1]
    rate = np.exp(np.mean(np.log(np.abs(last) + 1e-300))) ** (1.0 / component.order)
    return float(2.0 ** np.round(-np.log2(rate)))


def _step_matrices(component: Component, tau: float, pwm: IntArray, step: FloatArray) -> _Steps:
    """Exponentiate [[M, 1], [0, 0]]: its upper right block is phi(M) = (exp(M) - 1) / M, for any M.

    For order 1 the matrix exponential is the exponential itself.
    """
    n = component.order
    a, b = component.state_matrices(pwm)
    if n == 1:
        exponent = a[:, 0, 0] * step
        grown = np.expm1(exponent)
        phi = np.divide(grown, exponent, out=np.ones_like(grown), where=exponent != 0.0)
        return _Steps(grown[:, None, None], (phi * b[:, 0] * step * pwm)[:, None])
    from scipy.linalg import expm  # slow to import: reading and checking a file does without

    scale = tau ** np.arange(n)
    m = a * (scale[:, None] / scale[None, :]) * step[:, None, None]
    drive = b * scale * (step * pwm)[:, None]
    increment = np.empty((pwm.size, n, n))
    forced = np.empty((pwm.size, n))
    for first in range(0, pwm.size, _CHUNK):
        part = slice(first, first + _CHUNK)
        augmented = np.zeros((m[part].shape[0], 2 * n, 2 * n))
        augmented[:, :n, :n] = m[part]
        augmented[:, :n, n:] = np.eye(n)
        phi = np.asarray(expm(augmented), dtype=np.float64)[:, :n, n:]
        increment[part] = m[part] @ phi
        forced[part] = np.einsum("kij,kj->ki", phi, drive[part])
    return _Steps(increment, forced)


def _run(steps: _Steps, index: IntArray, x: FloatArray, out: FloatArray, over: FloatArray | None = None) -> None:
    """March one lane; over the ambient of a step a rise obeys the same equation as over a fixed one."""
    if over is not None:
        out[0] = x[: out.shape[-1]]
        for k, i in enumerate(index.tolist()):
            away = x.copy()
            away[0] -= over[k]
            x = x + (steps.increment[i] @ away + steps.forced[i])
            out[k + 1] = x[: out.shape[-1]]
        return
    if x.size == 1:
        # Python's own floats are several times quicker here than arrays of one element.
        increment, forced = steps.increment.ravel().tolist(), steps.forced.ravel().tolist()
        value = float(x[0])
        values = [value]
        for i in index.tolist():
            value += increment[i] * value + forced[i]
            values.append(value)
        out[:, 0] = values
        return
    kept = out.shape[-1]
    out[0] = x[:kept]
    for k, i in enumerate(index.tolist()):
        x = x + (steps.increment[i] @ x + steps.forced[i])
        out[k + 1] = x[:kept]


def _run_lanes(steps: _Steps, index: IntArray, x: FloatArray, out: FloatArray, over: FloatArray | None = None) -> None:
    kept = out.shape[-1]
    out[:, 0] = x[:, :kept]
    for k in range(index.shape[1]):
        i = index[:, k]
        away = x
        if over is not None:
            away = x.copy()
            away[:, 0] -= over[:, k]
        x = x + (np.einsum("lij,lj->li", steps.increment[i], away) + steps.forced[i])
        out[:, k + 1] = x[:, :kept]
