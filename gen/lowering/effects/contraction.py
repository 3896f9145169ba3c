"""Whether a model with effects contracts: two courses with the same inputs and other starts come together.

For every sequence of PWM, channels and temperatures in their ranges. Let d be the difference of two courses, K.
Each part's heat is q = .. + k T + sum_j g_j T_j (slopes of :mod:`gen.model.effects.gains`, with k and g_j anywhere in
their ranges at each instant), and it passes the part's own poles, so what remains of the others' differences is at most

    limsup |d_i| <= sum_j G_ij limsup |d_j|,

where G_ij is the largest answer of the part *with its own feedback k* to a disturbance of at most g_j: for order 1
``g_j / (rate - k)``; for higher orders the extent of an invariant polytope (:mod:`gen.lowering.recursion.reach`).
With G v < v for some positive v every difference fades (:func:`gen.model.effects.gains.contracts`).

The polytope is that of Euler steps, I + h A for the ends of k's range at every PWM. It holds for the differential
equation: I + h A is affine in k, so it holds for all between; and exp(A t) = exp(-t/h) sum_n (t/h)^n (I + h A)^n / n!
is a mean of its powers, and so it is for every h.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.recursion.guarantee import rounded_up
from gen.lowering.recursion.no_proof import NoProofError
from gen.lowering.recursion.reach import SwitchedRecursion
from gen.model import ThermalModel
from gen.model.effects import Applied
from gen.model.effects.gains import Domain, PartGains, contracts, gains, in_loops, largest_loop, steady_loops
from gen.model.effects.runaway import Runaway, runaway_of

FASTEST = 1.0
"""Largest magnitude of a part's poles with its own feedback, times the sample time: from twice as much on the board's
trial of a sample would swing up where the differential equation fades."""
_EULER = 2e-3
"""Largest magnitude of such a pole times the Euler step of the polytope: longer steps leave a direction's facets."""


@dataclass(frozen=True)
class Contraction:
    """What is known of a model with effects.

    Parameters
    ----------
    loop_gain
        What comes back of each kelvin at most by all loops between parts, below 1; where `unproven` names any, while
        the PWM is held.
    unproven
        Components that settle at each PWM held, as all others do, and of which that is not proven while it changes:
        of higher order than 1, with cooling that follows their own rise, or in a loop with such a part.
    """

    loop_gain: float
    unproven: tuple[str, ...]

    def describe(self) -> dict[str, Any]:
        """For the manifest, rounded up."""
        return {"loop_gain": rounded_up(self.loop_gain), "unproven": list(self.unproven)}


def contraction(model: ThermalModel, effects: Sequence[Applied], domain: Domain) -> Contraction | Runaway:
    """Prove that a model with effects contracts, or say what hinders it.

    Parameters
    ----------
    model, effects
        The model, with what can be folded into it already there, and the other effects.
    domain
        Ranges of all that they read.

    Raises
    ------
    TypeError
        If an equation is not made of ``+ - *``, whole powers and divisions by numbers.
    """
    parts = gains(model, effects, domain)
    found = runaway_of(parts, domain)
    if found is not None:
        return found
    names = model.component_names
    open_loops = np.array([[float(np.max(p.heating(name) + p.apart(name))) for name in names] for p in parts])
    looped = in_loops(open_loops) > 0.0
    matrix = np.zeros_like(open_loops)
    unproven = []
    for i, part in enumerate(parts):
        if not looped[i].any() and not np.any(part.own):
            continue
        made = _of_part(part, domain, model.sample_time, [name for j, name in enumerate(names) if looped[i, j]])
        if isinstance(made, Runaway):
            return made
        matrix[i, looped[i]], known = made
        unproven += [] if known else [part.component.name]
    proven = not unproven and contracts(matrix)
    if not contracts(matrix):  # each settles by itself, and at each PWM held all do: only their switching is open
        unproven += [name for name, row in zip(names, matrix, strict=True) if row.any() and name not in unproven]
    steady = max(largest_loop(loops) for loops in steady_loops(parts))
    return Contraction(largest_loop(matrix) if proven else steady, tuple(unproven))


def _of_part(
    part: PartGains, domain: Domain, sample_time: float, sources: Sequence[str]
) -> tuple[list[float], bool] | Runaway:
    """What a part answers to a kelvin of each source, and whether that holds for every switching; or what ends it."""
    hindered = _hindered(part, domain, sample_time)
    if hindered is not None:
        return hindered
    answers = _answers(part, domain.rows, sources)
    proven = answers is not None
    if answers is None:
        if not _heating_alone(part, domain.rows):
            return _not_shown(part)
        answers = [float(np.max(part.heating(name) / (part.rate - part.own[1]))) for name in sources]
    apart = [float(np.max(part.apart(name))) for name in sources]
    return [answer + more for answer, more in zip(answers, apart, strict=True)], proven


def _closed(part: PartGains, rows: FloatArray, slope: FloatArray) -> FloatArray:
    """Companion matrices of a part with own feedback, shape (R, n, n)."""
    component, counts = part.component, rows.astype(np.int64)
    matrices, _ = component.state_matrices(counts)
    matrices[:, -1, 0] += component.denominator(counts)[:, -2] * slope
    return matrices


def _hindered(part: PartGains, domain: Domain, sample_time: float) -> Runaway | None:
    """What ends it at some |PWM| held: feedback that comes too late, or is too fast for the sample time."""
    name = part.component.name
    for slope in part.own:
        poles = np.linalg.eigvals(_closed(part, domain.rows, slope))
        growth, speed = poles.real.max(axis=1), np.abs(poles).max(axis=1)
        at = int(np.argmax(growth))
        if growth[at] >= 0.0:
            return Runaway(
                _strongest(part),
                f'"{name}", of order {part.component.order}, swings up at PWM {domain.rows[at]:.0f}: its heat answers '
                f"to its own rise by {abs(slope[at] / part.rate[at]):.3g} times its own rate; expected less, or a "
                "narrower range of the channel in $.wiring.channels",
            )
        at = int(np.argmax(speed))
        if speed[at] * sample_time > FASTEST:
            return Runaway(
                _strongest(part),
                f'"{name}" follows with {speed[at]:.3g} 1/s at PWM {domain.rows[at]:.0f}; expected at most '
                f"{FASTEST / sample_time:.3g} 1/s at a sample time of {sample_time:g} s, or a narrower range of the "
                "channel in $.wiring.channels",
            )
    return None


def _answers(part: PartGains, rows: FloatArray, sources: Sequence[str]) -> list[float] | None:
    """Largest answer to a kelvin of each source's rise, without states apart; None without a proof."""
    low, high = part.own
    drives = [part.heating(name) for name in sources]
    if part.component.order == 1:
        return [float(np.max(drive / (part.rate - high))) for drive in drives]
    try:
        return _enclosed(part, rows, (low, high), drives)
    except NoProofError:
        return None


def _heating_alone(part: PartGains, rows: FloatArray) -> bool:
    """Whether what heats more with the own rise leaves a proof; where nothing does, there is nothing to prove."""
    low, high = (np.maximum(end, 0.0) for end in part.own)
    if not high.any():
        return True
    try:
        _enclosed(part, rows, (low, high), [])
    except NoProofError:
        return False
    return True


_known: dict[tuple[bytes, ...], list[float] | None] = {}


def _enclosed(
    part: PartGains, rows: FloatArray, own: tuple[FloatArray, FloatArray], drives: Sequence[FloatArray]
) -> list[float]:
    """Largest answer to a disturbance of at most each of these drives (K/s), in K.

    Raises
    ------
    NoProofError
        If no invariant polytope is found.
    """
    ends = [_closed(part, rows, slope) for slope in (own if np.any(own[0] != own[1]) else own[:1])]
    matrices = np.concatenate(ends)
    key = tuple(array.tobytes() for array in (matrices, *drives))
    if key not in _known:
        _known[key] = _extents(part, rows, matrices, drives)
    known = _known[key]
    if known is None:
        raise NoProofError(part.component.name)
    return known


def _extents(
    part: PartGains, rows: FloatArray, matrices: FloatArray, drives: Sequence[FloatArray]
) -> list[float] | None:
    n = part.component.order
    step = _EULER / float(np.abs(np.linalg.eigvals(matrices)).max())
    scale = step ** np.arange(n)  # the state is (T, h T', h^2 T'', ..)
    euler = np.eye(n) + step * matrices * scale[:, None] / scale[None, :]
    force = part.component.denominator(rows.astype(np.int64))[:, -2] * step**n
    found = []
    try:
        recursion = SwitchedRecursion(euler)
        for drive in drives or [part.rate]:  # without a source: only whether there is a polytope at all
            disturbance = np.zeros((len(matrices), 1, n))
            disturbance[:, 0, -1] = np.tile(force * drive, len(matrices) // len(rows))
            found.append(recursion.bound(disturbance).extent(np.eye(n)[0]))
    except NoProofError:
        return None
    return found if drives else []


def _strongest(part: PartGains) -> Applied:
    return max(part.shares, key=lambda share: float(np.max(np.abs(share.own)))).applied


def _not_shown(part: PartGains) -> Runaway:
    grown = float(np.max(part.own[1] / part.rate))
    return Runaway(
        max(part.shares, key=lambda share: float(np.max(share.own[1]))).applied,
        f'for each kelvin of its rise "{part.component.name}", of order {part.component.order}, is heated by up to '
        f"{grown:.3g} times as much as carries it off, and cannot be shown to settle while the PWM changes; expected "
        "less",
    )
