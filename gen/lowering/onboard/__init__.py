"""Schedules that the board evaluates itself when PWM changes (``--schedule onboard``)."""

from __future__ import annotations

from dataclasses import replace

from gen.lowering.fixed.formats import Format, steady_excess
from gen.lowering.kinds import Arithmetic
from gen.lowering.onboard.discretise import discretise
from gen.lowering.onboard.fixed import FixedTape
from gen.lowering.onboard.graph import Label
from gen.lowering.onboard.single import float_tape
from gen.lowering.onboard.tape import OnboardComponent, Step
from gen.lowering.onboard.tune import tuned
from gen.model import Component, ThermalModel

__all__ = ["OnboardComponent", "Step", "compile_component", "steady_excess", "tuned"]

#: Relative size of the terms that are left out: far below the resolution of the arithmetic's results.
_TOLERANCE: dict[Arithmetic, float] = {"fixed": 1e-9, "float": 2e-6}
#: In order 1 an error of the rate acts on the distance to S alone: on 200 K, a tenth of the error aimed at.
_TOLERANCE_ORDER_1 = 5e-9
#: Of a sum of exponentials that becomes a polynomial, in order 2 and more.
_TOLERANCE_SERIES = 1e-10


def compile_component(
    model: ThermalModel,
    component: Component,
    arithmetic: Arithmetic,
    layout: Format | None,
    substeps: int,
    *,
    tolerance: float | None = None,
) -> OnboardComponent:
    """Compile the schedules and the discretisation of one component for the board.

    Parameters
    ----------
    model, component
        What to compile.
    arithmetic
        "fixed" or "float".
    layout
        Formats of the component's recursion (fixed only): the results have them.
    substeps
        Parts of a sample that the recursion runs in.
    tolerance
        Relative size of a term that may be left out; None for the arithmetic's own.
    """
    exact = None if arithmetic == "float" else _TOLERANCE_ORDER_1 if component.order == 1 else _TOLERANCE_SERIES
    usual = _TOLERANCE_ORDER_1 if arithmetic == "fixed" and component.order == 1 else _TOLERANCE[arithmetic]
    source = discretise(model, component, substeps, tolerance or usual, series=exact)
    if arithmetic == "fixed":
        if layout is None:
            raise ValueError("fixed point needs a layout")
        tape = FixedTape(source, layout)
        steps, rates, steady = tape.steps, tape.rates, tape.steady
    else:
        steps, rates, steady = float_tape(source)
    return OnboardComponent(
        name=component.name,
        order=component.order,
        substeps=substeps,
        arithmetic=arithmetic,
        domain=model.domain_pwm,
        steps=_labelled(steps),
        rates=rates,
        steady=steady,
        layout=layout if arithmetic == "fixed" else None,
    )


def _labelled(steps: list[Step]) -> tuple[Step, ...]:
    """Say of steps that have no name of their own what they are a part of."""
    result = list(steps)
    for number in reversed(range(len(result))):
        text = result[number].label.text
        for arg in result[number].args:
            if not result[arg].label.text:
                part = text if text.startswith("part of ") else f"part of {text}"
                result[arg] = replace(result[arg], label=Label(part, "", ""))
    return tuple(result)
