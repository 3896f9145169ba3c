"""Lower a whole coefficient file: every component, for one arithmetic and one kind of schedule."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from math import inf

from gen.arrays import IntArray
from gen.coefficients import Coefficients
from gen.errors import CheckFailed, InputError
from gen.lowering import float32
from gen.lowering.effects import lower_effects
from gen.lowering.fixed import lower as fixed
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.float32 import FloatComponent
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.network.lower import lower_network
from gen.lowering.onboard import OnboardComponent, compile_component, tuned
from gen.lowering.onboard.evaluate import RangeError, evaluate
from gen.lowering.onboard.interpolate import NoPolynomialError
from gen.lowering.program import AnyComponent, Program, Shape
from gen.lowering.recursion import bounds
from gen.lowering.recursion.dynamics import TOWARDS_SETTLED, Dynamics, LoweringError, domain_rows, dynamics
from gen.lowering.recursion.guarantee import rounded_up
from gen.model import Component, ThermalModel

#: Relative size of the terms that the float schedule leaves out where the usual one makes its bound too large.
_FINE_TOLERANCE = 1e-7


def lower(coefficients: Coefficients, arithmetic: Arithmetic, schedule: ScheduleKind) -> Program:
    """Lower every component.

    Raises
    ------
    CheckFailed
        If a component cannot be lowered, if its proven error exceeds the file's limit, or if nothing can be proven of
        it and the file does not accept that; the message names it. Also if the file holds an effect that no firmware
        is emitted for.
    InputError
        If a network is asked for with a schedule that the board computes.
    """
    model = coefficients.model
    if model.network is not None:
        if schedule == "onboard":
            raise InputError("a network is built with tables alone; expected --schedule table")
        return Program(arithmetic, schedule, model, (), (), network=lower_network(coefficients, arithmetic))
    limit, entry = coefficients.accuracy.limit(arithmetic)
    components: list[FixedComponent | FloatComponent] = []
    onboard: list[OnboardComponent] = []
    for component in model.components:
        try:
            lowered, exact, tape = _lowered(model, component, arithmetic, schedule, limit)
            if tape is not None:
                onboard.append(tape)
        except (RangeError, NoPolynomialError) as error:
            raise CheckFailed(f"component {component.name}: --schedule onboard cannot compute it: {error}") from error
        except LoweringError as error:
            raise CheckFailed(str(error)) from error
        _check_bound(lowered, limit, entry, exact, unproven=coefficients.accuracy.unproven)
        components.append(lowered)
    effects = lower_effects(coefficients, arithmetic, components)
    return Program(arithmetic, schedule, model, tuple(components), _shapes(components), tuple(onboard), effects=effects)


def _lowered(
    model: ThermalModel, component: Component, arithmetic: Arithmetic, schedule: ScheduleKind, limit: float
) -> tuple[AnyComponent, AnyComponent, OnboardComponent | None]:
    """A component, the same with coefficients as from a table, and the tape that computes its coefficients, if any.

    Where the ambient moves, another place of the states' polytope is tried before the limit is exceeded.
    """
    best: tuple[AnyComponent, AnyComponent, OnboardComponent | None] | None = None
    smallest = inf
    for towards in TOWARDS_SETTLED if model.ambient_passes else TOWARDS_SETTLED[:1]:
        exact = _table(model, component, arithmetic, limit, towards, tabulated=schedule == "table")
        found: tuple[AnyComponent, AnyComponent, OnboardComponent | None] = (exact, exact, None)
        if schedule == "onboard":
            onboard, tape = _onboard(model, component, exact, limit, towards)
            found = (onboard, exact, tape)
        bound = found[0].proof.bound_K if found[0].proof is not None else inf
        if best is None or bound < smallest:
            best, smallest = found, bound
        if smallest <= limit:
            break
    assert best is not None
    return best


def _check_bound(lowered: AnyComponent, limit: float, entry: str, exact: AnyComponent, *, unproven: str) -> None:
    """Hold the bound against the limit; ``exact`` has the same formats with coefficients as from a table."""
    if lowered.proof is None:
        if unproven == "refuse":
            nearer = exact.proof is not None
            raise CheckFailed(
                f"component {lowered.name}: no error bound can be proven: {lowered.unproven}; "
                + ("the tables of --schedule table have one; " if nearer else "")
                + 'with $.accuracy.unproven = "saturate" it is built without one'
            )
        return
    if lowered.proof.bound_K <= limit:
        return
    nearer = exact.proof is not None and exact.proof.bound_K <= limit
    raise CheckFailed(
        f"component {lowered.name}: the guaranteed error bound of {rounded_up(lowered.proof.bound_K):.1e} K "
        f"exceeds $.accuracy.{entry} = {limit:.1e} K" + ("; the tables of --schedule table keep it" if nearer else "")
    )


def _table(
    model: ThermalModel, component: Component, arithmetic: Arithmetic, limit: float, towards: float, *, tabulated: bool
) -> FixedComponent | FloatComponent:
    if arithmetic == "fixed":
        aim = min(limit, fixed.TARGET_K)
        return fixed.lower_component(model, component, aim, tabulated=tabulated, towards_settled=towards)
    return float32.lower_component(model, component, limit, towards_settled=towards)


def _onboard(
    model: ThermalModel, component: Component, lowered: FixedComponent | FloatComponent, limit: float, towards: float
) -> tuple[FixedComponent | FloatComponent, OnboardComponent]:
    """The component with the coefficients that the board itself computes, and the tape that computes them."""
    exact = dynamics(model, component, lowered.substeps, towards)
    rows = domain_rows(model)
    if isinstance(lowered, FixedComponent):
        tape = compile_component(model, component, "fixed", lowered.layout, lowered.substeps)
        found = fixed.with_rows(lowered, exact, *evaluate(tape, rows))
        if found.proof is not None and found.proof.bound_K > fixed.TARGET_K:
            ranges = bounds.state_ranges(exact.recursion, exact)
            better = tuned(tape, exact.c, ranges.distance / exact.c[:, :1])
            other = fixed.with_rows(lowered, exact, *evaluate(better, rows))
            # Tuning knows nothing of S, which the same constants go into.
            if other.proof is not None and other.proof.bound_K < found.proof.bound_K:
                found, tape = other, better
        return found, tape
    tape = compile_component(model, component, "float", None, lowered.substeps)
    given = _float_rows(lowered, exact, tape, rows)
    if given.proof is not None and given.proof.bound_K > limit:
        tape = compile_component(model, component, "float", None, lowered.substeps, tolerance=_FINE_TOLERANCE)
        given = _float_rows(lowered, exact, tape, rows)
    return given, tape


def _float_rows(lowered: FloatComponent, exact: Dynamics, tape: OnboardComponent, rows: IntArray) -> FloatComponent:
    rates, steady = evaluate(tape, rows)
    return float32.with_rows(lowered, exact, rates, steady)


def _formats(component: AnyComponent) -> object:
    return component.fraction_bits if isinstance(component, FloatComponent) else component.layout


def _shapes(components: Sequence[AnyComponent]) -> tuple[Shape, ...]:
    keys = [(c.order, c.substeps, _formats(c), c.start_range_mK, c.saturates) for c in components]
    first = {key: index for index, key in reversed(list(enumerate(keys)))}
    order = sorted(range(len(components)), key=lambda index: (first[keys[index]], index))
    groups = [tuple(members) for _, members in groupby(order, key=lambda index: first[keys[index]])]
    return tuple(Shape(chr(ord("A") + number), members) for number, members in enumerate(groups))
