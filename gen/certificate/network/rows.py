"""The two inequalities that a network's ranges and errors follow from: rows of h M at every |PWM| and every corner.

dT/dt = M T + a T_ambient + f, where M has no negative entry off its diagonal; where paths have laws, what these make of
temperatures stands for ranges, and their slopes count in M for errors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.network.flow import WRONG, Flow
from gen.certificate.network.laws import Law
from gen.certificate.refuted import Refuted

#: What a law makes of temperatures, K, and a magnitude that its error is a share of.
Driving = Callable[[Flow, Law], tuple[float, float]]


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

    entries: FloatArray
    sizes: FloatArray
    rest: FloatArray
    size_of_rest: FloatArray

    def add(self, flow: Flow, rate: FloatArray, ambient: float) -> None:
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

    def drive(self, rate: FloatArray, value: float, size: float) -> None:
        """Take up what a law makes of temperatures that are known."""
        self.rest[:] += rate * value
        self.size_of_rest[:] += np.abs(rate) * size

    def _fixed(self, warmth: FloatArray) -> None:
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
        Ends of each, and behind them of the slopes of all laws.
    """

    def __init__(self, own: Sequence[Flow], states: int, rows: int, factors: Sequence[tuple[float, float]]) -> None:
        self._own, self._states, self._rows, self._factors = own, states, rows, factors
        self._laws = len({flow.place for flow in own if flow.law is not None})

    def corners(self, target: int, ambient: float, driving: Driving | None = None) -> Iterator[Row]:
        """A row at every corner.

        Parameters
        ----------
        target, ambient
            Which row, and degC.
        driving
            What laws make of temperatures that are known; None: their slopes count, as of what errors obey.
        """
        own = [(flow, self._multiplied(flow, slopes=driving is None)) for flow in self._own if flow.target == target]
        # A factor that a product has twice counts as two: its square lies between what these make.
        used = sorted({(k, factors[:i].count(k)) for _, factors in own for i, k in enumerate(factors)})
        for ends in product(*(self._factors[k] for k, _ in used)):
            here = dict(zip(used, ends, strict=True))
            wide, long = (self._rows, self._states), self._rows
            row = Row(np.zeros(wide), np.zeros(wide), np.zeros(long), np.zeros(long))
            for flow, factors in own:
                rate = flow.per_sample
                for i, k in enumerate(factors):
                    rate = rate * here[k, factors[:i].count(k)]
                if flow.law is not None and driving is not None:
                    row.drive(rate, *driving(flow, flow.law))
                else:
                    row.add(flow, rate, ambient)
            yield row

    def _multiplied(self, flow: Flow, *, slopes: bool) -> tuple[int, ...]:
        return flow.later(len(self._factors) - self._laws) if slopes else flow.factors

    def speeds(
        self, box: FloatArray, ambient: tuple[float, float], driving: Sequence[tuple[float, float]]
    ) -> FloatArray:
        """How much each state changes in a sample at most, K, shape (P, n).

        Parameters
        ----------
        box
            Ends of the states, degC, shape (n, 2).
        ambient
            Its ends, degC.
        driving
            Ends of what each law makes of both ends of its path, K.
        """
        found = np.zeros((self._rows, self._states))

        def of(upper: bool, flow: Flow, law: Law) -> tuple[float, float]:
            low, high = driving[flow.place]
            low, high = (-high, -low) if flow.target == law.first else (low, high)
            return (high, abs(high)) if upper else (low, abs(low))

        for target in range(self._states):
            for upper in (False, True):
                sign = 1.0 if upper else -1.0
                for row in self.corners(target, ambient[int(upper)], partial(of, upper)):
                    ends = np.maximum(sign * row.entries * box[:, 0], sign * row.entries * box[:, 1]).sum(axis=1)
                    sizes = row.sizes @ np.abs(box).max(axis=1) + row.size_of_rest
                    found[:, target] = np.maximum(found[:, target], ends + sign * row.rest + WRONG * sizes)
        return found

    def bounds(self, ends: FloatArray, ambient: float, *, upper: bool) -> int:
        """Decide h M U + h (a T_ambient + f) <= 0 at every row, or >= 0 for a lower bound; how many inequalities.

        Raises
        ------
        Refuted
            Where it does not hold.
        """
        count, sign = 0, 1.0 if upper else -1.0
        for target in range(self._states):
            for row in self.corners(target, ambient, lambda flow, law: flow.driving(law, ends, ambient)):
                most = sign * (row.entries @ ends + row.rest) + WRONG * (row.sizes @ np.abs(ends) + row.size_of_rest)
                count += most.size
                if not np.all(most <= 0.0):
                    raise Refuted(f"state {target} can leave its range {'above' if upper else 'below'}{_where(most)}")
        return count

    def holds(self, error: FloatArray, defect: FloatArray) -> int:
        """Decide -h M u exp(-h |M_ii|) >= d at every row, d of shape (P, n); how many inequalities.

        Raises
        ------
        Refuted
            Where it does not hold.
        """
        count = 0
        for target in range(self._states):
            # The slope of a law may change within a sample: then the fastest of all corners counts for each.
            bends = any(flow.law is not None for flow in self._own if flow.target == target)
            fastest = np.max([row.sizes[:, target] for row in self.corners(target, 0.0)], axis=0) if bends else None
            for row in self.corners(target, 0.0):
                back = -(row.entries @ error) - WRONG * (row.sizes @ error)
                held = back * np.exp(-(row.sizes[:, target] if fastest is None else fastest)) * (1.0 - WRONG)
                count += held.size
                if not (np.all(back >= 0.0) and np.all(held >= defect[:, target])):
                    raise Refuted(f"the error of state {target} may grow{_where(defect[:, target] - held)}")
        return count


def _where(wrong: FloatArray) -> str:
    return f": by {float(wrong.max()):.4g} K a sample, row {int(np.argmax(wrong))} of the domain"
