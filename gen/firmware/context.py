"""What the templates are told."""

from __future__ import annotations

from itertools import groupby
from typing import Any

import numpy as np

from gen.coefficients import Coefficients
from gen.errors import CheckFailed
from gen.firmware import avr_advance
from gen.firmware.alarms_cpp import alarm_context
from gen.firmware.effects_cpp import effects_context
from gen.firmware.onboard_cpp import helpers
from gen.firmware.onboard_shared import schedule_sources
from gen.lowering.alarms import lower_alarms
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.corrected_format import FIRST_DROPPED
from gen.lowering.fixed.formats import CARRY_FACTOR, GAIN_FACTOR, RESIDUE_BITS, start_scale
from gen.lowering.float32 import LIMIT_BITS, ONBOARD_STEADY_SHIFT, Column, FloatComponent, column_words
from gen.lowering.program import AnyComponent, Program, Shape
from gen.lowering.recursion.dynamics import domain_rows
from gen.lowering.recursion.guarantee import rounded_up
from gen.version import __version__

Context = dict[str, Any]

_LARGEST_TABLE = 32_767
"""Bytes of the largest array that avr-gcc takes."""


def project_context(coefficients: Coefficients, program: Program, source_name: str) -> Context:
    """Everything that the templates of one project need.

    Parameters
    ----------
    coefficients, program
        What is emitted.
    source_name
        The coefficient file's name as comments show it.

    Raises
    ------
    CheckFailed
        If the table of coefficients is larger than the board's compiler takes.
    """
    _check_table(program)
    model = program.model
    name = model.name
    shapes = [_shape(program, shape) for shape in program.shapes]
    places = {
        member: (shape, f"{shape.place}[{index}]")
        for shape in program.shapes
        for index, member in enumerate(shape.members)
    }
    components: list[Context] = [
        {
            "name": component.name,
            "description": component.description,
            "order": component.order,
            "carried": carries(program.components[number]),
            "substeps": program.components[number].substeps,
            "shape": places[number][0].identifier,
            "place": places[number][1],
            "saturates": program.components[number].saturates,
            "bound": bound_text(program.components[number]),
        }
        | _onboard_words(program.components[number])
        for number, component in enumerate(model.components)
    ]
    return {
        "name": name,
        "NAME": name.upper(),
        "title": f"Thermal model of {name}",
        "version": __version__,
        "source_name": source_name,
        "sha256": coefficients.sha256,
        "arithmetic": program.arithmetic,
        "schedule": program.schedule,
        "sample_time": f"{model.sample_time:g}",
        "sample_ms": round(model.sample_time * 1000.0),
        "full_scale": model.full_scale,
        "ambient_mC": round((model.ambient_fixed if model.ambient_fixed is not None else 25.0) * 1000.0),
        "validity": model.validity,
        "domain": model.domain_pwm,
        "outside_validity": _outside(model.validity, model.domain_pwm),
        "zeroed": _zeroed(program),
        "components": components,
        "carried": [component for component in components if component["carried"]],
        "carry_factor": CARRY_FACTOR,
        "start_members": _start_members(program),
        "saturates": program.saturates,
        "saturation_argument": f", &{name}_model.saturations",
        "shapes": shapes,
        "avr": avr_advance.block(program) if program.arithmetic == "fixed" else None,
        "copied_at_once": _copied_at_once(program),
        "shifts": _shift_totals(program),
        "rows": _rows(program),
        "helpers": helpers(program.onboard),
        "tapes": schedule_sources(name, program.onboard),
        "columns": _columns(program),
        "limit_bits": LIMIT_BITS,
        "steady_shift": ONBOARD_STEADY_SHIFT,
        "limit_literals": _limit_literals,
        "schedule_comments": _schedule_comments(program),
        "effects": effects_context(program),
    } | alarm_context(lower_alarms(coefficients), model)


def _shape(program: Program, shape: Shape) -> Context:
    component = program.components[shape.members[0]]
    common = {
        "id": shape.identifier,
        "place": shape.place,
        "count": len(shape.members),
        "members": [program.components[member].name for member in shape.members],
        "order": component.order,
        "carried": carries(component),
        "corrected": component.order > 1 and not carries(component),
        "substeps": component.substeps,
        "saturates": component.saturates,
        "start_mK": component.start_range_mK,
        "comments": [line for member in shape.members for line in _proof_lines(program.components[member])],
    }
    return common | (_fixed_shape(component) if isinstance(component, FixedComponent) else _float_shape(component))


def carries(component: AnyComponent) -> bool:
    """Whether the board hands something over when PWM changes."""
    return component.carries if isinstance(component, FixedComponent) else component.order > 1


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


def _fixed_shape(component: FixedComponent) -> Context:
    layout = component.layout
    output_bits = layout.fraction_bits[0] - RESIDUE_BITS
    return {
        "fraction_bits": layout.fraction_bits,
        "rate_bits": layout.rate_fraction_bits,
        "product_shifts": layout.product_shifts,
        "chain_shifts": layout.chain_shifts,
        "output_bits": output_bits,
        "first_dropped": FIRST_DROPPED,
        "first_rate_cut": layout.first_rate_cut if layout.corrected else 0,
        "gain_factor": GAIN_FACTOR,
        "carry_byte": layout.carry_byte,
        "carry_bits": layout.chain_shifts[-1] % 8 if component.order > 1 else 0,
        "carry_place": 8 * layout.carry_byte - layout.chain_shifts[-1] // 8 * 8 if component.order > 1 else 0,
        "fraction_shift": f">> {output_bits - 16}" if output_bits >= 16 else f"<< {16 - output_bits}",
    }


def _float_shape(component: FloatComponent) -> Context:
    return {
        "fraction_bits": component.fraction_bits,
        "chain_shifts": component.chain_shifts,
        "start_factor": component.literal(float(component.start_factor)),
        "carry_factor": component.literal(float(component.carry_factor)) if component.order > 1 else "",
    }


def _onboard_words(component: AnyComponent) -> Context:
    """How a schedule on board turns what it computed into words (float32)."""
    if not isinstance(component, FloatComponent):
        return {}
    constant = component.literal(float(component.steady_constant))
    return {"steady_constant": constant, "chain_shifts": component.chain_shifts}


def _limit_literals(shift: int) -> str:
    """The first value that an accumulator does not take, in C++, and the number before it."""
    end = np.float32(2.0 ** (LIMIT_BITS + shift))
    below = np.nextafter(end, np.float32(0.0))
    return f"{FloatComponent.literal(float(end))}, {FloatComponent.literal(float(below))}"


def _columns(program: Program) -> list[Column]:
    """The float table's columns in the order of the board's coefficients; empty where there is no such table."""
    if program.onboard:
        return []
    members = [program.components[member] for shape in program.shapes for member in shape.members]
    return [column for item in members if isinstance(item, FloatComponent) for column in column_words(item)]


def bound_text(component: AnyComponent) -> str:
    """The guaranteed error for people."""
    return f"{rounded_up(component.proof.bound_K):.1e} K" if component.proof else "none proven: it saturates"


def _proof_lines(component: AnyComponent) -> list[str]:
    if component.proof is None:
        return [f"{component.name}: no range could be proven for arbitrary changes of PWM, so it saturates."]
    low, high = component.proof.rise_range_K
    lines = [f"{component.name}, proven for every sequence of PWM: rise within {low:.0f}..{high:.0f} K,"]
    for number, magnitude in enumerate(component.proof.increment_range_K):
        lines.append(f"  |x{number + 2}| at most {rounded_up(magnitude):.1e} K,")
    lines.append(f"  and the rise never more than {rounded_up(component.proof.bound_K):.1e} K from the exact solution.")
    return lines


def _shift_totals(program: Program) -> list[int]:
    totals: set[int] = set()
    for component in program.components:
        if component.saturates or not isinstance(component, FixedComponent):
            continue
        shifts = component.layout.chain_shifts
        totals.update(shifts)
        if component.order == 2:
            totals.add(shifts[0] + 1)
        if component.order == 4:
            totals.add(shifts[0] + shifts[1] + 1)
    return sorted(totals)


def _start_members(program: Program) -> dict[tuple[str, str, str], list[str]]:
    """Limits and factors of the start values as literals, and whose they are."""
    members: dict[tuple[str, str, str], list[str]] = {}
    for component in program.components:
        if isinstance(component, FixedComponent):
            scale = start_scale(component.layout)
            low, high = component.start_range_mK
            arguments = (f"{low}L", f"{high}L", f"{scale.whole}L, {scale.fraction}u")
            members.setdefault(arguments, []).append(component.name)
    return members


def _rows(program: Program) -> list[Context]:
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


def _literals(component: AnyComponent, row: int) -> Context:
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


def _outside(validity: tuple[int, int], domain: tuple[int, int]) -> str:
    tests = []
    if validity[0] > domain[0]:
        tests.append(f"within < {validity[0]}u")
    if validity[1] < domain[1]:
        tests.append(f"within > {validity[1]}u")
    return " || ".join(tests)


def _zeroed(program: Program) -> list[tuple[int, int]]:
    """Ranges of |PWM| at which some component's negative gain is taken as 0."""
    rows = domain_rows(program.model)
    affected = np.zeros(len(rows), dtype=bool)
    for component in program.model.components:
        affected |= (component.raw_gain(rows) < 0.0) & (component.effective_gain(rows) == 0.0) & (rows > 0)
    counts = [int(pwm) for pwm in rows[affected]]
    ranges = []
    for _, group in groupby(enumerate(counts), key=lambda item: item[1] - item[0]):
        members = [pwm for _, pwm in group]
        ranges.append((members[0], members[-1]))
    return ranges
