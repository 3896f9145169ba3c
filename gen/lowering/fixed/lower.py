"""Lower a component to fixed point: formats, integers, and the proof of ranges and error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.arrays import IntArray
from gen.lowering.fixed import corrected_format, correction, formats
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import RESIDUE_BITS, Format, steady_excess
from gen.lowering.fixed.proof import prove, prove_corrected
from gen.lowering.recursion import bounds
from gen.lowering.recursion.dynamics import TOWARDS_SETTLED, Dynamics, LoweringError, dynamics
from gen.lowering.recursion.no_proof import NoProofError
from gen.lowering.recursion.reach import SwitchedRecursion
from gen.lowering.recursion.substeps import fewest_substeps
from gen.model import Component, ThermalModel

#: Error bound to aim for; a file may allow more, where the board's own coefficients need it.
TARGET_K = 1e-5
#: A bound of so many limits is not mended by twice the substeps.
_HOPELESS = 5.0
#: Share of the error limit that the choice of formats may spend on rounding.
_ROUNDING_SHARE = 0.3


def tabulate(exact: Dynamics, layout: Format) -> tuple[IntArray, IntArray]:
    """The integers of rates (to nearest) and steady rises (down) in a layout."""
    scale = 2.0 ** np.array(layout.rate_fraction_bits)
    rates = np.rint(exact.rates * scale).astype(np.int64)
    steady = np.floor(exact.steady * 2.0 ** (layout.fraction_bits[0] - RESIDUE_BITS)).astype(np.int64)
    return rates, steady


def lower_component(
    model: ThermalModel,
    component: Component,
    limit_K: float,
    *,
    tabulated: bool = False,
    towards_settled: float = TOWARDS_SETTLED[0],
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
    towards_settled
        Where the states' polytope lies.

    Raises
    ------
    LoweringError
        If the poles do not fit the sample time or no formats can hold the ranges.
    """
    if tabulated and component.order == correction.ORDER:
        found = _lower_corrected(component, dynamics(model, component, 1, towards_settled))
        if found is not None and found.proof is not None and found.proof.bound_K <= limit_K:
            return found
    return fewest_substeps(
        component.order,
        limit_K,
        lambda substeps: _lower(component, dynamics(model, component, substeps, towards_settled), substeps, limit_K),
        hopeless=_HOPELESS,
    )


def _lower(component: Component, exact: Dynamics, substeps: int, limit_K: float) -> FixedComponent:
    recursion: SwitchedRecursion | None = None
    drive: float | None = None
    unproven = ""
    try:
        recursion = exact.recursion
        ranges = bounds.state_ranges(recursion, exact)
        inner = bounds.inner_ranges(recursion, exact)
        needed, drive = np.maximum(ranges.magnitude, inner.largest), inner.drive
    except NoProofError as error:
        recursion, unproven = None, str(error)
        ranges = bounds.unproven_ranges(exact)
        needed = formats.nested_ranges(ranges, exact.rates)
    target = formats.Target(exact.c, exact.rates, ranges.distance)
    layout = formats.choose(needed, drive, target, limit_K * _ROUNDING_SHARE)
    if layout is None:
        raise LoweringError(f"component {component.name}: no fixed-point formats hold its ranges")
    rates, steady = tabulate(exact, layout)
    proof = None
    if recursion is not None:
        try:
            proof = prove(recursion, exact, ranges, layout, rates)
        except NoProofError as error:
            unproven = str(error)
    return FixedComponent(
        name=component.name,
        order=component.order,
        substeps=substeps,
        layout=layout,
        rates=rates,
        steady=steady,
        start_range_mK=exact.start_range_mK,
        proof=proof,
        unproven=unproven,
    )


def _lower_corrected(component: Component, exact: Dynamics) -> FixedComponent | None:
    """The component in the corrected form, None if it cannot have it."""
    try:
        recursion = exact.recursion
        inner = bounds.inner_ranges(recursion, exact).largest
        inner = np.maximum(inner, bounds.state_ranges(recursion, exact).magnitude)
    except NoProofError:
        return None
    for layout in corrected_format.candidates(inner, exact.rates.max(axis=0)):
        tables, rates = correction.tabulate(exact, layout)
        lost = corrected_format.rounding(layout, tables.rates, rates).steady
        steady = np.rint((tables.steady - lost) / layout.high_lsb[0]).astype(np.int64)
        try:
            proof = prove_corrected(recursion, exact, layout, rates, steady)
        except NoProofError:
            continue
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


def with_rows(lowered: FixedComponent, exact: Dynamics, rates: IntArray, steady: IntArray) -> FixedComponent:
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
    given = replace(lowered, rates=rates, steady=steady, proof=None, unproven="")
    try:
        recursion = exact.recursion
        if lowered.layout.corrected:
            return replace(given, proof=prove_corrected(recursion, exact, lowered.layout, rates, steady))
        ranges = bounds.state_ranges(recursion, exact)
        excess = steady_excess(steady, exact.steady, lowered.layout)
        return replace(given, proof=prove(recursion, exact, ranges, lowered.layout, rates, excess))
    except NoProofError as error:
        return replace(given, unproven=str(error))
