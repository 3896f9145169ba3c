"""The proof of ranges and error of a component in fixed point."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.lowering.fixed import corrected_format, correction, formats
from gen.lowering.fixed.formats import Format
from gen.lowering.fixed.start import start_error
from gen.lowering.recursion import bounds, increments
from gen.lowering.recursion.bounds import InnerRanges, StateRanges, WorstError
from gen.lowering.recursion.dynamics import Dynamics
from gen.lowering.recursion.guarantee import Proof
from gen.lowering.recursion.no_proof import NoProofError
from gen.lowering.recursion.reach import SwitchedRecursion

_OVERFLOW = "the ranges that its states can reach do not fit their words"


def prove_corrected(
    recursion: SwitchedRecursion, exact: Dynamics, layout: Format, rates: IntArray, steady: IntArray
) -> Proof:
    """:func:`prove` for the corrected form.

    Raises
    ------
    NoProofError
        As there.
    """
    tables = correction.corrected(exact, correction.Correction.of(layout, rates))
    rounding = corrected_format.rounding(layout, tables.rates, rates)
    ranges = bounds.state_ranges(recursion, tables)
    inner = bounds.inner_ranges(recursion, tables)
    integer_rates = rates * 2.0 ** -np.array(layout.rate_fraction_bits)
    changed_sums = _changed_sums(ranges, tables, integer_rates)
    needed = np.maximum(inner.largest + changed_sums, ranges.magnitude)
    if np.any(needed > (2.0**31 - 8.0) * np.array(layout.high_lsb)):
        raise NoProofError(_OVERFLOW)
    if not corrected_format.fits(layout, ranges, _drive(inner, tables, changed_sums), rates):
        raise NoProofError(_OVERFLOW)
    changed_c = increments.from_rates(integer_rates) - tables.c
    away = np.abs(steady * layout.high_lsb[0] - (tables.steady - rounding.steady))
    away += start_error(layout.output_bits, exact.over_range_mK)
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
    return _proof(recursion, tables, ranges, layout, error)


def prove(
    recursion: SwitchedRecursion,
    exact: Dynamics,
    ranges: StateRanges,
    layout: Format,
    rates: IntArray,
    steady_excess: FloatArray | float = 0.0,
) -> Proof:
    """Worst error of the integer recursion, for any PWM sequence of any length.

    Raises
    ------
    NoProofError
        If a word could overflow, or if the recursion has no invariant polytope: that one disturbance has one does not
        promise it for another.
    """
    integer_rates = rates * 2.0 ** -np.array(layout.rate_fraction_bits)
    inner = bounds.inner_ranges(recursion, exact)
    changed_sums = _changed_sums(ranges, exact, integer_rates)
    needed = np.maximum(ranges.magnitude, inner.largest + changed_sums)
    if np.any(needed > (2.0**31 - 4.0) * np.array(layout.high_lsb)):
        raise NoProofError(_OVERFLOW)
    if exact.order > 1 and not formats.carry_fits(layout, _drive(inner, exact, changed_sums)):
        raise NoProofError(_OVERFLOW)
    ambient_error = start_error(layout.output_bits, exact.over_range_mK) / layout.high_lsb[0]
    q_error, chain_error = formats.rounding(layout, exact.rates, steady_excess + ambient_error)
    error = bounds.worst_error(
        recursion,
        exact,
        ranges,
        changed_c=increments.from_rates(integer_rates) - exact.c,
        q_error=q_error,
        chain_error=np.tile(chain_error, (len(q_error), 1)),
        start_error=start_error(layout.output_bits, exact.start_range_mK),
        carry_error=formats.carry_error(layout, float(q_error.max())) if exact.order > 1 else 0.0,
        carry=formats.CARRY_FACTOR / 2.0**16,
    )
    return _proof(recursion, exact, ranges, layout, error)


def _changed_sums(ranges: StateRanges, exact: Dynamics, integer_rates: FloatArray) -> FloatArray:
    """By how much the nested sums exceed those of the exact rates, in K: every factor of every term is changed."""
    changed = (1.0 + np.abs(integer_rates / exact.rates - 1.0).max()) ** exact.order - 1.0
    sums: FloatArray = changed * formats.nested_ranges(ranges, np.maximum(integer_rates, exact.rates))
    return sums


def _drive(inner: InnerRanges, exact: Dynamics, changed_sums: FloatArray) -> float:
    """Largest |q| with the board's rates, in K."""
    return inner.drive + float(changed_sums[-1] * exact.rates[:, -1].max())


def _proof(
    recursion: SwitchedRecursion, exact: Dynamics, ranges: StateRanges, layout: Format, error: WorstError
) -> Proof:
    return Proof(
        rise_range_K=ranges.rise,
        increment_range_K=tuple(float(v) for v in ranges.magnitude[1:]),
        bound_K=error.bound_K + layout.high_lsb[0],  # what is read out is rounded down
        invariant=bounds.invariant(recursion, exact, error.reach),
    )
