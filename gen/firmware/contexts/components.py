"""Components and shapes as the templates see them: their places in the board's state, their formats, what is proven."""

from __future__ import annotations

from typing import NotRequired, TypedDict

from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.corrected_format import FIRST_DROPPED
from gen.lowering.fixed.formats import GAIN_FACTOR
from gen.lowering.float32 import FloatComponent
from gen.lowering.float32.start import start_factor
from gen.lowering.network.program import NodeComponent
from gen.lowering.program import AnyComponent, Program, Shape
from gen.lowering.recursion.guarantee import rounded_up


class ComponentContext(TypedDict):
    """One component.

    `carried`: the board hands something over when PWM changes; `shape` and `place`: the type and the member of the
    board's state; `bound`: the guaranteed error for people.
    """

    name: str
    description: str
    order: int
    carried: bool
    substeps: int
    shape: str
    place: str
    saturates: bool
    bound: str


class ShapeContext(TypedDict):
    """Components with one body of C++; the optional keys are those of one arithmetic."""

    id: str
    place: str
    count: int
    members: list[str]
    order: int
    carried: bool
    corrected: bool
    substeps: int
    saturates: bool
    start_mK: tuple[int, int]
    comments: list[str]
    fraction_bits: tuple[int, ...]
    chain_shifts: tuple[int, ...]
    fixed: NotRequired[FixedShape]
    single: NotRequired[SingleShape]


class FixedShape(TypedDict):
    """What a shape in fixed point has beside that."""

    rate_bits: tuple[int, ...]
    product_shifts: tuple[int, ...]
    output_bits: int
    first_dropped: int
    first_rate_cut: int
    gain_factor: int
    carry_byte: int
    carry_bits: int
    carry_place: int


class SingleShape(TypedDict):
    """What a shape in float32 has beside that, as literals; `carry_factor` is empty at order 1."""

    start_factor: str
    carry_factor: str


def component_contexts(program: Program) -> list[ComponentContext]:
    """The components in the order of the coefficient file."""
    if program.network is not None:
        return _sensed_nodes(program)
    places = places_of(program)
    return [
        {
            "name": component.name,
            "description": component.description,
            "order": component.order,
            "carried": carries(lowered),
            "substeps": lowered.substeps,
            "shape": places[number][0],
            "place": places[number][1],
            "saturates": lowered.saturates,
            "bound": bound_text(lowered),
        }
        for number, (component, lowered) in enumerate(zip(program.model.components, program.components, strict=True))
    ]


def _sensed_nodes(program: Program) -> list[ComponentContext]:
    """A network's sensed nodes; what only transfer functions have is empty."""
    network = program.model.network
    assert network is not None
    return [
        {
            "name": node.name,
            "description": node.description,
            "order": 1,
            "carried": False,
            "substeps": 1,
            "shape": "",
            "place": "",
            "saturates": False,
            "bound": bound_text(part),
        }
        for node, part in zip(network.sensed, program.parts, strict=True)
    ]


def places_of(program: Program) -> dict[int, tuple[str, str]]:
    """For each component the identifier of its shape and its member of the board's state."""
    return {
        member: (shape.identifier, f"{shape.place}[{index}]")
        for shape in program.shapes
        for index, member in enumerate(shape.members)
    }


def shape_contexts(program: Program) -> list[ShapeContext]:
    """The shapes in the order of the board's state."""
    return [_shape(program, shape) for shape in program.shapes]


def _shape(program: Program, shape: Shape) -> ShapeContext:
    component = program.components[shape.members[0]]
    formats = component.layout if isinstance(component, FixedComponent) else component
    found: ShapeContext = {
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
        "fraction_bits": tuple(formats.fraction_bits),
        "chain_shifts": tuple(formats.chain_shifts),
    }
    if isinstance(component, FixedComponent):
        found["fixed"] = _fixed_shape(component)
    else:
        found["single"] = _single_shape(component)
    return found


def _fixed_shape(component: FixedComponent) -> FixedShape:
    layout = component.layout
    whole, bits = divmod(layout.chain_shifts[-1], 8) if component.order > 1 else (layout.carry_byte, 0)
    return {
        "rate_bits": tuple(layout.rate_fraction_bits),
        "product_shifts": tuple(layout.product_shifts),
        "output_bits": layout.output_bits,
        "first_dropped": FIRST_DROPPED,
        "first_rate_cut": layout.first_rate_cut if layout.corrected else 0,
        "gain_factor": GAIN_FACTOR,
        "carry_byte": layout.carry_byte,
        "carry_bits": bits,
        "carry_place": 8 * (layout.carry_byte - whole),
    }


def _single_shape(component: FloatComponent) -> SingleShape:
    return {
        "start_factor": component.literal(float(start_factor(component.fraction_bits[0]))),
        "carry_factor": component.literal(float(component.carry_factor)) if component.order > 1 else "",
    }


def carries(component: AnyComponent) -> bool:
    """Whether the board hands something over when PWM changes."""
    return component.carries if isinstance(component, FixedComponent) else component.order > 1


def bound_text(component: AnyComponent | NodeComponent) -> str:
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
