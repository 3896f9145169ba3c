"""Solving the effects' states along a run, for many runs and parameter sets at once.

The baseline's rise is given (the exact solution); only what effects add is integrated. A step multiplies by exponentials
(exact for a constant drive) and averages the drive over its two ends: second order in the step, and exact where
the drive is held. All arrays have time first and then any lanes that broadcast: components, parameter sets, runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.model.effects.base import Array, Effect, Moment, Values

Slot = tuple[Effect, Values]


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
    """

    step: Array
    elapsed: Array
    base: Array
    fading: Array
    ambient: Array
    measured_ambient: Array
    rate: Array
    heat: Array
    pwm: Array
    count: Array
    reverse: Array
    standstill: Array
    channels: dict[str, Array]
    others: dict[str, Array]
    measured_rise: Array


def start_shift(slots: Sequence[Slot], track: Track) -> Any:  # noqa: ANN401
    """How far the true rise at the start lies from the measured one, K."""
    shift: Any = 0.0
    for effect, p in slots:
        rise = track.measured_rise + shift
        shift = shift + effect.start(p, rise, track.ambient[0], track.measured_ambient[0])
    return shift


def readings(slots: Sequence[Slot], track: Track, *, shifted: bool = False) -> tuple[Array, Array]:
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
    shown: Any = rise + track.ambient
    for effect, p in slots:
        lag = effect.lag(p)
        if lag is not None:
            shown = _lagged(shown, lag, track)
        shown = effect.reading(p, shown, track.ambient, track.measured_ambient, track.elapsed)
    return rise, np.asarray(shown)


def _states(slots: Sequence[Slot], track: Track, base: Array) -> Array:
    whole = _moment(track, slice(None))
    inner = [_inner(effect, p, whole, track) for effect, p in slots]
    rates = [effect.rate(p, whole) for effect, p in slots]
    phis = [_phi(rate, track.step) for rate in rates]
    starts = [effect.begin(p, track.ambient[0], track.measured_ambient[0]) for effect, p in slots]
    known = [None if slot[0].feedback else _known_heat(slot, whole, h) for slot, h in zip(slots, inner, strict=True)]
    if all(q is not None for q in known):
        total: Any = 0.0
        for q, rate, phi, start in zip(known, rates, phis, starts, strict=True):
            total = total + _recur(1.0 - phi * rate, phi * q, start)
        return np.asarray(total)
    return _coupled(slots, track, base, inner, rates, phis, starts, known)


def _coupled(
    slots: Sequence[Slot],
    track: Track,
    base: Array,
    inner: list[Any],
    rates: list[Any],
    phis: list[Any],
    starts: list[Any],
    known: list[Any],
) -> Array:
    length = track.step.shape[0]
    many = len(slots)
    shape = np.broadcast_shapes(
        base.shape[1:],
        *(np.shape(array)[1:] for array in (*phis, *known) if array is not None),
        *(_lanes(p) for _, p in slots),
    )
    states: list[Any] = [np.zeros(shape) + start for start in starts]
    out = np.empty((length + 1, *shape))
    out[0] = sum(states)
    moments = [Moment() for _ in slots]
    decay = [1.0 - phi * rate for phi, rate in zip(phis, rates, strict=True)]
    free = [i for i in range(many) if known[i] is None]
    for k in range(length):
        total = out[k]
        first: list[Any] = [None] * many
        predicted: Any = 0.0
        for i, (effect, p) in enumerate(slots):
            if known[i] is not None:
                first[i] = known[i][k]
            else:
                m = moments[i]
                _fill(m, track, k)
                m.rise, m.ambient = base[k] + total, track.ambient[k]
                m.measured_ambient = track.measured_ambient[k]
                m.others = {name: values[k] for name, values in track.others.items()}
                if inner[i] is not None:
                    m.inner = inner[i][k]
                first[i] = effect.heat(p, m)
            predicted = predicted + decay[i][k] * states[i] + phis[i][k] * first[i]
        for i in free:
            effect, p = slots[i]
            m = moments[i]
            m.rise, m.ambient = base[k + 1] + predicted, track.ambient[k + 1]
            m.measured_ambient = track.measured_ambient[k + 1]
            m.others = {name: values[k + 1] for name, values in track.others.items()}
            if inner[i] is not None:
                m.inner = inner[i][k + 1]
            first[i] = 0.5 * (first[i] + effect.heat(p, m))
        total = 0.0
        for i in range(many):
            states[i] = decay[i][k] * states[i] + phis[i][k] * first[i]
            total = total + states[i]
        out[k + 1] = total
    return out


def _lanes(p: Values) -> tuple[int, ...]:
    entries = [entry for value in p.values() for entry in (value if isinstance(value, list) else [value])]
    return np.broadcast_shapes(*(entry.shape for entry in entries if isinstance(entry, np.ndarray)))


def _moment(track: Track, at: Any) -> Moment:  # noqa: ANN401
    m = Moment()
    _fill(m, track, at)
    m.ambient = 0.5 * (track.ambient[1:] + track.ambient[:-1])
    m.measured_ambient = 0.5 * (track.measured_ambient[1:] + track.measured_ambient[:-1])
    return m


def _fill(m: Moment, track: Track, at: Any) -> None:  # noqa: ANN401
    m.rate, m.heat = track.rate[at], track.heat[at]
    m.pwm, m.count = track.pwm[at], track.count[at]
    m.reverse, m.standstill = track.reverse[at], track.standstill[at]
    m.channels = {name: values[at] for name, values in track.channels.items()} if at != slice(None) else track.channels


def _phi(rate: Any, step: Array) -> Any:  # noqa: ANN401
    """(1 - exp(-rate h))/rate, with its limit h for a rate of 0."""
    x = rate * step
    small = np.abs(x) < 1e-12
    return np.where(small, step, -np.expm1(-x) / np.where(small, 1.0, x) * step)


def _recur(factor: Any, added: Any, start: Any) -> Array:  # noqa: ANN401
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


def _inner(effect: Effect, p: Values, whole: Moment, track: Track) -> Any:  # noqa: ANN401
    """The inner state at the ends of the steps, None without one."""
    found = effect.inner(p, whole)
    if found is None:
        return None
    target, tau = found
    kept = -np.expm1(-track.step / tau)
    return _recur(1.0 - kept, kept * target, effect.inner_start(p, track.measured_rise))


def _known_heat(slot: Slot, whole: Moment, inner: Any) -> Any:  # noqa: ANN401
    effect, p = slot
    if inner is not None:
        whole.inner = 0.5 * (inner[1:] + inner[:-1])
    return effect.heat(p, whole)


def _lagged(shown: Any, lag: Any, track: Track) -> Array:  # noqa: ANN401
    """y' = (x - y)/lag with x straight between the ends of a step: exact."""
    h = track.step
    kept = np.exp(-h / lag)
    share = np.where(h > 0.0, (lag / np.where(h > 0.0, h, 1.0)) * -np.expm1(-h / lag), 1.0)
    # y1 = kept y0 + (share - kept) x0 + (1 - share) x1
    shown = np.asarray(shown)
    added = (share - kept) * shown[:-1] + (1.0 - share) * shown[1:]
    return _recur(kept, added, shown[0])
