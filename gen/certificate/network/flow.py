"""The exact solution of a network over one sample, and the two inequalities that ranges and errors follow from.

dT/dt = M T + a T_ambient + f, where M has no negative entry off its diagonal. Over a sample of h seconds T moves by

    Y1 + Y2 + ..        Y1 = h (M T + a T_ambient + f),  Yk = h M Y(k-1) / k
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from gen.certificate.exact import ROUGHLY, Floats
from gen.certificate.network.document import NetworkCertificate
from gen.certificate.network.forms import Form, Space
from gen.certificate.refuted import Refuted

#: Terms of the series that are looked at, at most.
_MOST_TERMS = 40
#: K, below which what the series leaves out does not count.
_LEAST = 1e-15
#: Relative error of a product, or a sum, of some float64: far more than it has.
_WRONG = 2.0**-46
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
    """

    target: int
    source: Source
    per_sample: Floats
    factors: tuple[int, ...]


def flows(certificate: NetworkCertificate) -> list[Flow]:
    """The equations as a sum."""
    own, h = certificate.equations, certificate.sample_time_s
    found: list[Flow] = []
    for path in own.paths:
        conductance, factors = np.array(path.conductance_W_per_K) * h, tuple(path.factors)
        first, second = path.between
        for here, there in ((first, second), (second, first)):
            if here is not None:
                source: Source = "ambient" if there is None else there
                found.append(Flow(here, source, conductance / _capacity(certificate, here), factors))
    for heat in own.heats:
        warmth, factors = np.array(heat.power_W) * h / _capacity(certificate, heat.node), tuple(heat.factors)
        found.append(Flow(heat.node, None, warmth, factors))
        if heat.per_K:
            found.append(Flow(heat.node, float(heat.reference_degC), -warmth * heat.per_K, factors))
    for place, state in enumerate(certificate.states):
        if state.lags is not None and state.time_constant_s is not None:
            found.append(Flow(place, state.lags, np.full(certificate.rows, h / state.time_constant_s), ()))
    return found


def _capacity(certificate: NetworkCertificate, place: int) -> float:
    capacity = certificate.states[place].capacity_J_per_K
    if capacity is None:
        raise Refuted("heat flows into what is no node")
    return capacity


def change(
    space: Space, states: Sequence[Form], ambient: Form, factors: Sequence[Form], own: Sequence[Flow]
) -> list[Form]:
    """What a sample changes exactly, by state, K.

    Raises
    ------
    Refuted
        If the series goes on for too long.
    """
    rates = []
    for flow in own:
        rate = space.number(flow.per_sample, np.abs(flow.per_sample) * _WRONG)
        for k in flow.factors:
            rate = rate.product(factors[k]).trimmed(_LEAST)
        rates.append(rate)
    given = {"ambient": ambient}
    term = [space.number(0.0)] * len(states)
    norm = np.zeros((len(states), space.rows))  # sums of a row's magnitudes: Yk is at most Y(k-1) times that over k
    for flow, rate in zip(own, rates, strict=True):
        made = rate
        if flow.source is not None:
            source = flow.source
            of = states[source] if isinstance(source, int) else given.get(str(source)) or space.number(float(source))
            made = rate.product(of - states[flow.target])
            norm[flow.target] += rate.largest * (2.0 if isinstance(source, int) else 1.0)
        term[flow.target] = term[flow.target] + made
    largest = norm.max(axis=0) * (1.0 + ROUGHLY)
    total = list(term)
    for k in range(2, _MOST_TERMS):
        following = _next(space, term, rates, own)
        term = [one.times(1.0 / k).within(_WRONG * one.magnitude).trimmed(_LEAST) for one in following]
        total = [(one + other).trimmed(_LEAST) for one, other in zip(total, term, strict=True)]
        worst = np.max([one.largest for one in term], axis=0)
        if np.all(worst < _LEAST) and np.all(largest < (k + 1) / 2.0):
            # What follows is at most half of what came before, again and again.
            return [one.within(2.0 * worst) for one in total]
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


@dataclass(frozen=True, eq=False)
class Row:
    """A row of h M at every |PWM|, and of h (a T_ambient + f), with the magnitudes of what they are sums of.

    Attributes
    ----------
    entries, sizes
        Shape (P, n).
    rest, size_of_rest
        Shape (P,).
    """

    entries: Floats
    sizes: Floats
    rest: Floats
    size_of_rest: Floats

    def add(self, flow: Flow, rate: Floats, ambient: float) -> None:
        """Take up a flow."""
        if flow.source is None:
            self._fixed(rate)
            return
        self.entries[:, flow.target] -= rate
        self.sizes[:, flow.target] += np.abs(rate)
        if isinstance(flow.source, int):
            self.entries[:, flow.source] += rate
            self.sizes[:, flow.source] += np.abs(rate)
        else:
            self._fixed(rate * (ambient if isinstance(flow.source, str) else flow.source))

    def _fixed(self, warmth: Floats) -> None:
        self.rest[:] += warmth
        self.size_of_rest[:] += np.abs(warmth)


class Rows:
    """All rows, at every |PWM| and every corner of the factors that a row has.

    A row is affine in each of its factors, so that what holds at the corners holds between them.

    Parameters
    ----------
    own
        The equations.
    states, rows
        How many there are of both.
    factors
        Ends of each.
    """

    def __init__(self, own: Sequence[Flow], states: int, rows: int, factors: Sequence[tuple[float, float]]) -> None:
        self._own, self._states, self._rows, self._factors = own, states, rows, factors

    def corners(self, target: int, ambient: float) -> Iterator[Row]:
        """A row at every corner."""
        own = [flow for flow in self._own if flow.target == target]
        # A factor that a product has twice counts as two: its square lies between what these make.
        used = sorted({(k, flow.factors[:i].count(k)) for flow in own for i, k in enumerate(flow.factors)})
        for ends in product(*(self._factors[k] for k, _ in used)):
            at = dict(zip(used, ends, strict=True))
            wide, long = (self._rows, self._states), self._rows
            row = Row(np.zeros(wide), np.zeros(wide), np.zeros(long), np.zeros(long))
            for flow in own:
                rate = flow.per_sample
                for i, k in enumerate(flow.factors):
                    rate = rate * at[k, flow.factors[:i].count(k)]
                row.add(flow, rate, ambient)
            yield row

    def bounds(self, ends: Floats, ambient: float, *, upper: bool) -> int:
        """Decide h M U + h (a T_ambient + f) <= 0 at every row, or >= 0 for a lower bound; how many inequalities.

        Raises
        ------
        Refuted
            Where it does not hold.
        """
        count, sign = 0, 1.0 if upper else -1.0
        for target in range(self._states):
            for row in self.corners(target, ambient):
                most = sign * (row.entries @ ends + row.rest) + _WRONG * (row.sizes @ np.abs(ends) + row.size_of_rest)
                count += most.size
                if not np.all(most <= 0.0):
                    raise Refuted(f"state {target} can leave its range {'above' if upper else 'below'}{_where(most)}")
        return count

    def holds(self, error: Floats, defect: Floats) -> int:
        """Decide -h M u exp(-h |M_ii|) >= d at every row, d of shape (P, n); how many inequalities.

        Raises
        ------
        Refuted
            Where it does not hold.
        """
        count = 0
        for target in range(self._states):
            for row in self.corners(target, 0.0):
                back = -(row.entries @ error) - _WRONG * (row.sizes @ error)
                held = back * np.exp(-row.sizes[:, target]) * (1.0 - _WRONG)
                count += held.size
                if not (np.all(back >= 0.0) and np.all(held >= defect[:, target])):
                    raise Refuted(f"the error of state {target} may grow{_where(defect[:, target] - held)}")
        return count


def _where(wrong: Floats) -> str:
    return f": by {float(wrong.max()):.4g} K a sample, row {int(np.argmax(wrong))} of the domain"
