"""The model with its effects, solved in float64 at a run's own times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.errors import CheckFailed
from gen.model.dynamics import PWM_LEVELS, Component, ThermalModel
from gen.model.effects.base import Applied
from gen.model.effects.integrate import Slot, Track, readings, start_shift
from gen.model.effects.response import response
from gen.model.exact import ExactSolution

FINEST_S = 1.0
"""Longest step of the effects' states: a thermal time constant is hundreds of these."""

_ROUNDS = 1000
"""What coupled parts hand each other becomes smaller from round to round by the loop gain, which is below 1."""
_SETTLED_K = 1e-10
ENDLESS_K = 1e5
"""No rise of a motor: beyond it a solution is one that grows without end, of which more than a line says nothing."""


def own_rate(component: Component) -> FloatArray:
    """The rate at which heat leaves a component at |PWM| 0..255: A(0)/A'(0), 1/s; of order 1 its only pole."""
    a = component.denominator(np.arange(PWM_LEVELS))
    return np.asarray(a[:, -1] / a[:, -2])


def fold(model: ThermalModel, effects: Sequence[Applied]) -> tuple[ThermalModel, tuple[Applied, ...]]:
    """Move effects that are mere changes of the model's entries into it.

    Returns
    -------
    model, effects
        The changed model, and the effects that need a state or channel of their own.
    """
    rest = []
    for applied in effects:
        changed = applied.effect.folded(applied.values, model, applied.component)
        if changed is None:
            rest.append(applied)
        else:
            model = changed
    return model, tuple(rest)


class ExtendedSolution:
    """Temperatures of a model with effects.

    Parameters
    ----------
    model
        The baseline, with what can be folded into it already there.
    effects
        The others.
    finest_s
        Longest step of the effects' states, s.
    """

    def __init__(self, model: ThermalModel, effects: Sequence[Applied], finest_s: float = FINEST_S) -> None:
        self.model = model
        self._finest_s = finest_s
        self.effects = tuple(effects)
        self._baseline = ExactSolution(model)

    def simulate_times(
        self,
        time_s: FloatArray,
        pwm: IntArray,
        ambient: FloatArray,
        measured_ambient: FloatArray,
        channels: Mapping[str, FloatArray],
        start_rise: Mapping[str, float],
    ) -> dict[str, FloatArray]:
        """Solve at the times of a run.

        Parameters
        ----------
        time_s
            Strictly increasing, s, shape (N,), as all arrays here.
        pwm
            -255..255, held until the next row.
        ambient, measured_ambient
            The ambient that the model counts from, and the measured one, degC.
        channels
            Extra channels by column, held; no NaN.
        start_rise
            Measured rise at the first time by component, K.

        Returns
        -------
        dict
            What each component's sensor shows, degC.

        Raises
        ------
        CheckFailed
            If a temperature grows without end: channels may lie beyond the ranges that the coefficient file declares.
        """
        fine, rows = _refined(time_s, self._finest_s)
        held = np.clip(np.searchsorted(time_s, fine, side="right") - 1, 0, time_s.size - 1)
        counts = np.abs(pwm[held])
        shared = _shared(self.model, fine, pwm[held], {name: values[held] for name, values in channels.items()})
        ambient, measured_ambient = ambient[held], measured_ambient[held]
        slots: dict[str, list[Slot]] = {name: [] for name in self.model.component_names}
        for applied in self.effects:
            slots[applied.component].append((applied.effect, applied.values))
        tracks = {
            component.name: self._track(component, shared, counts, ambient, measured_ambient, start_rise)
            for component in self.model.components
        }
        shift = {name: start_shift(slots[name], track) for name, track in tracks.items()}
        base = self._baseline.over_ambient(
            fine, pwm[held], ambient, {name: float(start_rise.get(name, 0.0) + shift[name]) for name in tracks}
        )
        shown = self._settled(slots, tracks, base)
        return {name: values[rows] for name, values in shown.items()}

    def _settled(
        self, slots: Mapping[str, Sequence[Slot]], tracks: Mapping[str, Track], base: Mapping[str, FloatArray]
    ) -> dict[str, FloatArray]:
        """What each sensor shows, found in rounds where parts hand each other heat.

        Raises
        ------
        CheckFailed
            If a temperature grows without end, or the rounds do not settle.
        """
        rises = dict(base)
        shown: dict[str, FloatArray] = {}
        coupled = any(applied.sources(tracks) for applied in self.effects)
        for _ in range(_ROUNDS if coupled else 1):
            change = 0.0
            for name, track in tracks.items():
                others = {other: rise for other, rise in rises.items() if other != name}
                with np.errstate(over="ignore", invalid="ignore"):
                    made = readings(slots[name], replace(track, base=base[name], others=others), shifted=True)
                rise, shown[name] = made
                if not np.all(np.abs(rise) < ENDLESS_K):
                    raise CheckFailed(
                        f'with its effects the temperature of "{name}" grows without end in this run (docs/effects.md)'
                    )
                change = max(change, float(np.max(np.abs(rise - rises[name]))))
                rises[name] = rise
            if change < _SETTLED_K or not coupled:
                return shown
        raise CheckFailed("parts that heat each other do not settle in this run (docs/effects.md)")

    @staticmethod
    def _track(
        component: Component,
        shared: Track,
        counts: IntArray,
        ambient: FloatArray,
        measured_ambient: FloatArray,
        start_rise: Mapping[str, float],
    ) -> Track:
        rate = own_rate(component)
        heat = rate * component.steady_rise(np.arange(PWM_LEVELS))
        own = None
        if component.order > 1:
            own = response(component, counts[:-1, None], shared.step[:, None])
        return replace(
            shared,
            response=own,
            rate=rate[counts[:-1]],
            heat=heat[counts[:-1]],
            ambient=ambient,
            measured_ambient=measured_ambient,
            measured_rise=np.asarray(start_rise.get(component.name, 0.0)),
        )


def _refined(time_s: FloatArray, finest_s: float) -> tuple[FloatArray, IntArray]:
    """The run's times with more between them where they lie far apart, and where the run's own are."""
    parts = np.maximum(np.ceil(np.diff(time_s) / finest_s - 1e-9), 1.0).astype(np.int64)
    rows = np.concatenate([[0], np.cumsum(parts)])
    if rows[-1] == time_s.size - 1:
        return time_s, rows
    return np.interp(np.arange(rows[-1] + 1), rows, time_s), rows


def _shared(model: ThermalModel, time: FloatArray, pwm: IntArray, channels: dict[str, FloatArray]) -> Track:
    nothing = np.zeros(time.size)
    counts = np.abs(pwm[:-1]).astype(np.float64)
    return Track(
        step=np.diff(time),
        elapsed=time - time[0],
        base=nothing,
        fading=nothing,
        ambient=nothing,
        measured_ambient=nothing,
        rate=nothing[1:],
        heat=nothing[1:],
        pwm=counts / model.full_scale,
        count=counts,
        reverse=(pwm[:-1] < 0).astype(np.float64),
        standstill=(counts == 0).astype(np.float64),
        channels={name: values[:-1] for name, values in channels.items()},
        others={},
        measured_rise=np.asarray(0.0),
    )
