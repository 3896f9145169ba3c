"""Lower a component to fixed point: formats, integers, and the proof of ranges and error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import ParamSpec

import numpy as np

from gen.lowering import bounds, corrected_format, correction, formats, increments
from gen.lowering.bounds import Array, StateRanges
from gen.lowering.dynamics import Dynamics, LoweringError, dynamics
from gen.lowering.formats import RESIDUE_BITS, START_UNITS, Format
from gen.lowering.onboard.tape import steady_excess
from gen.lowering.program import FixedComponent, Integers, Proof
from gen.lowering.reach import NoProofError, SwitchedRecursion
from gen.lowering.substeps import fewest_substeps
from gen.model import Component, ThermalModel

_Given = ParamSpec("_Given")

#: Error bound to aim for; a file may allow more, where the board's own coefficients need it.
TARGET_K = 1e-5
#: A bound of so many limits is not mended by twice the substeps.
_HOPELESS = 5.0
#: Share of the error limit that the choice of formats may spend on rounding.
_ROUNDING_SHARE = 0.3


def tabulate(exact: Dynamics, layout: Format) -> tuple[Integers, Integers]:
    """The integers of rates (to nearest) and steady rises (down) in a layout."""
    scale = 2.0 ** np.array(layout.rate_fraction_bits)
    rates = np.rint(exact.rates * scale).astype(np.int64)
    steady = np.floor(exact.steady * 2.0 ** (layout.fraction_bits[0] - RESIDUE_BITS)).astype(np.int64)
    return rates, steady


def lower_component(
    model: ThermalModel, component: Component, limit_K: float, *, tabulated: bool = False
) -> FixedComponent:
    """Find formats, integers and proof for one component.

    Parameters
    ----------
    model, component
        What to lower.
    limit_K
        The error bound to aim for; more substeps are tried until it holds.
    tabulated
        Whether the integers come from a table, so that the corrected form is worth trying.

    Raises
    ------
    LoweringError
        If the poles do not fit the sample time or no formats can hold the ranges.
    """
    if tabulated and component.order == correction.ORDER:
        found = _lower_corrected(component, dynamics(model, component, 1))
        if found is not None and found.proof is not None and found.proof.bound_K <= limit_K:
            return found
    return fewest_substeps(
        component.order,
        limit_K,
        lambda substeps: _lower(component, dynamics(model, component, substeps), substeps, limit_K),
        hopeless=_HOPELESS,
    )


def _lower(component: Component, exact: Dynamics, substeps: int, limit_K: float) -> FixedComponent:
    recursion: SwitchedRecursion | None = None
    drive: float | None = None
    try:
        recursion = SwitchedRecursion(exact.exact)
        ranges = bounds.state_ranges(recursion, exact)
        inner = bounds.inner_ranges(recursion, exact)
        needed, drive = np.maximum(ranges.magnitude, inner.largest), inner.drive
    except NoProofError:
        recursion = None
        ranges = bounds.unproven_ranges(exact)
        needed = formats.nested_ranges(ranges, exact.rates)
    target = formats.Target(exact.c, exact.rates, ranges.distance)
    layout = formats.choose(needed, drive, target, limit_K * _ROUNDING_SHARE)
    if layout is None:
        raise LoweringError(f"component {component.name}: no fixed-point formats hold its ranges")
    rates, steady = tabulate(exact, layout)
    proof = None if recursion is None else prove(recursion, exact, ranges, layout, rates)
    return FixedComponent(
        name=component.name,
        order=component.order,
        substeps=substeps,
        layout=layout,
        rates=rates,
        steady=steady,
        start_range_mK=exact.start_range_mK,
        proof=proof,
    )


def _lower_corrected(component: Component, exact: Dynamics) -> FixedComponent | None:
    """The component in the corrected form, None if it cannot have it."""
    try:
        recursion = SwitchedRecursion(exact.exact)
        inner = bounds.inner_ranges(recursion, exact).largest
        inner = np.maximum(inner, bounds.state_ranges(recursion, exact).magnitude)
    except NoProofError:
        return None
    for layout in corrected_format.candidates(inner, exact.rates.max(axis=0)):
        tables, rates = correction.tabulate(exact, layout)
        lost = corrected_format.rounding(layout, tables.rates, rates).steady
        steady = np.rint((tables.steady - lost) / layout.high_lsb[0]).astype(np.int64)
        proof = _prove_corrected(recursion, exact, layout, rates, steady)
        if proof is not None:
            return FixedComponent(
                name=component.name,
                order=component.order,
                substeps=1,
                layout=layout,
                rates=rates,
                steady=steady,
                start_range_mK=exact.start_range_mK,
                proof=proof,
            )
    return None


def _none_without_proof(find: Callable[_Given, Proof | None]) -> Callable[_Given, Proof | None]:
    """Let a search for a proof give None where there is no invariant polytope."""

    @wraps(find)
    def found(*args: _Given.args, **kwargs: _Given.kwargs) -> Proof | None:
        try:
            return find(*args, **kwargs)
        except NoProofError:
            return None

    return found


@_none_without_proof
def _prove_corrected(
    recursion: SwitchedRecursion, exact: Dynamics, layout: Format, rates: Integers, steady: Integers
) -> Proof | None:
    """:func:`prove` for the corrected form."""
    tables = correction.corrected(exact, correction.Correction.of(layout, rates))
    rounding = corrected_format.rounding(layout, tables.rates, rates)
    ranges = bounds.state_ranges(recursion, tables)
    inner = bounds.inner_ranges(recursion, tables)
    needed = np.maximum(inner.largest, ranges.magnitude)
    if np.any(needed > (2.0**31 - 8.0) * np.array(layout.high_lsb)):
        return None
    if not corrected_format.fits(layout, ranges, inner.drive, rates):
        return None
    changed_c = increments.from_rates(rates * 2.0 ** -np.array(layout.rate_fraction_bits)) - tables.c
    away = np.abs(steady * layout.high_lsb[0] - (tables.steady - rounding.steady))
    q_error = rounding.q + tables.c[:, 0] * np.maximum(0.0, away - 0.5 * layout.high_lsb[0])
    q_error += np.einsum("pj,pj->p", np.abs(changed_c), ranges.distance)
    chain = rounding.chain.copy()
    chain[:, 1] += correction.Correction.of(layout, rates).on_q * q_error
    error = bounds.worst_error(
        recursion,
        tables,
        ranges,
        changed_c=np.zeros_like(changed_c),
        q_error=q_error,
        chain_error=chain,
        start_error=START_UNITS * layout.high_lsb[0],
        carry=0.0,
    )
    if error is None:
        return None
    return Proof(ranges.rise, tuple(float(v) for v in ranges.magnitude[1:]), error + layout.high_lsb[0])


def with_rows(lowered: FixedComponent, exact: Dynamics, rates: Integers, steady: Integers) -> FixedComponent:
    """The same component with given integers, such as an onboard schedule computes, and their own proof.

    Parameters
    ----------
    lowered
        Gives formats and substeps.
    exact
        ``dynamics(model, component, lowered.substeps)``.
    rates, steady
        Shapes (rows, n) and (rows,), in the component's formats.
    """
    given = replace(lowered, rates=rates, steady=steady, proof=None)
    try:
        recursion = SwitchedRecursion(exact.exact)
        if lowered.layout.corrected:
            return replace(given, proof=_prove_corrected(recursion, exact, lowered.layout, rates, steady))
        ranges = bounds.state_ranges(recursion, exact)
    except NoProofError:
        return given
    excess = steady_excess(steady, exact.steady, lowered.layout)
    return replace(given, proof=prove(recursion, exact, ranges, lowered.layout, rates, excess))


@_none_without_proof
def prove(
    recursion: SwitchedRecursion,
    exact: Dynamics,
    ranges: StateRanges,
    layout: Format,
    rates: Integers,
    steady_excess: Array | float = 0.0,
) -> Proof | None:
    """Worst error of the integer recursion, for any PWM sequence of any length.

    None if a word could overflow, or if the recursion has no invariant polytope: that one disturbance has one does not
    promise it for another.
    """
    integer_rates = rates * 2.0 ** -np.array(layout.rate_fraction_bits)
    inner = bounds.inner_ranges(recursion, exact)
    # Of the exact rates; the integers differ by so much, in all factors of all terms together.
    changed = exact.order * np.abs(integer_rates / exact.rates - 1.0).max()
    changed_sums = changed * formats.nested_ranges(ranges, np.maximum(integer_rates, exact.rates))
    needed = np.maximum(ranges.magnitude, inner.largest + changed_sums)
    if np.any(needed > (2.0**31 - 4.0) * np.array(layout.high_lsb)):
        return None
    q_range = inner.drive + float(changed_sums[-1] * exact.rates[:, -1].max())
    if exact.order > 1 and not formats.carry_fits(layout, q_range):
        return None
    q_error, chain_error = formats.rounding(layout, exact.rates, steady_excess)
    error = bounds.worst_error(
        recursion,
        exact,
        ranges,
        changed_c=increments.from_rates(integer_rates) - exact.c,
        q_error=q_error,
        chain_error=np.tile(chain_error, (len(q_error), 1)),
        start_error=START_UNITS * layout.high_lsb[0],
        carry=formats.CARRY_FACTOR / 2.0**16,
    )
    if error is None:
        return None
    return Proof(
        rise_range_K=ranges.rise,
        increment_range_K=tuple(float(v) for v in ranges.magnitude[1:]),
        bound_K=error + layout.high_lsb[0],
    )
