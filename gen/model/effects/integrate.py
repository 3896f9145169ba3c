"""Solving the effects' states along a run, for many runs and parameter sets at once.

The baseline's rise is given (the exact solution); only what effects add is integrated. A step multiplies by
exponentials (exact for a constant drive) and takes the mean of a drive that changes over the step: second order in its
length. All arrays have time first and then any lanes that broadcast: components, parameter sets, runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.model.effects.base import Effect, Lanes, Moment, Values
from gen.model.effects.response import Response, answer

Slot = tuple[Effect, Values]

_NEWTON = 8
"""Most rounds for a curved effect; each solves the whole course with the tangents at the last one."""
_SETTLED_K = 1e-7


@dataclass(frozen=True)
class Track:
    """What drives a component's effects.

    Parameters
    ----------
    step
        Length of each step in s, shape (K, ...); 0 pads runs of different length.
    elapsed
        Time since the run's start at the ends of the steps, s, shape (K + 1, ...), as all that follow with K + 1.
    base
        The baseline's rise, K (K + 1).
    fading
        What is left of a rise of 1 K at the start, by the component's own rate (K + 1).
    ambient, measured_ambient
        The ambient that the model counts from, and the measured one, degC (K + 1).
    rate, heat
        The component's own rate (1/s) and the baseline's heating (K/s), mean of each step (K).
    pwm, count, reverse, standstill
        As in :class:`Moment` (K).
    channels
        Extra channels (K).
    others
        Rise of other components (K + 1).
    measured_rise
        Measured rise at the start, K, without the time axis.
    response
        Of a component of higher order than 1: how it answers to heat. None: by its rate alone.
    """

    step: FloatArray
    elapsed: FloatArray
    base: FloatArray
    fading: FloatArray
    ambient: FloatArray
    measured_ambient: FloatArray
    rate: FloatArray
    heat: FloatArray
    pwm: FloatArray
    count: FloatArray
    reverse: FloatArray
    standstill: FloatArray
    channels: dict[str, FloatArray]
    others: dict[str, FloatArray]
    measured_rise: FloatArray
    response: Response | None = None


def start_shift(slots: Sequence[Slot], track: Track) -> Lanes:
    """How far the true rise at the start lies from the measured one, K."""
    shift: Lanes = 0.0
    for effect, p in slots:
        rise = track.measured_rise + shift
        shift = shift + effect.start(p, rise, track.ambient[0], track.measured_ambient[0])
    return shift


def readings(slots: Sequence[Slot], track: Track, *, shifted: bool = False) -> tuple[FloatArray, FloatArray]:
    """Rise with all effects, and what the sensor shows.

    Parameters
    ----------
    slots
        Effects with their parameters.
    track
        The drive.
    shifted
        The baseline starts from the effects' own start already.

    Returns
    -------
    rise, reading
        K and degC, shape (K + 1, ...).
    """
    base = track.base
    if not shifted:
        shift = start_shift(slots, track)
        if not (isinstance(shift, float) and shift == 0.0):
            base = base + shift * track.fading
    heating = [slot for slot in slots if slot[0].heats]
    added = _states(heating, track, base) if heating else 0.0
    rise = np.asarray(base + added)
    shown: Lanes = rise + track.ambient
    for effect, p in slots:
        lag = effect.lag(p)
        if lag is not None:
            shown = _lagged(shown, lag, track)
        shown = effect.reading(p, shown, track.ambient, track.measured_ambient, track.elapsed)
    return rise, np.asarray(shown)


def _states(slots: Sequence[Slot], track: Track, base: FloatArray) -> FloatArray:
    """Sum of the effects' states, K.

    States with a time constant of their own do not depend on the rise, and come first. The others all decay by the
    component's own poles, so their sum is one state; what they add for each K of rise changes its rate.
    """
    m = _moment(track)
    own: list[tuple[Effect, Values, Any]] = []
    apart: Lanes = 0.0
    start: Lanes = 0.0
    for effect, p in slots:
        inner = _inner(effect, p, m, track)
        begin = effect.begin(p, track.ambient[0], track.measured_ambient[0])
        tau = effect.own_tau(p)
        if tau is None:
            own.append((effect, p, inner))
            start = start + begin
        else:
            if inner is not None:
                m.inner = _middle(inner)
            rate = 1.0 / tau
            phi = _phi(rate, track.step)
            apart = apart + _recur(1.0 - phi * rate, phi * effect.heat(p, m), begin)
    if not own:
        return np.asarray(apart)
    known = base + apart
    total: Lanes = 0.0
    curved = any(effect.nonlinear for effect, _, _ in own)
    for _ in range(_NEWTON if curved else 1):
        m.rise = _middle(known + total)
        heat: Lanes = 0.0
        share: Lanes = 0.0
        for effect, p, inner in own:
            if inner is not None:
                m.inner = _middle(inner)
            heat = heat + effect.heat(p, m)
            share = share + effect.per_rise(p, m)
        if track.response is not None:
            latest = answer(track.response, heat, share, _middle(known), start)
        else:
            rate = m.rate - share
            phi = _phi(rate, track.step)
            latest = _recur(1.0 - phi * rate, phi * (heat + share * _middle(known)), start)
        change = float(np.max(np.abs(latest - total)))
        total = latest
        if change < _SETTLED_K:
            break
    return np.asarray(apart + total)


def _middle(ends: Lanes) -> Lanes:
    return 0.5 * (ends[1:] + ends[:-1])


def _moment(track: Track) -> Moment:
    m = Moment()
    m.rate, m.heat = track.rate, track.heat
    m.pwm, m.count = track.pwm, track.count
    m.reverse, m.standstill = track.reverse, track.standstill
    m.channels = track.channels
    m.ambient, m.measured_ambient = _middle(track.ambient), _middle(track.measured_ambient)
    m.others = {name: _middle(values) for name, values in track.others.items()}
    return m


def _phi(rate: Lanes, step: FloatArray) -> Lanes:
    """(1 - exp(-rate h))/rate, with its limit h for a rate of 0."""
    x = rate * step
    small = np.abs(x) < 1e-12
    return np.where(small, step, -np.expm1(-x) / np.where(small, 1.0, x) * step)


def _recur(factor: Lanes, added: Lanes, start: Lanes) -> FloatArray:
    """x[k + 1] = factor[k] x[k] + added[k]."""
    length = np.shape(factor)[0]
    shape = np.broadcast_shapes(np.shape(factor)[1:], np.shape(added)[1:], np.shape(start))
    if not shape:
        value = float(start)
        values = [value]
        for f, a in zip(factor.tolist(), np.broadcast_to(added, (length,)).tolist(), strict=True):
            value = f * value + a
            values.append(value)
        return np.asarray(values)
    out = np.empty((length + 1, *shape))
    out[0] = start
    for k in range(length):
        out[k + 1] = out[k] * factor[k] + added[k]
    return out


def _inner(effect: Effect, p: Values, whole: Moment, track: Track) -> Lanes:
    """The inner state at the ends of the steps, None without one."""
    found = effect.inner(p, whole)
    if found is None:
        return None
    target, tau = found
    kept = -np.expm1(-track.step / tau)
    return _recur(1.0 - kept, kept * target, effect.inner_start(p, track.measured_rise))


def _lagged(shown: Lanes, lag: Lanes, track: Track) -> FloatArray:
    """y' = (x - y)/lag with x straight between the ends of a step: exact."""
    h = track.step
    kept = np.exp(-h / lag)
    share = np.where(h > 0.0, (lag / np.where(h > 0.0, h, 1.0)) * -np.expm1(-h / lag), 1.0)
    # y1 = kept y0 + (share - kept) x0 + (1 - share) x1
    shown = np.asarray(shown)
    added = (share - kept) * shown[:-1] + (1.0 - share) * shown[1:]
    return _recur(kept, added, shown[0])
