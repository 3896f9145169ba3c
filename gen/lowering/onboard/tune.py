"""Choose the last bits of a schedule's tables so that the worst coefficient comes nearest to the exact one.

At low PWM the poles are slow, and one unit of a coefficient is some 1e-9 of it.  All inputs are known, so the constants
need not be the nearest to the real ones: those that give the best results are as good.

A round has hundreds of changes to try.  All of them run side by side at the worst PWM, those that help there at the few
worst, and what is left, the most promising first, at every PWM until no other can be better.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.lowering.onboard.evaluate import RangeError, evaluate
from gen.lowering.onboard.tape import GUARD_BITS, OnboardComponent
from gen.lowering.recursion import increments

_ROUNDS = 20
#: In units of an entry, for a power series quarters of a unit of its result.
_CHANGES = (-8, -6, -4, -3, -2, -1, 1, 2, 3, 4, 6, 8)
#: At how many PWM a change has to help before all others are looked at.
_FEW = 12


@dataclass(frozen=True)
class _Change:
    """One entry of one step's table, changed by an amount."""

    step: int
    place: int
    amount: int

    def of(self, component: OnboardComponent) -> OnboardComponent:
        """The component with it."""
        steps = list(component.steps)
        table = [int(v) for v in steps[self.step].table]
        table[self.place] += self.amount
        steps[self.step] = replace(steps[self.step], table=tuple(table))
        return replace(component, steps=tuple(steps))


@dataclass(frozen=True)
class _Goal:
    """What is brought down: sum_i weights[i] abs(C[i] - exact C[i]) at each PWM of the domain."""

    lowest: int
    exact_c: FloatArray
    weights: FloatArray

    def costs(self, component: OnboardComponent, pwm: IntArray, tables: dict[int, IntArray]) -> FloatArray:
        """The sums at PWM, shape (m,), with the tables of :func:`evaluate`.

        Raises
        ------
        RangeError
            If a word overflows at any of them.
        """
        assert component.layout is not None
        rates, _ = evaluate(component, pwm, tables)
        row = pwm - self.lowest
        board = increments.from_rates(rates * 2.0 ** -np.array(component.layout.rate_fraction_bits))
        found: FloatArray = (self.weights[row] * np.abs(board - self.exact_c[row])).sum(axis=1)
        return found


def tuned(component: OnboardComponent, exact_c: FloatArray, weights: FloatArray) -> OnboardComponent:
    """The component with tables that bring max over PWM of sum_i weights[i] abs(C[i] - exact C[i]) down.

    Every round makes the one change of an entry that helps most, until none does.

    Parameters
    ----------
    component
        A fixed tape.
    exact_c
        C0..C[n-1] for each row of the domain, shape (rows, n).
    weights
        What a unit of C[i] is worth, shape (rows, n), such as the range of x[i+1] over C0.
    """
    domain = np.arange(component.domain[0], component.domain[1] + 1)
    goal = _Goal(component.domain[0], exact_c, weights)
    costs = goal.costs(component, domain, {})
    for _ in range(_ROUNDS):
        helpful = _helpful(component, goal, domain, costs)
        best: tuple[float, int] | None = None
        for least, number, change in helpful:
            if least > (best[0] if best else costs.max()):
                break
            found = _worst(change.of(component), goal, domain)
            if found < costs.max() and (best is None or (found, number) < best):
                best, chosen = (found, number), change
        if best is None:
            break
        component = chosen.of(component)
        costs = goal.costs(component, domain, {})
    return component


def _worst(component: OnboardComponent, goal: _Goal, pwm: IntArray) -> float:
    try:
        return float(goal.costs(component, pwm, {}).max())
    except RangeError:  # an entry at the end of its word
        return np.inf


def _helpful(
    component: OnboardComponent, goal: _Goal, domain: IntArray, costs: FloatArray
) -> list[tuple[float, int, _Change]]:
    """Changes that lower the largest of the costs where they are largest, in ascending order of what is left there.

    With each the largest cost that is left, and its number, so that ties have an order.
    """
    changes = _changes(component)
    most = float(costs.max())
    numbers = np.arange(len(changes))
    few = np.argsort(-costs, kind="stable")[:_FEW]
    left = np.empty(0)
    for rows in (few[:1], few):  # most changes already fail where it matters
        left = _side_by_side(component, goal, domain[rows], [changes[i] for i in numbers])
        numbers, left = numbers[left < most], left[left < most]
    order = np.lexsort((numbers, left))
    return [(float(left[i]), int(numbers[i]), changes[numbers[i]]) for i in order]


def _changes(component: OnboardComponent) -> list[_Change]:
    """All changes of all entries that stem from the coefficient file."""
    found = []
    for number, step in enumerate(component.steps):
        if step.op not in ("row", "power_series") and not (step.op == "constant" and step.label.path):
            continue
        unit = 1 << (GUARD_BITS - 2) if step.op == "power_series" else 1
        found += [_Change(number, place, change * unit) for place in range(len(step.table)) for change in _CHANGES]
    return found


def _side_by_side(component: OnboardComponent, goal: _Goal, pwm: IntArray, changes: list[_Change]) -> FloatArray:
    """The largest cost at some PWM with each change, shape (changes,); infinite where a word overflows."""
    if not changes:
        return np.empty(0)
    try:
        found = goal.costs(component, np.tile(pwm, len(changes)), _tables(component, len(pwm), changes))
    except RangeError:  # at least one of them: look for it in both halves
        if len(changes) == 1:
            return np.array([np.inf])
        middle = len(changes) // 2
        halves = [_side_by_side(component, goal, pwm, part) for part in (changes[:middle], changes[middle:])]
        return np.concatenate(halves)
    largest: FloatArray = found.reshape(len(changes), len(pwm)).max(axis=1)
    return largest


def _tables(component: OnboardComponent, each: int, changes: list[_Change]) -> dict[int, IntArray]:
    """The tables that some of the changes concern, by step: ``each`` columns with every one of the changes."""
    found: dict[int, IntArray] = {}
    for lane, change in enumerate(changes):
        if change.step not in found:
            own = np.array(component.steps[change.step].table, dtype=np.int64)
            found[change.step] = np.tile(own[:, None], len(changes) * each)
        found[change.step][change.place, lane * each : (lane + 1) * each] += change.amount
    return found
