"""The exact solution of a network over one sample.

dT/dt = M T + a T_ambient + f, where M has no negative entry off its diagonal. Over a sample of h seconds T moves by

    Y1 + Y2 + ..        Y1 = h (M T + a T_ambient + f),  Yk = h M Y(k-1) / k

Where paths have laws, Y1 has what these make of both temperatures, M in what follows is the derivative J at the
sample's beginning, and what the heat bends by meanwhile is enclosed (:func:`bending`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.exact import ROUGHLY
from gen.certificate.network.document import NetworkCertificate
from gen.certificate.network.forms import Form, Space
from gen.certificate.network.laws import Law, laws
from gen.certificate.refuted import Refuted

#: Terms of the series that are looked at, at most.
_MOST_TERMS = 40
#: K, below which what the series leaves out does not count.
_LEAST = 1e-15
#: Relative error of a product, or a sum, of some float64: far more than it has.
WRONG = 2.0**-46
#: What a flow comes from: a state, the ambient, a fixed temperature in degC, or nothing that has a temperature.
Source = int | float | str | None


@dataclass(frozen=True, eq=False)
class Flow:
    """A part of the equations: ``dT_target/dt = rate (source - T_target)``, or ``= rate`` for heat alone.

    Attributes
    ----------
    target
        A state.
    source
        See :data:`Source`; the ambient is "ambient".
    per_sample
        The rate times h by |PWM|, every factor 1, to within 2^-46 of itself. Never negative between two states.
    factors
        All multiply it.
    law
        What stands in the place of source - T_target, and whose slope multiplies what follows.
    place
        Of the law among all laws: its slope counts as a factor behind the factors.
    """

    target: int
    source: Source
    per_sample: FloatArray
    factors: tuple[int, ...]
    law: Law | None = None
    place: int = -1

    def later(self, factors: int) -> tuple[int, ...]:
        """What multiplies it in M, where there are so many factors."""
        return self.factors if self.law is None else (*self.factors, factors + self.place)

    def driving(self, law: Law, at: FloatArray, ambient: float) -> tuple[float, float]:
        """What its law makes of temperatures in degC, K, and a magnitude that its error is a share of."""
        there = float(at[self.source]) if isinstance(self.source, int) else ambient
        return law.driving(there, float(at[self.target]))


def flows(certificate: NetworkCertificate) -> list[Flow]:
    """The equations as a sum."""
    own, h = certificate.equations, certificate.sample_time_s
    found: list[Flow] = []
    known = {law.path: (place, law) for place, law in enumerate(laws(certificate))}
    for number, path in enumerate(own.paths):
        if path.has_law and number not in known:
            continue  # it carries nothing
        place, law = known.get(number, (-1, None))
        conductance, factors = np.array(path.conductance_W_per_K) * h * path.scale, tuple(path.factors)
        first, second = path.between
        for here, there in ((first, second), (second, first)):
            if here is not None:
                source: Source = "ambient" if there is None else there
                found.append(Flow(here, source, conductance / _capacity(certificate, here), factors, law, place))
    for heat in own.heats:
        warmth, factors = np.array(heat.power_W) * h / _capacity(certificate, heat.node), tuple(heat.factors)
        found.append(Flow(heat.node, None, warmth, factors))
        if heat.per_K:
            found.append(Flow(heat.node, float(heat.reference_degC), -warmth * heat.per_K, factors))
    for place, state in enumerate(certificate.states):
        if state.lags is not None and state.time_constant_s is not None:
            found.append(Flow(place, state.lags, np.full(certificate.rows, h / state.time_constant_s), ()))
        if state.drifts_to_K is not None and state.time_constant_s is not None:
            found.append(Flow(place, state.drifts_to_K, np.full(certificate.rows, h / state.time_constant_s), ()))
    return found


def _capacity(certificate: NetworkCertificate, place: int) -> float:
    capacity = certificate.states[place].capacity_J_per_K
    if capacity is None:
        raise Refuted("heat flows into what is no node")
    return capacity


def change(
    space: Space,
    states: Sequence[Form],
    ambient: Form,
    factors: Sequence[Form],
    own: Sequence[Flow],
    driving: Sequence[Form] = (),
    bent: Bent | None = None,
) -> list[Form]:
    """What a sample changes exactly, by state, K.

    Parameters
    ----------
    space
        Of all forms.
    states, ambient
        Temperatures, degC.
    factors
        And behind them the slopes of all laws.
    own
        The equations.
    driving
        Of each law: what drives heat from its first end.
    bent
        What the laws differ by from lines.

    Raises
    ------
    Refuted
        If the series goes on for too long.
    """
    firsts, rates = [], []
    count = len(factors) - len(driving)
    for flow in own:
        rate = space.number(flow.per_sample, np.abs(flow.per_sample) * WRONG)
        for k in flow.factors:
            rate = rate.product(factors[k]).trimmed(_LEAST)
        firsts.append(rate)
        rates.append(rate if flow.law is None else rate.product(factors[count + flow.place]).trimmed(_LEAST))
    given = {"ambient": ambient}
    term = [space.number(0.0)] * len(states)
    norm = np.zeros((len(states), space.rows))  # sums of a row's magnitudes: Yk is at most Y(k-1) times that over k
    for flow, first, rate in zip(own, firsts, rates, strict=True):
        made = first
        if flow.source is not None:
            source = flow.source
            if flow.law is not None:
                made = first.product(driving[flow.place].times(-1.0 if flow.target == flow.law.first else 1.0))
            else:
                of = (
                    states[source] if isinstance(source, int) else given.get(str(source)) or space.number(float(source))
                )
                made = first.product(of - states[flow.target])
            norm[flow.target] += rate.largest * (2.0 if isinstance(source, int) else 1.0)
        term[flow.target] = term[flow.target] + made
    more = [np.zeros(space.rows)] * len(states) if bent is None else bending(bent, firsts, rates, own)
    largest = norm.max(axis=0) * (1.0 + ROUGHLY)
    total = list(term)
    for k in range(2, _MOST_TERMS):
        following = _next(space, term, rates, own)
        term = [one.times(1.0 / k).within(WRONG * one.magnitude).trimmed(_LEAST) for one in following]
        total = [(one + other).trimmed(_LEAST) for one, other in zip(total, term, strict=True)]
        worst = np.max([one.largest for one in term], axis=0)
        if np.all(worst < _LEAST) and np.all(largest < (k + 1) / 2.0):
            # What follows is at most half of what came before, again and again.
            return [one.within(2.0 * worst + off) for one, off in zip(total, more, strict=True)]
    raise Refuted("the paths are too fast for the sample time")


@dataclass(frozen=True, eq=False)
class Bent:
    """How far laws are no lines.

    Attributes
    ----------
    speeds
        How much each state changes in a sample at most, wherever the states are, K, shape (P, n).
    steepest
        A bound of each law's slope's own slope, 1/K.
    """

    speeds: FloatArray
    steepest: Sequence[float]


def bending(bent: Bent, firsts: Sequence[Form], rates: Sequence[Form], own: Sequence[Flow]) -> list[FloatArray]:
    """What a sample differs by from the series, by state, K: heat that bends between its beginning and its end.

    After a share s of the sample both ends of a path have moved by s times their speeds at most, and its heat by no
    more than half its largest second derivative times that squared from a line. The integral of s^2 / 2 is a sixth.
    exp((1 - s) J) hands that on: the integral of s^2 / 2 (1 - s)^k / k! is 1 / (k + 3)!, so that each further power of
    |J| counts as one over k + 3 of the one before.

    Raises
    ------
    Refuted
        If what is handed on does not fade.
    """
    none = [np.zeros(len(bent.speeds)) for _ in bent.speeds.T]
    term = list(none)
    for flow, first in zip(own, firsts, strict=True):
        if flow.law is not None:
            moved = bent.speeds[:, flow.target] + (bent.speeds[:, flow.source] if isinstance(flow.source, int) else 0.0)
            term[flow.target] = term[flow.target] + first.largest * (bent.steepest[flow.place] / 6.0) * moved**2
    total = list(term)
    for k in range(1, _MOST_TERMS):
        following = list(none)
        for flow, rate in zip(own, rates, strict=True):
            if flow.source is not None:
                beside = term[flow.source] if isinstance(flow.source, int) else 0.0
                following[flow.target] = following[flow.target] + rate.largest * (term[flow.target] + beside)
        before, term = term, [one / (k + 3) for one in following]
        total = [one + more for one, more in zip(total, term, strict=True)]
        worst, was = (np.max(several, axis=0) for several in (term, before))
        # Largest terms fall by a factor of which the next one is smaller still.
        if np.all(worst <= was / 2.0) and np.all(worst < _LEAST):
            return [(one + 2.0 * worst) * (1.0 + ROUGHLY) for one in total]
    raise Refuted("the paths are too fast for the sample time")


def _next(space: Space, term: Sequence[Form], rates: Sequence[Form], own: Sequence[Flow]) -> list[Form]:
    """h M y."""
    following = [space.number(0.0)] * len(term)
    for flow, rate in zip(own, rates, strict=True):
        if flow.source is not None:
            less = term[flow.target]
            beside = term[flow.source] - less if isinstance(flow.source, int) else less.times(-1.0)
            following[flow.target] = following[flow.target] + rate.product(beside)
    return following
