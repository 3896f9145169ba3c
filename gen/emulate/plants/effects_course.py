"""Transfer functions with effects, step by step: what `gen.model.extended` solves for a whole run at once.

Over steps that are short beside every time constant the drive of an effect is that of the step's middle, and what parts
hand each other is that of its beginning.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.emulate.plants.courses import Active, PartsCourse
from gen.model.dynamics import PWM_LEVELS, Component, ThermalModel
from gen.model.effects.base import Applied, Moment
from gen.model.effects.response import response
from gen.model.extended import FINEST_S, own_rate

_ROUNDS = 2
"""The first finds where a step ends, the second takes its middle."""


class EffectsCourse:
    """Parts by transfer functions, each with its effects; what a fault adds, effects see as all other heat.

    Parameters
    ----------
    coefficients
        The file.
    start_degC, ambient
        As :class:`PartsCourse`; derivatives start at 0.
    """

    def __init__(self, coefficients: Coefficients, start_degC: Mapping[str, float], ambient: float) -> None:
        self._model = model = coefficients.model
        brought = any(applied.effect.replaces_ambient for applied in coefficients.effects)
        self._fixed = model.ambient_fixed if brought else None
        room = self._room(ambient)
        parts = {}
        for component in model.components:
            own = [applied for applied in coefficients.effects if applied.component == component.name]
            rise = start_degC.get(component.name, ambient) - room.counted
            parts[component.name] = _Part(model, component, own, rise, room)
        self._parts = parts
        start = {name: part.base + room.counted for name, part in parts.items()}
        self._base = PartsCourse(model, start, room.counted)
        self._elapsed_s = 0.0

    def step(self, pwm: int, dt_s: float, ambient: float, told: Mapping[str, float], active: Active) -> None:
        """See `Course.step`."""
        count = max(1, math.ceil(dt_s / FINEST_S - 1e-9))
        for _ in range(count):
            self._step(pwm, dt_s / count, self._room(ambient), told, active)

    def _step(self, pwm: int, step_s: float, room: _Room, told: Mapping[str, float], active: Active) -> None:
        before = self._base.parts
        self._base.step(pwm, step_s, room.counted, told, active)
        self._elapsed_s += step_s
        rises = {name: part.rise for name, part in self._parts.items()}
        for name, part in self._parts.items():
            moment = _moment(self._model, pwm, room, told, {other: rises[other] for other in rises if other != name})
            ends = (before[name] - room.counted, self._base.parts[name] - room.counted)
            part.step(moment, ends, step_s, room, self._elapsed_s)

    @property
    def parts(self) -> dict[str, float]:
        """See `Course.parts`."""
        return {name: part.temperature for name, part in self._parts.items()}

    @property
    def shown(self) -> dict[str, float]:
        """See `Course.shown`."""
        return {name: part.shown for name, part in self._parts.items()}

    def _room(self, ambient: float) -> _Room:
        return _Room(ambient if self._fixed is None else self._fixed, ambient)


@dataclass(frozen=True)
class _Room:
    """The ambient that the model counts from, and the measured one, degC."""

    counted: float
    measured: float


@dataclass
class _Slot:
    """An effect with its states.

    Attributes
    ----------
    own
        E, where it has a time constant of its own, K.
    inner, middle
        The inner state now, and its mean over the last step.
    lagged
        What a lagging sensor was fed and what it shows, degC; None before the first time.
    """

    applied: Applied
    own: float = 0.0
    inner: Any = None
    middle: Any = 0.0
    lagged: tuple[float, float] | None = None


class _Part:
    """One component's effects.

    Attributes
    ----------
    base, rise
        Rise without and with the effects, K.
    temperature, shown
        True, and what the sensor shows, degC.
    """

    def __init__(
        self, model: ThermalModel, component: Component, effects: Sequence[Applied], rise: float, room: _Room
    ) -> None:
        self._component = component
        levels = np.arange(PWM_LEVELS)
        self._rates = own_rate(component)
        self._heats = self._rates * component.steady_rise(levels)
        self._answer = cache(self._made)
        self._slots = [_Slot(applied) for applied in effects]
        #: E of everything that decays by the component's own poles, with its derivatives.
        self._shared = np.zeros(component.order)
        shift = 0.0
        for slot in self._slots:
            effect, p = slot.applied.effect, slot.applied.values
            shift += float(effect.start(p, rise + shift, room.counted, room.measured))
        for slot in self._slots:
            effect, p = slot.applied.effect, slot.applied.values
            slot.inner = effect.inner_start(p, rise)
            if effect.heats:
                begin = float(effect.begin(p, room.counted, room.measured))
                if effect.own_tau(p) is None:
                    self._shared[0] += begin
                else:
                    slot.own = begin
        self.base = rise + shift
        self.rise = self.base + self._added
        self.temperature = self.rise + room.counted
        self.shown = self._read(room, 0.0, 0.0)

    @property
    def _added(self) -> float:
        return float(self._shared[0]) + sum(slot.own for slot in self._slots)

    def step(self, moment: Moment, base: tuple[float, float], step_s: float, room: _Room, elapsed_s: float) -> None:
        """Go on by one step.

        Parameters
        ----------
        moment
            What drives the effects but for the part's own rise and rates.
        base
            Rise without effects at the step's beginning and end, over this step's ambient, K.
        step_s, room, elapsed_s
            Its length, its ambient, and the time at its end, s.
        """
        count = int(moment.count)
        moment.rate, moment.heat = self._rates[count], self._heats[count]
        before = sum(slot.own for slot in self._slots)
        heating = [slot for slot in self._slots if slot.applied.effect.heats]
        for slot in heating:
            self._step_inner(slot, moment, step_s)
        for slot in heating:
            tau = slot.applied.effect.own_tau(slot.applied.values)
            if tau is not None:
                moment.inner = slot.middle
                target = tau * float(slot.applied.effect.heat(slot.applied.values, moment))
                slot.own += -math.expm1(-step_s / tau) * (target - slot.own)
        after = sum(slot.own for slot in self._slots)
        known = 0.5 * (base[0] + before + base[1] + after)
        self._share(heating, moment, known, step_s)
        self.base = base[1]
        self.rise = self.base + self._added
        self.temperature = self.rise + room.counted
        self.shown = self._read(room, step_s, elapsed_s)

    @staticmethod
    def _step_inner(slot: _Slot, moment: Moment, step_s: float) -> None:
        """Move an inner state on, and keep its mean over the step."""
        found = slot.applied.effect.inner(slot.applied.values, moment)
        if found is None:
            return
        target, tau = found
        after = slot.inner - math.expm1(-step_s / float(tau)) * (float(target) - slot.inner)
        slot.middle, slot.inner = 0.5 * (slot.inner + after), after

    def _share(self, heating: Sequence[_Slot], moment: Moment, known: float, step_s: float) -> None:
        """Move the state on that all effects without a time constant of their own share."""
        own = [slot for slot in heating if slot.applied.effect.own_tau(slot.applied.values) is None]
        transition, forced = self._answer(int(moment.count), step_s)
        after = self._shared
        for _ in range(_ROUNDS):
            moment.rise = known + 0.5 * (self._shared[0] + after[0])
            heat = 0.0
            for slot in own:
                effect, p = slot.applied.effect, slot.applied.values
                moment.inner = slot.middle
                heat += float(effect.heat(p, moment) + effect.per_rise(p, moment) * moment.rise)
            after = transition @ self._shared + forced * heat
        self._shared = after

    def _made(self, count: int, step_s: float) -> tuple[FloatArray, FloatArray]:
        made = response(self._component, np.array([[count]]), np.array([[step_s]]))
        return made.transition[0, 0], made.forced[0, 0]

    def _read(self, room: _Room, step_s: float, elapsed_s: float) -> float:
        shown: Any = self.temperature
        for slot in self._slots:
            effect, p = slot.applied.effect, slot.applied.values
            lag = effect.lag(p)
            if lag is not None:
                fed, held = slot.lagged or (shown, shown)
                slot.lagged = (shown, _follow(fed, held, shown, step_s / float(lag)))
                shown = slot.lagged[1]
            shown = effect.reading(p, shown, room.counted, room.measured, elapsed_s)
        return float(shown)


def _follow(fed: float, held: float, now: float, steps: float) -> float:
    """What a sensor shows whose input went from `fed` to `now` in a straight line over so many time constants."""
    if steps == 0.0:
        return held
    kept = math.exp(-steps)
    share = -math.expm1(-steps) / steps
    return kept * held + (share - kept) * fed + (1.0 - share) * now


def _moment(
    model: ThermalModel, pwm: int, room: _Room, told: Mapping[str, float], others: Mapping[str, float]
) -> Moment:
    m: Any = Moment()
    m.count = np.float64(abs(pwm))
    m.pwm = m.count / model.full_scale
    m.reverse, m.standstill = np.float64(pwm < 0), np.float64(pwm == 0)
    m.ambient, m.measured_ambient = np.float64(room.counted), np.float64(room.measured)
    m.channels = {column: np.float64(value) for column, value in told.items()}
    m.others = {name: np.float64(value) for name, value in others.items()}
    made: Moment = m
    return made
