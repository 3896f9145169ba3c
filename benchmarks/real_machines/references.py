"""What a person would fit by hand, with scipy's least squares: three small models of one part, |PWM| their only input.

``one node``
    T' = k (T_room - T) + a w + b w^2.
``two rates``
    The same with a k at rest and another one while it turns.
``hidden node``
    Exchanges heat with the part both ways, at a rate of its own at rest and while it turns; both lose heat to the room,
    and both are heated.

w is |PWM| over full scale. Each run is thinned to means over at most 400 equal times and solved by the trapezoidal
rule; it starts from the part's first reading, the hidden node with it. Where nothing says the room it is one number
more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from benchmarks.real_machines.logs.case import FloatArray
from gen.runs import Run

MOST_ROWS = 400
ROBUST_K = 2.0
"""Errors beyond this count by their size and not by its square: a person would leave wild readings out."""


@dataclass(frozen=True, eq=False)
class Thin:
    """One part in one run, over equal times.

    Attributes
    ----------
    step
        Length of each, s.
    rest, speed, square
        Share at rest, mean w, mean w^2, shape (K,).
    room
        At the middle, shape (K,), degC; None where nothing says it.
    begin
        First reading, degC.
    at, reading
        Times since the first row and what was read, shape (M,) each.
    """

    step: float
    rest: FloatArray
    speed: FloatArray
    square: FloatArray
    room: FloatArray | None
    begin: float
    at: FloatArray
    reading: FloatArray


def thin(run: Run, part: str) -> Thin | None:
    """Condense a run, or None where the part is not read."""
    values = run.temps.get(part)
    good = np.isfinite(values) if values is not None else np.zeros(run.time_s.size, dtype=bool)
    if values is None or not good.any():
        return None
    time = run.time_s - run.time_s[np.argmax(good)]
    count = min(MOST_ROWS, time.size)
    edges = np.linspace(0.0, float(time[-1]), count + 1)
    level = np.abs(run.pwm) / 255.0

    def means(held: FloatArray) -> FloatArray:
        total = np.concatenate([[0.0], np.cumsum(held[:-1] * np.diff(time))])
        return np.asarray(np.diff(np.interp(edges, time, total)) / np.diff(edges))

    room: FloatArray | None = None
    if run.ambient is not None and np.isfinite(run.ambient).any():
        known = np.isfinite(run.ambient)
        room = np.interp(0.5 * (edges[1:] + edges[:-1]), time[known], run.ambient[known])
    elif "ambient_degC" in run.comments:
        room = np.full(count, float(run.comments["ambient_degC"]))
    rest = means((level == 0.0).astype(np.float64))
    first = float(values[good][0])
    return Thin(edges[1], rest, means(level), means(level**2), room, first, time[good], values[good])


Vector = Sequence[float] | FloatArray
Solve = Callable[[Thin, Vector, FloatArray], FloatArray]
"""Run, numbers and room to the part's temperature at the ends of the times, shape (K + 1,)."""


def _one_rate(run: Thin, numbers: Vector, room: FloatArray) -> FloatArray:
    rate, *heat = numbers
    return _two_rates(run, (rate, rate, *heat), room)


def _two_rates(run: Thin, numbers: Vector, room: FloatArray) -> FloatArray:
    at_rest, turning, a, b = numbers
    rate = np.exp(at_rest) * run.rest + np.exp(turning) * (1.0 - run.rest)
    into = rate * room + np.exp(a) * run.speed + np.exp(b) * run.square
    half = 0.5 * run.step * rate
    keep, gain = (1.0 - half) / (1.0 + half), run.step * into / (1.0 + half)
    shown = [run.begin]
    for k, g in zip(keep.tolist(), gain.tolist(), strict=True):
        shown.append(k * shown[-1] + g)
    return np.array(shown)


def _hidden(run: Thin, numbers: Vector, room: FloatArray) -> FloatArray:
    rest_out, turn_out, a, b, rest_over, turn_over, ratio, out, c, d = (float(np.exp(x)) for x in numbers)
    turn = 1.0 - run.rest
    loss = rest_out * run.rest + turn_out * turn
    over = rest_over * run.rest + turn_over * turn
    h = 0.5 * run.step
    # (1 + h A) T+ = (1 - h A) T + 2 h q, A = [[loss + over, -over], [-ratio over, out + ratio over]]
    p, q, r = h * (loss + over), h * over, h * ratio * over
    s = h * out + r
    whole = (1.0 + p) * (1.0 + s) - q * r
    first = 2.0 * h * (loss * room + a * run.speed + b * run.square)
    second = 2.0 * h * (out * room + c * run.speed + d * run.square)
    shown = [run.begin]
    one = two = run.begin
    for pk, qk, rk, sk, wk, fk, gk in zip(*(x.tolist() for x in (p, q, r, s, whole, first, second)), strict=True):
        left = (1.0 - pk) * one + qk * two + fk
        right = rk * one + (1.0 - sk) * two + gk
        one, two = ((1.0 + sk) * left + qk * right) / wk, ((1.0 + pk) * right + rk * left) / wk
        shown.append(one)
    return np.array(shown)


@dataclass(frozen=True, eq=False)
class Fitted:
    """One reference for one part.

    Attributes
    ----------
    solve, numbers
        The model and its logarithms.
    room
        Of the runs that do not say it, degC.
    cost
        Of the fit.
    """

    solve: Solve
    numbers: FloatArray
    room: float
    cost: float

    def predict(self, run: Run, part: str) -> FloatArray:
        """Give the part's temperature at every row of a run, shape (N,), degC."""
        made = thin(run, part)
        assert made is not None
        shown = _shown(made, self.solve, self.numbers, self.room)
        edges = np.linspace(0.0, made.step * made.speed.size, made.speed.size + 1)
        first = run.time_s[np.argmax(np.isfinite(run.temps[part]))]
        return np.asarray(np.interp(run.time_s - first, edges, shown))


def _shown(run: Thin, solve: Solve, numbers: Vector, room: float) -> FloatArray:
    around = run.room
    if around is None:
        around = np.full(run.speed.size, room)
    return solve(run, numbers, around)


def fitted(runs: Sequence[Run], part: str) -> dict[str, Fitted]:
    """Fit the three references of one part."""
    made = [one for one in (thin(run, part) for run in runs) if one is not None]
    rise = max(max(float(np.ptp(one.reading)) for one in made), 1.0)
    slow = np.log(1.0 / max(one.at[-1] for one in made))
    heat = slow + np.log(rise)
    ones = [_best(made, _one_rate, [[slow + k, heat + k, heat + k - 1.0] for k in (0.0, 1.5, 3.0)])]
    rate, a, b = ones[0].numbers
    twos = _best(made, _two_rates, [[rate, rate, a, b], [rate - 1.0, rate + 1.0, a, b]], ones[0])
    rest, turn, a, b = twos.numbers
    starts = [
        [rest, turn, a - 3.0, b - 3.0, rate + 2.0, rate + 2.0, 0.0, rate - 2.0, a + 0.7, b + 0.7],
        [rest - 1.0, turn, a, b, rate + 1.0, rate, 1.0, rate - 4.0, a, b],
        [rest, turn, a, b, rate, rate, -1.0, rate - 1.0, a - 2.0, b - 2.0],
    ]
    return {"one node": ones[0], "two rates": twos, "hidden node": _best(made, _hidden, starts, twos)}


def _best(
    runs: Sequence[Thin], solve: Solve, starts: Sequence[Sequence[float]], before: Fitted | None = None
) -> Fitted:
    level = before.room if before is not None else min(run.begin for run in runs)

    def residual(x: FloatArray) -> FloatArray:
        parts = []
        for run in runs:
            shown = _shown(run, solve, x[:-1], float(x[-1]))
            edges = np.linspace(0.0, run.step * run.speed.size, run.speed.size + 1)
            left = np.interp(run.at, edges, shown) - run.reading
            parts.append(np.clip(left, -1e4, 1e4) / np.sqrt(left.size))
        return np.concatenate(parts)

    scale = ROBUST_K / np.sqrt(np.mean([run.at.size for run in runs]))
    found = []
    for start in starts:
        low, high = np.append(np.array(start) - 9.0, -60.0), np.append(np.array(start) + 9.0, 130.0)
        one = least_squares(
            residual, np.append(start, level), bounds=(low, high), loss="soft_l1", f_scale=scale, max_nfev=60
        )
        found.append(Fitted(solve, one.x[:-1], float(one.x[-1]), float(one.cost)))
    return min(found, key=lambda one: one.cost)
