"""Lower a component to the fast fixed-point form: formats, integers, and the proof of ranges and error.

Order 2 and more run the increment form at every sample like the usual lowering, with shorter words and products.
First order is exact over any number of samples while PWM is constant, so such components take turns: one product
for :data:`gen.lowering.fast_format.BLOCK` samples (:mod:`gen.lowering.fast_block`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.lowering import bounds, fast_block, increments
from gen.lowering.bounds import Array, StateRanges
from gen.lowering.dynamics import Dynamics, LoweringError, dynamics
from gen.lowering.fast_format import (
    LARGEST_GAP,
    MARGIN,
    NARROW_LOSS,
    RESIDUE_BITS,
    SMALLEST_GAP,
    FastComponent,
    FastLayout,
    choose_scale,
    fast_loss,
)
from gen.lowering.program import Integers, Proof
from gen.lowering.reach import NoProofError, SwitchedRecursion
from gen.model import Component, ThermalModel


@dataclass(frozen=True)
class Rounding:
    """What one evaluation of q loses at each PWM.

    Attributes
    ----------
    middle, half
        In K of q, shape (rows,): q lies within ``half`` of its exact value plus ``middle``.
    """

    middle: Array
    half: Array


def lower_component(model: ThermalModel, component: Component, slot: int, limit_K: float) -> FastComponent:
    """Find formats, integers and proof for one component.

    Parameters
    ----------
    model, component
        What to lower.
    slot
        The turn of a first-order component.
    limit_K
        The error bound to aim for: the faster 24-bit difference x1 - S is used where it holds with it.

    Raises
    ------
    LoweringError
        If ranges or error cannot be proven, or the poles do not suit the formats; the message names the component.
    """
    exact = dynamics(model, component, 1)
    try:
        if component.order == 1:
            return fast_block.lower(component.name, exact, slot)
        return _lower(component.name, exact, limit_K)
    except NoProofError as error:
        raise LoweringError(f"component {component.name}: no fast form, its range cannot be proven ({error})") from None


def _lower(name: str, exact: Dynamics, limit_K: float) -> FastComponent:
    recursion = SwitchedRecursion(exact.exact)
    ranges = bounds.state_ranges(recursion, exact)
    narrow = choose(name, inner_ranges(recursion, exact, ranges), exact.rates.max(axis=0))
    lowered = _with_layout(name, exact, recursion, ranges, narrow)
    if lowered.proof.bound_K > limit_K:
        lowered = _with_layout(name, exact, recursion, ranges, replace(narrow, narrow=False))
    return lowered


def _with_layout(
    name: str, exact: Dynamics, recursion: SwitchedRecursion, ranges: StateRanges, layout: FastLayout
) -> FastComponent:
    rates = tabulate_rates(exact, layout)
    lost = rounding(exact, layout)
    # What is lost on average acts like a wrong steady rise: q = -C0 (x1 - S).
    steady = np.rint((exact.steady - lost.middle / exact.c[:, 0]) / layout.steady_lsb).astype(np.int64)
    integer_rates = rates * 2.0 ** -np.array(layout.rate_bits, dtype=np.float64)
    error = bounds.worst_error(
        recursion,
        exact,
        ranges,
        changed_c=increments.from_rates(integer_rates) - exact.c,
        q_error=_around_steady(lost, steady, exact, layout),
        chain_error=np.tile(_chain_error(layout), (len(steady), 1)),
        start_error=layout.high_lsb[0],
    )
    if error is None:
        raise LoweringError(f"component {name}: no fast form, its rounding error is too large for its ranges")
    return FastComponent(
        name=name,
        order=exact.order,
        layout=layout,
        rates=rates,
        steady=steady,
        slot=0,
        start_range_mK=exact.start_range_mK,
        proof=Proof(
            rise_range_K=ranges.rise,
            increment_range_K=tuple(float(v) for v in ranges.magnitude[1:]),
            bound_K=error + layout.high_lsb[0],
        ),
    )


def _around_steady(lost: Rounding, steady: Integers, exact: Dynamics, layout: FastLayout) -> Array:
    """Bound on q's error, shape (rows,), once S is rounded: what is lost around its middle, and S's own rounding."""
    shift = steady * layout.steady_lsb - exact.steady + lost.middle / exact.c[:, 0]
    return np.asarray(lost.half + exact.c[:, 0] * np.abs(shift), dtype=np.float64)


def inner_ranges(recursion: SwitchedRecursion, exact: Dynamics, ranges: StateRanges) -> Array:
    """Largest magnitude of each number that is multiplied or added to, in K, shape (n,).

    These are x1 and x1 - S, then x[i+1] and x[i+1] + R[i-1] (x[i] + ..), bounded over the reachable polytope together
    rather than term by term.
    """
    n = exact.order
    towards = (np.eye(n) - exact.exact)[:, :, 0] * (exact.steady - exact.centre)[:, None]
    start = np.zeros((1, n))
    start[0, 0] = max(exact.start[1] - exact.centre, exact.centre - exact.start[0])
    reach = recursion.bound(towards[:, None, :], start)
    state_maps = increments.state_map(exact.c)
    result = []
    for i in range(n):
        weights = np.zeros((len(exact.c), n))
        weights[:, i] = 1.0
        for j in range(i - 1, -1, -1):
            weights[:, j] = weights[:, j + 1] * exact.rates[:, j]
        along = np.einsum("pi,pij->pj", weights, state_maps)
        extent = np.array([reach.extent(direction) for direction in along])
        largest = float((extent + np.abs(along[:, 0] * (exact.steady - exact.centre))).max())
        result.append(max(largest, float(ranges.magnitude[i])))
    # What joins x2 on its way to x1 (orders 2 and 4).
    if n == 2:
        result[1] = max(result[1], float(ranges.magnitude[1]) + 0.5 * float((exact.rates[:, 1] * result[1]).max()))
    elif n == 4:
        result[1] = max(result[1], float(ranges.magnitude[1] + 0.5 * ranges.magnitude[2]))
    return np.array(result) * (1.0 + 2e-3)


def choose(name: str, ranges: Array, rate_maxima: Array) -> FastLayout:
    """Formats that fill the words.

    Raises
    ------
    LoweringError
        If a rate leaves no gap between :data:`SMALLEST_GAP` and :data:`LARGEST_GAP`.
    """
    scale = choose_scale(float(ranges[0]))
    lsb = scale[0] * 2.0 ** -scale[1] / 1000.0
    gaps = []
    for i, largest in enumerate(rate_maxima[:-1]):
        gap = min(LARGEST_GAP, int(np.floor(-np.log2(largest * (1.0 + 1e-6)))))
        while gap >= SMALLEST_GAP and ranges[i + 1] > (2.0**31 - MARGIN) * lsb * 2.0**-gap:
            gap -= 1
        if gap < SMALLEST_GAP:
            raise LoweringError(f"component {name}: no fast form, R{i} = {largest:.1e} is too fast for its formats")
        gaps.append(gap)
        lsb *= 2.0**-gap
    shift = max(0, RESIDUE_BITS - int(np.floor(-np.log2(rate_maxima[-1] * (1.0 + 1e-6)))))
    if shift > (0 if len(rate_maxima) == 2 else RESIDUE_BITS):
        raise LoweringError(f"component {name}: no fast form, its fastest rate is too fast for its formats")
    return FastLayout(scale=scale, gaps=tuple(gaps), increment_shift=shift)


def tabulate_rates(exact: Dynamics, layout: FastLayout) -> Integers:
    """Integers of the nested rates, shape (rows, n): each makes up for the rounding of those outside of it.

    C[i] = R[i] R[i+1] .. R[n-1], so that only C[i]'s last factor leaves an error in it.
    """
    rates = np.zeros(exact.c.shape, dtype=np.int64)
    outer = np.ones(len(exact.c))
    for i in reversed(range(exact.order)):
        scale = 2.0 ** layout.rate_bits[i]
        limit = 2**24 - 1 if i == 0 and layout.narrow else 2**32 - 1
        rates[:, i] = np.minimum(np.rint(exact.c[:, i] / outer * scale), limit).astype(np.int64)
        outer = outer * (rates[:, i] / scale)
    return rates


def rounding(exact: Dynamics, layout: FastLayout) -> Rounding:
    """What q loses when evaluated once: every loss lies between 0 and a size, hence its middle and half of it."""
    half = np.full(len(exact.c), 0.5 * layout.steady_lsb)  # x1 rounded down
    middle = -half
    for i in range(exact.order - 1):
        lost = (1.0 + (NARROW_LOSS if i == 0 and layout.narrow else fast_loss())) * layout.high_lsb[i + 1] / 2.0
        half = exact.rates[:, i] * half + lost
        # x[i+2] starts half a unit of x[i+1] high, which adding it rounded down loses.
        middle = exact.rates[:, i] * middle - lost + layout.word_lsb[i] / 2.0
    lost = fast_loss() * layout.word_lsb[-1] * 2.0**layout.increment_shift / 2.0
    return Rounding(middle=-(exact.rates[:, -1] * middle - lost), half=exact.rates[:, -1] * half + lost)


def _chain_error(layout: FastLayout) -> Array:
    """What each chain addition loses around its middle, and the carry into x[n-1], which rounds to nearest."""
    carry = 0.6
    additions = {2: (0.5 + carry, 0.0), 3: (0.5, 0.5 + carry, 0.0), 4: (0.5, 0.5, 0.5 + carry, 0.0)}[layout.order]
    lost = np.array([count * lsb for count, lsb in zip(additions, layout.word_lsb, strict=True)])
    if layout.order in (2, 4):  # half of the next increment joins x2 rounded down, before it joins x1
        lost[0] += layout.word_lsb[1]
    return np.asarray(lost, dtype=np.float64)
