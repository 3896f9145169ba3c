"""The proof of ranges and error of a component in fixed point."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

import numpy as np

from gen.lowering.fixed import corrected_format, correction, formats
from gen.lowering.fixed.formats import Format
from gen.lowering.fixed.start import start_error
from gen.lowering.kinds import Integers
from gen.lowering.recursion import bounds, increments
from gen.lowering.recursion.bounds import Array, StateRanges, WorstError
from gen.lowering.recursion.dynamics import Dynamics
from gen.lowering.recursion.guarantee import Proof
from gen.lowering.recursion.reach import NoProofError, SwitchedRecursion

_Given = ParamSpec("_Given")


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
def prove_corrected(
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
        start_error=start_error(layout.output_bits, exact.start_range_mK),
        carry=0.0,
    )
    if error is None:
        return None
    return _proof(recursion, tables, ranges, layout, error)


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
        start_error=start_error(layout.output_bits, exact.start_range_mK),
        carry=formats.CARRY_FACTOR / 2.0**16,
    )
    if error is None:
        return None
    return _proof(recursion, exact, ranges, layout, error)


def _proof(
    recursion: SwitchedRecursion, exact: Dynamics, ranges: StateRanges, layout: Format, error: WorstError
) -> Proof:
    return Proof(
        rise_range_K=ranges.rise,
        increment_range_K=tuple(float(v) for v in ranges.magnitude[1:]),
        bound_K=error.bound_K + layout.high_lsb[0],  # what is read out is rounded down
        invariant=bounds.invariant(recursion, exact, error.reach),
    )
