"""Choose the words' formats, tabulate the coefficients, and prove the result."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.arrays import SingleArray
from gen.lowering.float32.component import LIMIT_BITS, FloatComponent
from gen.lowering.float32.packing import packed, packed_steady
from gen.lowering.float32.proof import prove, word_ranges
from gen.lowering.float32.ranges import Magnitudes, Reachable, proven_magnitudes, unproven_magnitudes
from gen.lowering.recursion.dynamics import TOWARDS_SETTLED, Dynamics, dynamics
from gen.lowering.recursion.no_proof import NoProofError
from gen.lowering.recursion.substeps import fewest_substeps
from gen.model import Component, ThermalModel

#: The units of neighbouring states differ by no more bits than this (a state that never moves needs no finer one).
_MOST_SHIFT = 40


def lower_component(
    model: ThermalModel, component: Component, limit_K: float, *, towards_settled: float = TOWARDS_SETTLED[0]
) -> FloatComponent:
    """Find formats, float32 tables and proof for one component.

    Parameters
    ----------
    model, component
        What to lower.
    limit_K
        The error bound to aim for; more substeps are tried until it holds.
    towards_settled
        Where the states' polytope lies.

    Raises
    ------
    LoweringError
        If the poles do not fit the sample time.
    """
    return fewest_substeps(
        component.order,
        limit_K,
        lambda substeps: _lower(component, dynamics(model, component, substeps, towards_settled), substeps),
    )


def with_rows(lowered: FloatComponent, exact: Dynamics, rates: SingleArray, steady_K: SingleArray) -> FloatComponent:
    """The same component with given rows, such as an onboard schedule computes, and their own proof.

    Parameters
    ----------
    lowered
        Gives formats (wider ones are taken if the given rows cannot be proven) and substeps.
    exact
        ``dynamics(model, component, lowered.substeps)``.
    rates, steady_K
        Shapes (rows, n), dimensionless, and (rows,), in K.
    """
    given = replace(lowered, rates=rates, steady=lowered.steady_words(steady_K), proof=None, unproven="")
    try:
        reachable = Reachable(exact.recursion, exact)
        return replace(given, proof=prove(given, reachable, proven_magnitudes(reachable)))
    except NoProofError as error:
        given = replace(given, unproven=str(error))
    wide = replace(given, fraction_bits=_fraction_bits(exact, unproven_magnitudes(exact), LIMIT_BITS))
    return replace(wide, steady=wide.steady_words(steady_K))


def _lower(component: Component, exact: Dynamics, substeps: int) -> FloatComponent:
    try:
        reachable = Reachable(exact.recursion, exact)
        sizes = proven_magnitudes(reachable)
        lowered = _tabulate(component, exact, substeps, _fraction_bits(exact, sizes, 31))
        return replace(lowered, proof=prove(lowered, reachable, sizes))
    except NoProofError as error:
        unproven = str(error)
    sizes = unproven_magnitudes(exact)
    lowered = _tabulate(component, exact, substeps, _fraction_bits(exact, sizes, LIMIT_BITS))
    return replace(lowered, unproven=unproven)


def _fraction_bits(exact: Dynamics, sizes: Magnitudes, bits: int) -> tuple[int, ...]:
    """F of each word: as many as its range leaves of ``bits``, and not fewer than its predecessor's."""
    needed = np.maximum(word_ranges(exact, sizes), 1e-30)
    chosen = [int(v) for v in bits - np.ceil(np.log2(needed * (1.0 + 1e-6)))]
    for i in reversed(range(len(chosen) - 1)):
        chosen[i] = min(chosen[i], chosen[i + 1])
    for i in range(1, len(chosen)):
        chosen[i] = min(chosen[i], chosen[i - 1] + _MOST_SHIFT)
    return tuple(chosen)


def _tabulate(component: Component, exact: Dynamics, substeps: int, fraction_bits: tuple[int, ...]) -> FloatComponent:
    rates = exact.rates.astype(np.float32)
    return FloatComponent(
        name=component.name,
        order=component.order,
        substeps=substeps,
        fraction_bits=fraction_bits,
        rates=np.stack([packed(np.ascontiguousarray(column)) for column in rates.T], axis=1),
        steady=packed_steady(exact.steady, fraction_bits[0]),
        start_range_mK=exact.start_range_mK,
        proof=None,
    )
