"""The differential equations of a model with effects, for inputs that are held over each sample: what judges the board.

Runge-Kutta of order 4 at the sample time, on the equations as the effects' files state them; it shares no code with the
lowering or the reference. With poles of 0.02 1/s its error stays below 1e-9 K; :mod:`tests.effects` holds it
against an integration by step size control.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.model import ThermalModel
from gen.model.dynamics import PWM_LEVELS, Component
from gen.model.effects import Applied, Moment
from gen.model.extended import own_rate


class HeldSolution:
    """L lanes of a model with effects.

    Parameters
    ----------
    model, effects
        What to solve; |PWM| is held to the model's domain, as on the board.
    shown_K
        What each sensor shows over the measured ambient at the start, by component, shape (L,), in K.
    ambient
        Measured, degC, shape (L,), at the start.
    baseline_K
        Rise from which each component's baseline starts, where it is known (a board has it in whole thousandths).
    """

    def __init__(
        self,
        model: ThermalModel,
        effects: Sequence[Applied],
        shown_K: Mapping[str, FloatArray],
        ambient: FloatArray,
        baseline_K: Mapping[str, FloatArray] | None = None,
    ) -> None:
        self._model = model
        fixed = any(applied.effect.replaces_ambient for applied in effects)
        self._fixed = model.ambient_fixed if fixed else None
        self._parts = [
            _Part(model, component, [a for a in effects if a.component == component.name])
            for component in model.components
        ]
        own = self._ambient(ambient)
        self._state = [
            part.start(np.asarray(shown_K[part.name], dtype=np.float64) + ambient - own, own, ambient)
            for part in self._parts
        ]
        for state in self._state:
            state[0] += self._over(ambient)
        for name, rise in (baseline_K or {}).items():
            self._state[model.component_names.index(name)][0] = rise
        self._measured, self._elapsed = ambient, 0.0
        for part, state in zip(self._parts, self._state, strict=True):
            part.settle(state, self._counted_from(own), own, ambient)

    def step(self, pwm: IntArray, ambient: FloatArray, channels: Mapping[str, FloatArray]) -> None:
        """Advance by one sample.

        Parameters
        ----------
        pwm, ambient, channels
            Of the sample, shape (L,) each.
        """
        h, y = self._model.sample_time, self._state
        low, high = self._model.domain_pwm
        count = np.clip(np.abs(pwm), low, high)

        def slope(state: list[FloatArray], later: float) -> list[FloatArray]:
            return self._slopes(state, count, pwm < 0, ambient, channels, self._elapsed + later)

        def moved(by: list[FloatArray], share: float) -> list[FloatArray]:
            return [a + share * b for a, b in zip(y, by, strict=True)]

        k1 = slope(y, 0.0)
        k2 = slope(moved(k1, h / 2), h / 2)
        k3 = slope(moved(k2, h / 2), h / 2)
        k4 = slope(moved(k3, h), h)
        self._state = [a + h / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(y, k1, k2, k3, k4, strict=True)]
        self._elapsed += h
        self._measured = ambient

    def shown(self) -> FloatArray:
        """What the sensors show over the measured ambient, shape (components, L), K."""
        own = self._ambient(self._measured)
        return np.array(
            [
                part.reading(state, self._counted_from(own), own, self._measured, self._elapsed)[0] - self._measured
                for part, state in zip(self._parts, self._state, strict=True)
            ]
        )

    def _ambient(self, measured: FloatArray) -> FloatArray:
        return measured if self._fixed is None else np.full_like(measured, self._fixed)

    def _counted_from(self, ambient: FloatArray) -> FloatArray:
        """What the baselines' rises count from, degC."""
        return ambient - self._over(ambient)

    def _over(self, ambient: FloatArray) -> FloatArray:
        """The ambient that acts on the baselines, over what their rises count from, K."""
        return ambient - self._model.ambient_reference if self._model.ambient_passes else np.zeros_like(ambient)

    def _slopes(
        self, state: list[FloatArray], count: IntArray, reverse: BoolArray, ambient: FloatArray,
        channels: Mapping[str, FloatArray], elapsed: float,
    ) -> list[FloatArray]:  # fmt: skip
        own = self._ambient(ambient)
        over = self._over(own)
        rises = {part.name: part.rise(y) - over for part, y in zip(self._parts, state, strict=True)}
        result = []
        for part, y in zip(self._parts, state, strict=True):
            m: Any = Moment()
            m.count = count.astype(np.float64)
            m.pwm = m.count / self._model.full_scale
            m.reverse, m.standstill = reverse.astype(np.float64), (count == 0).astype(np.float64)
            m.rate, m.heat = part.rate[count], part.heat[count]
            m.rise, m.ambient, m.measured_ambient = rises[part.name], own, ambient
            m.others = {name: rise for name, rise in rises.items() if name != part.name}
            m.channels = channels
            result.append(part.slope(y, m, count, over, self._counted_from(own), elapsed))
        return result


def _at_rest() -> Moment:
    """What drives a cold component at standstill: to ask whether an effect has an inner state."""
    m: Any = Moment()
    for name in ("pwm", "count", "reverse", "rate", "heat"):
        setattr(m, name, np.zeros(1))
    m.standstill = np.ones(1)
    moment: Moment = m
    return moment


class _Part:
    """One component: baseline (T, T', ..), E (E, E', ..), then own states, inner states and lags, shape (.., L)."""

    def __init__(self, model: ThermalModel, component: Component, own: Sequence[Applied]) -> None:
        x = np.arange(PWM_LEVELS)
        self.name, self.order, self._own = component.name, component.order, list(own)
        self.rate = own_rate(component)
        self.heat = self.rate * component.steady_rise(x)
        self._a = component.denominator(x)
        self._drive = component.effective_gain(x) * x
        self._timed = [a for a in own if a.effect.heats and a.effect.own_tau(a.values) is not None]
        self._inner = [a for a in own if a.effect.heats and a.effect.inner(a.values, _at_rest()) is not None]
        self._lags = [a for a in own if a.effect.lag(a.values) is not None]

    def start(self, seen: FloatArray, ambient: FloatArray, measured: FloatArray) -> FloatArray:
        n = self.order
        y = np.zeros((2 * n + len(self._timed) + len(self._inner) + len(self._lags), *seen.shape))
        y[0] = seen
        for a in self._own:
            y[0] = y[0] + a.effect.start(a.values, y[0], ambient, measured)
            begin = a.effect.begin(a.values, ambient, measured) if a.effect.heats else 0.0
            place = 2 * n + self._timed.index(a) if a in self._timed else n
            y[place] = y[place] + begin
        for i, a in enumerate(self._inner):
            y[2 * n + len(self._timed) + i] = a.effect.inner_start(a.values, seen)
        return y

    def settle(self, y: FloatArray, counted_from: FloatArray, ambient: FloatArray, measured: FloatArray) -> None:
        """Sensors with a lag show what they see."""
        for i in range(len(self._lags)):
            y[y.shape[0] - len(self._lags) + i] = self.reading(y, counted_from, ambient, measured, 0.0)[1][i]

    def rise(self, y: FloatArray) -> FloatArray:
        n = self.order
        return np.asarray(y[0] + y[n] + y[2 * n : 2 * n + len(self._timed)].sum(axis=0))

    def reading(
        self, y: FloatArray, counted_from: FloatArray, ambient: FloatArray, measured: FloatArray, elapsed: float
    ) -> tuple[FloatArray, list[FloatArray]]:
        """What the sensor shows, and what stands before each lag, degC."""
        value, before = self.rise(y) + counted_from, []
        for a in self._own:
            if a in self._lags:
                before.append(value)
                value = y[y.shape[0] - len(self._lags) + len(before) - 1]
            value = a.effect.reading(a.values, value, ambient, measured, elapsed)
        return value, before

    def slope(
        self, y: FloatArray, m: Moment, count: IntArray, over: FloatArray, counted_from: FloatArray, elapsed: float
    ) -> FloatArray:
        n, timed = self.order, len(self._timed)
        out = np.zeros_like(y)
        a = self._a[count]
        q: Any = 0.0
        for applied in self._own:
            effect, p = applied.effect, applied.values
            if not effect.heats:
                continue
            if applied in self._inner:
                place = 2 * n + timed + self._inner.index(applied)
                found = effect.inner(p, m)
                assert found is not None
                m.inner = y[place]
                out[place] = (found[0] - y[place]) / found[1]
            if applied in self._timed:
                place = 2 * n + self._timed.index(applied)
                out[place] = effect.heat(p, m) - y[place] / effect.own_tau(p)
            else:
                q = q + effect.heat(p, m) + effect.per_rise(p, m) * m.rise
        for first, drive in ((0, self._drive[count] + a[:, n] * over), (n, a[:, n - 1] * q)):
            out[first : first + n - 1] = y[first + 1 : first + n]
            out[first + n - 1] = drive - sum(a[:, n - k] * y[first + k] for k in range(n))
        before = self.reading(y, counted_from, m.ambient, m.measured_ambient, elapsed)[1]
        for i, applied in enumerate(self._lags):
            place = y.shape[0] - len(self._lags) + i
            out[place] = (before[i] - y[place]) / applied.effect.lag(applied.values)
        return out
