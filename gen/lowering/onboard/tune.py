"""Choose the last bits of a schedule's tables so that the worst coefficient comes nearest to the exact one.

At low PWM the poles are slow, and one unit of a coefficient is some 1e-9 of it.  All inputs are known, so the constants
need not be the nearest to the real ones: those that give the best results are as good.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gen.lowering.onboard.evaluate import RangeError, evaluate
from gen.lowering.onboard.tape import GUARD_BITS, OnboardComponent, Step
from gen.lowering.recursion import increments

Array = NDArray[np.float64]

_ROUNDS = 20
#: In units of an entry, for a power series quarters of a unit of its result.
_CHANGES = (-8, -6, -4, -3, -2, -1, 1, 2, 3, 4, 6, 8)


def tuned(component: OnboardComponent, exact_c: Array, weights: Array) -> OnboardComponent:
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
    least = _cost(component, domain, exact_c, weights)
    for _ in range(_ROUNDS):
        worst = [int(np.argmax(least))]
        best = component
        for candidate in _changed(component):
            # Most candidates already fail where it matters.
            if _cost(candidate, domain[worst], exact_c[worst], weights[worst])[0] < least.max():
                cost = _cost(candidate, domain, exact_c, weights)
                if cost.max() < least.max():
                    best, least = candidate, cost
        if best is component:
            break
        component = best
    return component


def _cost(component: OnboardComponent, pwm: NDArray[np.int64], exact_c: Array, weights: Array) -> Array:
    assert component.layout is not None
    try:
        rates, _ = evaluate(component, pwm)
    except RangeError:  # an entry at the end of its word
        return np.full(len(pwm), np.inf)
    board = increments.from_rates(rates * 2.0 ** -np.array(component.layout.rate_fraction_bits))
    cost: Array = (weights * np.abs(board - exact_c)).sum(axis=1)
    return cost


def _changed(component: OnboardComponent) -> Iterator[OnboardComponent]:
    """The component with one entry changed, for all changes of all entries that stem from the coefficient file."""
    for number, step in enumerate(component.steps):
        if step.op not in ("row", "power_series") and not (step.op == "constant" and step.label.path):
            continue
        unit = 1 << (GUARD_BITS - 2) if step.op == "power_series" else 1
        for place in range(len(step.table)):
            for change in _CHANGES:
                steps = list(component.steps)
                steps[number] = _with_entry(step, place, change * unit)
                yield replace(component, steps=tuple(steps))


def _with_entry(step: Step, place: int, change: int) -> Step:
    table = [int(v) for v in step.table]
    table[place] += change
    return replace(step, table=tuple(table))
