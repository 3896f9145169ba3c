"""Choose the last bits of the exponentials' tables so that the worst coefficient comes nearest to the exact one.

At low PWM the poles are slow, and one unit of a table is some 1e-9 of a coefficient.  All inputs are known, so the
constants need not be the nearest to the real ones: those that give the best results are as good.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gen.lowering import increments
from gen.lowering.onboard.tape import OnboardComponent, Step, steady_excess
from gen.reference.onboard import evaluate

Array = NDArray[np.float64]

#: Number of a step, place in its table, and by how many units.
Change = tuple[int, int, int]

_ROUNDS = 60
_GAIN_CHANGES = (0, -1, 1, -2, 2)
_CHANGES = (-8, -6, -4, -3, -2, -1, 1, 2, 3, 4, 6, 8)


def tuned(component: OnboardComponent, exact_c: Array, weights: Array, exact_steady: Array) -> OnboardComponent:
    """The component with tables that minimise max over PWM of sum_i weights[i] abs(C[i] - exact C[i]).

    Parameters
    ----------
    component
        A fixed tape.
    exact_c
        C0..C[n-1] for each row of the domain, shape (rows, n).
    weights
        What a unit of C[i] is worth, shape (rows, n), such as the range of x[i+1] over C0.
    exact_steady
        S in K, shape (rows,).
    """
    domain = np.arange(component.domain[0], component.domain[1] + 1)
    cost = _cost(component, domain, exact_c, weights)
    for _ in range(_ROUNDS):
        worst = int(np.argmax(cost))
        best: tuple[float, OnboardComponent, NDArray[np.int64], Array] | None = None
        single = [((change,), touched) for change, touched in _changes(component, int(domain[worst]))]
        for changes, touched in [*single, *_pairs(single)]:
            if best is not None and len(changes) > 1:
                break  # two changes at once only where one does not help
            steps = _changed(component, changes)
            rows = np.flatnonzero(touched[domain])
            candidate = replace(component, steps=steps)
            changed = _cost(candidate, domain[rows], exact_c[rows], weights[rows])
            if changed.max() < cost[worst] and (best is None or changed.max() < best[0]):
                best = (float(changed.max()), candidate, rows, changed)
        if best is None:
            break
        component = best[1]
        cost[best[2]] = best[3]
    return _tuned_gain(component, domain, exact_steady)


def _tuned_gain(component: OnboardComponent, domain: NDArray[np.int64], exact: Array) -> OnboardComponent:
    """The component with the gain's polynomial such that S stays nearest to its floor."""
    assert component.layout is not None
    places = [i for i, s in enumerate(component.steps) if s.op == "constant" and ".gain.poly" in s.label.path]
    best, least = component, np.inf
    for moves in itertools.product(_GAIN_CHANGES, repeat=min(len(places), 3)):
        changes = tuple((place, 0, move) for place, move in zip(places, moves, strict=False) if move)
        candidate = replace(component, steps=_changed(component, changes))
        excess = float(steady_excess(evaluate(candidate, domain)[1], exact, component.layout).max())
        if (excess, sum(map(abs, moves))) < (least, np.inf):
            best, least = candidate, excess
    return best


def _cost(component: OnboardComponent, pwm: NDArray[np.int64], exact_c: Array, weights: Array) -> Array:
    assert component.layout is not None
    rates, _ = evaluate(component, pwm)
    board = increments.from_rates(rates * 2.0 ** -np.array(component.layout.rate_fraction_bits))
    cost: Array = (weights * np.abs(board - exact_c)).sum(axis=1)
    return cost


def _changes(component: OnboardComponent, pwm: int) -> Iterator[tuple[Change, NDArray[np.bool_]]]:
    """Changes of one entry that matters at a PWM, and which inputs it matters at."""
    inputs = np.arange(256)
    for number, step in enumerate(component.steps):
        if step.op not in ("row", "exponential"):
            continue
        source = component.steps[step.args[0]]
        held = source if source.op == "input" else component.steps[source.args[0]]
        if held.op != "input":
            continue
        x = np.clip(inputs, int(held.table[0]), int(held.table[1]))
        here = int(x[pwm])
        if source.op == "segment":
            segments = np.clip(np.searchsorted(source.table, x, side="right") - 1, 0, len(source.table) - 2)
            place, touched = int(segments[pwm]), segments == segments[pwm]
        elif step.op == "row":
            place, touched = here >> 4, (x >> 4) == (here >> 4)
        else:
            place, touched = 16 + (here & 15), (x & 15) == (here & 15)
        for change in _CHANGES:
            yield (number, place, change), touched


def _pairs(
    single: Sequence[tuple[tuple[Change, ...], NDArray[np.bool_]]],
) -> Iterator[tuple[tuple[Change, ...], NDArray[np.bool_]]]:
    for (left, left_touched), (right, right_touched) in itertools.combinations(single, 2):
        if left[0][0] != right[0][0]:
            yield (*left, *right), left_touched | right_touched


def _changed(component: OnboardComponent, changes: tuple[Change, ...]) -> tuple[Step, ...]:
    steps = list(component.steps)
    for number, place, change in changes:
        table = [int(v) for v in steps[number].table]
        table[place] += change
        steps[number] = replace(steps[number], table=tuple(table))
    return tuple(steps)
