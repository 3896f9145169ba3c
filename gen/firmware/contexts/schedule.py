"""What the templates of the schedules are told: the table in flash, or the tapes that the board runs."""

from __future__ import annotations

from typing import TypedDict

from gen.errors import CheckFailed
from gen.firmware.contexts.components import ComponentContext, ShapeContext, component_contexts, shape_contexts
from gen.firmware.onboard_cpp import helpers
from gen.firmware.onboard_shared import schedule_sources
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import RESIDUE_BITS
from gen.lowering.float32 import ONBOARD_STEADY_SHIFT, Column, FloatComponent, column_words
from gen.lowering.program import AnyComponent, Program
from gen.lowering.recursion.dynamics import domain_rows

_LARGEST_TABLE = 32_767
"""Bytes of the largest array that avr-gcc takes."""


class Entry(TypedDict):
    """One component's literals at one |PWM|."""

    rates: list[str]
    steady: str


class Row(TypedDict):
    """One |PWM| of the fixed table: the entries of each shape's members."""

    pwm: int
    shapes: list[list[Entry]]


class OnboardWords(TypedDict):
    """How a schedule on board turns what it computed in float32 into words."""

    steady_constant: str
    chain_shifts: tuple[int, ...]


class ScheduleContext(TypedDict):
    """The schedule of a program.

    `rows` and `copied_at_once` are the fixed table's, `columns` the float table's; `helpers`, `tapes` and `words` (of
    float32, by component) are those of a schedule that the board computes. What a schedule lacks is empty.
    """

    schedule_comments: list[str]
    components: list[ComponentContext]
    shapes: list[ShapeContext]
    rows: list[Row]
    copied_at_once: int
    columns: list[Column]
    helpers: frozenset[str]
    tapes: list[str]
    words: dict[str, OnboardWords]
    steady_shift: int


def schedule_context(program: Program) -> ScheduleContext:
    """The schedule of a program.

    Raises
    ------
    CheckFailed
        If the table of coefficients is larger than the board's compiler takes.
    """
    _check_table(program)
    return {
        "schedule_comments": _schedule_comments(program),
        "components": component_contexts(program),
        "shapes": shape_contexts(program),
        "rows": _rows(program),
        "copied_at_once": _copied_at_once(program),
        "columns": _columns(program),
        "helpers": helpers(program.onboard),
        "tapes": schedule_sources(program.model.name, program.onboard),
        "words": {c.name: _onboard_words(c) for c in program.components if isinstance(c, FloatComponent)},
        "steady_shift": ONBOARD_STEADY_SHIFT,
    }


def _row_bytes(program: Program) -> int:
    """Bytes of a row of the table in flash, of the fixed-point ones as they are copied."""
    words = sum(component.order + 1 for component in program.components)
    return (3 if program.arithmetic == "float" else 4) * words


def _check_table(program: Program) -> None:
    size = _row_bytes(program) * len(domain_rows(program.model))
    if program.schedule == "table" and size > _LARGEST_TABLE:
        raise CheckFailed(
            f"the table of coefficients would have {size} bytes, and the board's compiler takes {_LARGEST_TABLE} at "
            "most; leave components out, or let the board compute its coefficients: --schedule onboard"
        )


def _copied_at_once(program: Program) -> int:
    """How many bytes of a row of the table the copying loop takes in one turn, so that turns come out even."""
    words = sum(component.order + 1 for component in program.components)
    return 4 * max(part for part in range(1, 7) if words % part == 0)


def _onboard_words(component: FloatComponent) -> OnboardWords:
    constant = component.literal(float(component.steady_constant))
    return {"steady_constant": constant, "chain_shifts": tuple(component.chain_shifts)}


def _columns(program: Program) -> list[Column]:
    """The float table's columns in the order of the board's coefficients; empty where there is no such table."""
    if program.onboard:
        return []
    members = [program.components[member] for shape in program.shapes for member in shape.members]
    return [column for item in members if isinstance(item, FloatComponent) for column in column_words(item)]


def _rows(program: Program) -> list[Row]:
    """The fixed table, one entry for each |PWM| of the domain; empty where the board computes its coefficients."""
    if program.onboard or program.arithmetic == "float":
        return []
    return [
        {
            "pwm": int(pwm),
            "shapes": [
                [_literals(program.components[member], row) for member in shape.members] for shape in program.shapes
            ],
        }
        for row, pwm in enumerate(domain_rows(program.model))
    ]


def _literals(component: AnyComponent, row: int) -> Entry:
    assert isinstance(component, FixedComponent)
    return {
        "rates": [f"{int(rate)}UL" for rate in component.rates[row]],
        "steady": f"{int(component.steady[row])}L",
    }


def _schedule_comments(program: Program) -> list[str]:
    lines = []
    for component in program.components:
        if isinstance(component, FixedComponent):
            layout = component.layout
            bits = ", ".join(f"R{i} * 2^{b}" for i, b in enumerate(layout.rate_fraction_bits))
            lines.append(f"{component.name}: {bits}, S * 2^{layout.fraction_bits[0] - RESIDUE_BITS}; from")
        else:
            lines.append(f"{component.name}: R0..R{component.order - 1} and S in float32; from")
        lines.append(f"  $.components[name={component.name}].poles (R) and .gain (S = K |PWM| / A(0), in K).")
    return lines
