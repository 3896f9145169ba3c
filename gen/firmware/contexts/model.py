"""What the templates of the model itself are told: interface, state, recursion."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from typing import TypedDict

import numpy as np

from gen.firmware.avr.block import Block, block
from gen.firmware.contexts.channels import (
    AmbientContext,
    ChannelContext,
    ambient_context,
    channel_contexts,
    word_factors,
)
from gen.firmware.contexts.components import ComponentContext, ShapeContext, component_contexts, shape_contexts
from gen.firmware.contract import Clause, as_comment, contract
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import CARRY_FACTOR
from gen.lowering.float32 import LIMIT_BITS, FloatComponent
from gen.lowering.program import Program
from gen.lowering.recursion.dynamics import domain_rows


class ModelContext(TypedDict):
    """The model library.

    Keys that need a word: `carried`, the components that hand something over when PWM changes; `avr`, the assembly of
    the recursion (None in float32); `zeroed`, ranges of |PWM| at which a negative gain counts as 0; `start_members`,
    limits and factors of start values as literals, and whose they are; `shifts`, by how many bits words are shifted;
    `limit_bits` and `limit_literals`, the ends of a float32 accumulator's range; `channels`, what the board is told
    beside the PWM; `ambient_drive`, the one whose changes pass the parts' dynamics, or None; `is_network`, whether
    there are nodes and paths in the place of transfer functions; `contract`, what the guarantee says, and
    `contract_comment`, the same as a comment.
    """

    components: list[ComponentContext]
    carried: list[ComponentContext]
    shapes: list[ShapeContext]
    saturates: bool
    saturation_argument: str
    outside_validity: str
    zeroed: list[tuple[int, int]]
    start_members: dict[tuple[str, str, str], list[str]]
    avr: Block | None
    carry_factor: int
    shifts: list[int]
    limit_bits: int
    limit_literals: Callable[[int], str]
    channels: list[ChannelContext]
    ambient_drive: AmbientContext | None
    is_network: bool
    contract: tuple[Clause, ...]
    contract_comment: list[str]


def model_context(program: Program) -> ModelContext:
    """The model library of a program."""
    model = program.model
    components = component_contexts(program)
    promised = contract(program)
    return {
        "components": components,
        "carried": [component for component in components if component["carried"]],
        "shapes": shape_contexts(program),
        "saturates": program.saturates,
        "saturation_argument": f", &{model.name}_model.saturations",
        "outside_validity": _outside(model.validity, model.domain_pwm),
        "zeroed": _zeroed(program),
        "start_members": _start_members(program),
        "avr": block(program) if program.arithmetic == "fixed" and program.network is None else None,
        "carry_factor": CARRY_FACTOR,
        "shifts": _shift_totals(program),
        "limit_bits": LIMIT_BITS,
        "limit_literals": _limit_literals,
        "channels": channel_contexts(program.channels),
        "ambient_drive": ambient_context(program),
        "is_network": program.network is not None,
        "contract": promised,
        "contract_comment": as_comment(promised),
    }


def _limit_literals(shift: int) -> str:
    """The first value that an accumulator does not take, in C++, and the number before it."""
    end = np.float32(2.0 ** (LIMIT_BITS + shift))
    below = np.nextafter(end, np.float32(0.0))
    return f"{FloatComponent.literal(float(end))}, {FloatComponent.literal(float(below))}"


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
            low, high = component.start_range_mK
            arguments = (f"{low}L", f"{high}L", word_factors(component))
            members.setdefault(arguments, []).append(component.name)
    return members


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
