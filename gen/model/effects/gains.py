"""How strongly effects answer to rises: what decides whether a model with effects contracts.

Heat that an effect adds for each kelvin of its own part's rise makes the part's rate smaller (or larger, where it
cools); heat that follows another part's rise closes a loop through both. Where what comes back round is as much as
what went in, temperatures run away, whatever the baseline does. All of it is read off the effects' own equations,
given ranges (:mod:`gen.model.effects.spans`): an effect declares nothing, and is never asked for its name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.model.dynamics import Component, ThermalModel
from gen.model.effects.base import Applied, Moment
from gen.model.effects.spans import Ends, Span

ZERO_K_degC = -273.15
"""No temperature lies below it."""

Range = tuple[float, float]


@dataclass(frozen=True)
class Domain:
    """Where everything may lie that an equation reads beside |PWM|.

    Parameters
    ----------
    rows
        |PWM| of the model's domain, shape (R,).
    rise
        Rise of each component by name, K.
    ambient
        The ambient that the model counts from, and the measured one, degC.
    channels
        Extra channels by column.
    """

    rows: FloatArray
    rise: Mapping[str, Range]
    ambient: Range
    channels: Mapping[str, Range]


@dataclass(frozen=True)
class Share:
    """What one effect adds to the loops.

    Parameters
    ----------
    applied
        The effect at its component.
    own
        Slope of its heat over its component's own rise, lowest and highest, 1/s, shape (R,) each.
    others
        Largest magnitude of that slope over the rise of other components, 1/s, shape (R,) each.
    apart
        Of an effect with a time constant of its own: what its state E answers in the steady state, K for each K of
        a component's rise (its own among them), shape (R,) each. `own` and `others` are then 0.
    """

    applied: Applied
    own: tuple[FloatArray, FloatArray]
    others: Mapping[str, FloatArray]
    apart: Mapping[str, FloatArray]


@dataclass(frozen=True)
class PartGains:
    """What all effects of a component come to.

    Parameters
    ----------
    component
        The component.
    rate
        Its own rate, 1/s, shape (R,), as all arrays here.
    shares
        Its effects.
    """

    component: Component
    rate: FloatArray
    shares: tuple[Share, ...]

    @property
    def own(self) -> tuple[FloatArray, FloatArray]:
        """Slope of all heat over the own rise, lowest and highest, 1/s."""
        none = np.zeros_like(self.rate)
        return sum((s.own[0] for s in self.shares), none), sum((s.own[1] for s in self.shares), none)

    def heating(self, source: str) -> FloatArray:
        """Largest slope of the heat over another component's rise, or of what its apart states add, 1/s."""
        none = np.zeros_like(self.rate)
        direct = sum((s.others.get(source, none) for s in self.shares), none)
        return direct + np.maximum(*(np.abs(end) for end in self.own)) * self.apart(source)

    def apart(self, source: str) -> FloatArray:
        """Steady answer of the states with time constants of their own, K for each K of a component's rise."""
        none = np.zeros_like(self.rate)
        return sum((s.apart.get(source, none) for s in self.shares), none)


def gains(model: ThermalModel, effects: Sequence[Applied], domain: Domain) -> tuple[PartGains, ...]:
    """Read the slopes of all effects off their equations.

    Parameters
    ----------
    model, effects
        The model, with what can be folded into it already there, and the other effects.
    domain
        Ranges of all that they read.

    Returns
    -------
    tuple of PartGains
        One for each component of the model, in order.

    Raises
    ------
    TypeError
        If an equation is not made of ``+ - *``, whole powers and divisions by numbers.
    """
    from gen.model.extended import own_rate  # which takes this package's effects

    made = []
    for component in model.components:
        m = _moment(model, component, domain, own_rate(component)[domain.rows.astype(np.int64)])
        own = [a for a in effects if a.component == component.name and a.effect.heats]
        made.append(PartGains(component, m.rate, tuple(_share(applied, m) for applied in own)))
    return tuple(made)


def _moment(model: ThermalModel, component: Component, domain: Domain, rate: FloatArray) -> Moment:
    def rise(name: str) -> Span:
        low, high = domain.rise[name]
        return Span(low, high, {name: (1.0, 1.0)})

    m: Any = Moment()
    m.count, m.pwm = domain.rows, domain.rows / model.full_scale
    m.rate, m.heat = rate, rate * component.steady_rise(domain.rows.astype(np.int64))
    m.standstill, m.reverse = (domain.rows == 0).astype(np.float64), Span(0.0, 1.0)
    m.ambient = m.measured_ambient = Span(*domain.ambient)
    m.rise = rise(component.name)
    m.others = {name: rise(name) for name in model.component_names if name != component.name}
    m.channels = {column: Span(*ends) for column, ends in domain.channels.items()}
    moment: Moment = m
    return moment


def _share(applied: Applied, moment: Moment) -> Share:
    effect, p, own = applied.effect, applied.values, applied.component
    m: Any = moment
    m.inner = _inner(applied, m)
    heat, per_rise = Span.of(effect.heat(p, m)), Span.of(effect.per_rise(p, m))
    whole = heat + per_rise * m.rise
    none = np.zeros_like(m.rate)
    tau = effect.own_tau(p)
    if tau is not None:
        return Share(applied, (none, none), {}, {name: none + tau * _size(ends) for name, ends in heat.slopes.items()})
    # The tangent of a curved effect is in per_rise, and heat holds what it leaves: only together are they the loss.
    bent = (0.0, 0.0) if effect.nonlinear else heat.slope(own)
    ends = none + per_rise.low + bent[0], none + per_rise.high + bent[1]
    return Share(applied, ends, {name: none + _size(e) for name, e in whole.slopes.items() if name != own}, {})


def _inner(applied: Applied, m: Moment) -> Span | None:
    """Range of the inner state; it follows its target, so it answers to a rise by no more than that does."""
    found = applied.effect.inner(applied.values, m)
    if found is None:
        return None
    target, begin = Span.of(found[0]), Span.of(applied.effect.inner_start(applied.values, m.rise))
    low = np.minimum(np.min(target.low), np.min(begin.low))
    high = np.maximum(np.max(target.high), np.max(begin.high))
    return Span(low, high, {k: (np.minimum(a, 0.0), np.maximum(b, 0.0)) for k, (a, b) in target.slopes.items()})


def _size(ends: Ends) -> FloatArray:
    return np.asarray(np.maximum(np.abs(ends[0]), np.abs(ends[1])))


def steady_loops(parts: Sequence[PartGains]) -> FloatArray:
    """What comes back to each part for each K of each part's rise while the PWM is held, K, shape (R, parts, parts).

    An entry is infinite where a part's own heat grows at least as fast with its rise as its cooling does.
    """
    names = [part.component.name for part in parts]
    made = np.zeros((len(parts[0].rate), len(parts), len(parts)))
    for i, part in enumerate(parts):
        left = part.rate - part.own[1]
        for j, source in enumerate(names):
            heating = part.heating(source)
            with np.errstate(divide="ignore"):
                answered = np.where(heating > 0.0, heating / np.where(left > 0.0, left, 0.0), 0.0)
            made[:, i, j] = answered + part.apart(source)
        made[:, i, i] = np.where(left > 0.0, made[:, i, i], np.inf)
    return made


def largest_loop(matrix: FloatArray) -> float:
    """Spectral radius of a matrix of gains (no entry negative), infinite where an entry in a loop is.

    Rounded to nearest: below 1 it is certain only with :func:`contracts`.
    """
    looped = matrix * in_loops(matrix)
    if not np.all(np.isfinite(looped)):
        return float("inf")
    return float(np.abs(np.linalg.eigvals(looped)).max())


def in_loops(matrix: FloatArray) -> FloatArray:
    """Which entries lie on a closed loop (1), and which do not (0): these cannot make anything come back."""
    reached = (matrix > 0.0) | np.eye(len(matrix), dtype=bool)
    for _ in range(len(matrix)):
        reached = reached | ((reached.astype(np.int64) @ reached.astype(np.int64)) > 0)
    return np.asarray(((matrix > 0.0) & reached.T).astype(np.float64))


def contracts(matrix: FloatArray) -> bool:
    """Whether a matrix of gains is certainly below 1: by a positive vector v with ``G v < v``, row by row.

    Such a vector exists if and only if the spectral radius of the nonnegative matrix G is below 1 (Collatz and
    Wielandt; Berman and Plemmons, Nonnegative Matrices in the Mathematical Sciences, 1994, chapter 6). The margin
    covers the rounding of the few sums and of the gains.
    """
    looped = matrix * in_loops(matrix)
    if not np.all(np.isfinite(looped)):
        return False
    try:
        v = np.linalg.solve(np.eye(len(looped)) - looped, np.ones(len(looped)))
    except np.linalg.LinAlgError:
        return False
    return bool(np.all(v > 0.0) and np.all(looped @ v <= v * (1.0 - MARGIN)))


MARGIN = 1e-9
"""By so much every row of ``G v < v`` has to hold: four orders of magnitude more than float64 rounds off."""
