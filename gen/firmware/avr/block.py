"""The whole block: registers saved, shape after shape, and q of the shape that a change of PWM asks for.

One block does the whole sample, so that registers are saved once and the code's speed does not depend on the
compiler's options.  Where a change of PWM needs -q too (the carried form) the block is a function of its own, and the T
flag tells whether to leave after -q; else it stands in the step itself and knows where everything lies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gen.firmware.avr.registers import (
    COEFFICIENT_BYTES,
    COMPONENTS,
    RUNS,
    STATE_BYTES,
    load_pointer,
    step_pointer,
)
from gen.firmware.avr.shape import ShapeCode
from gen.firmware.avr.text import AsmText
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.program import Program, Shape

_ONE_BYTE = 256
"""So many addresses have different lowest bytes."""
_CHANGED = (0, 1, 11, 12, 13, 14, 15, 16, 17, 18, 19, 21)
"""Registers that every block changes besides its operands."""
_OPERANDS = (20, 22, 23, 24, 25, 26, 27, 30, 31)
"""Registers that are operands of a function, and else changed like the others."""


@dataclass(frozen=True)
class Block:
    """What the templates print.

    Attributes
    ----------
    lines
        The assembly, as lines of a C++ string with comments.
    clobbers
        Registers that it changes besides its operands.
    first
        Place of the shape at which its pointers start, "" if there is no shape to advance.
    tasks
        What to ask for, by the identifier of each shape of order 2 and more.
    """

    lines: tuple[str, ...]
    clobbers: str
    first: str
    tasks: dict[str, int]


@dataclass(frozen=True)
class _Part:
    """A shape in fixed point, one of its components, and all their names."""

    shape: Shape
    component: FixedComponent
    names: str

    @property
    def carried(self) -> bool:
        """Whether a change of PWM asks for its q."""
        return self.component.carries and not self.component.saturates

    @property
    def state_bytes(self) -> int:
        """Of all its components."""
        return STATE_BYTES * self.component.order * len(self.shape.members)

    @property
    def coefficient_bytes(self) -> int:
        """Of all its components."""
        return COEFFICIENT_BYTES * (self.component.order + 1) * len(self.shape.members)


def block(program: Program) -> Block:
    """The block of a program.

    Parameters
    ----------
    program
        What is emitted; its shapes lie in the board's state in their order.
    """
    parts = _parts(program)
    asked = any(part.carried for part in parts)
    codes = _codes(parts, in_step=not asked)
    tasks = {code.name: 2 * index + 1 for index, code in enumerate(code for code in codes.values() if code.carried)}
    text = AsmText(program.model.name.upper())
    _enter(text, asked=asked)
    _advance(text, parts, codes)
    if asked:
        _answer(text, [code for code in codes.values() if code.carried], tasks)
    text.group("The compiler wants r1 = 0.", "9:", "pop r29", "pop r28", "clr r1")
    first = parts[0].shape.place if parts else ""
    return Block(tuple(text.lines), _clobbers(list(codes.values()), asked=asked), first, tasks)


def _parts(program: Program) -> list[_Part]:
    """The shapes in fixed point from the first to the last that cannot saturate."""
    found = []
    for shape in program.shapes:
        component = program.components[shape.members[0]]
        if isinstance(component, FixedComponent):
            names = ", ".join(program.components[member].name for member in shape.members)
            found.append(_Part(shape, component, names))
    kept = [number for number, part in enumerate(found) if not part.component.saturates]
    return found[kept[0] : kept[-1] + 1] if kept else []


def _codes(parts: Sequence[_Part], *, in_step: bool) -> dict[int, ShapeCode]:
    """The code of each part that cannot saturate, by its number; in the step it is known where the states lie."""
    codes = {}
    passed = 0
    for number, part in enumerate(parts):
        passed += part.state_bytes
        component = part.component
        if not component.saturates:
            codes[number] = ShapeCode(
                name=part.shape.identifier,
                layout=component.layout,
                count=len(part.shape.members),
                runs=component.substeps,
                carried=part.carried,
                last=number == len(parts) - 1,
                end=f"%[state]+{passed}" if in_step and part.state_bytes <= _ONE_BYTE else "",
            )
    return codes


def _enter(text: AsmText, *, asked: bool) -> None:
    text.group("", "push r28", "push r29")
    if asked:
        text.group("Y: coefficients; T: whether to leave after q.", "movw r28, r26")
        text.group("", "bst r20, 0", "brtc 1f", "rjmp 6f", "1:")
    else:
        text.group("Z: state; Y: coefficients.", *load_pointer(30, "%[state]"), *load_pointer(28, "%[now]"))


def _advance(text: AsmText, parts: Sequence[_Part], codes: dict[int, ShapeCode]) -> None:
    """All shapes for one sample."""
    state_bytes = coefficient_bytes = 0  # of what was left out
    for number, part in enumerate(parts):
        if number not in codes:
            state_bytes += part.state_bytes
            coefficient_bytes += part.coefficient_bytes
            continue
        if state_bytes:
            text.group("Past what saturates.", *step_pointer(30, state_bytes), *step_pointer(28, coefficient_bytes))
            state_bytes = coefficient_bytes = 0
        text.lines.append(f"        // ---- {part.names} ----")
        codes[number].advance(text)


def _answer(text: AsmText, carried: Sequence[ShapeCode], tasks: dict[str, int]) -> None:
    """q of the shape that is asked for."""
    text.group("", "rjmp 9f")
    text.lines.append("        // ---- q for a change of PWM ----")
    text.lines.append("        // q of the shape that is asked for.")
    text.group("", "6:")
    for code in reversed(carried[1:]):
        text.group("", f"cpi r20, {tasks[code.name]}", "brlo 1f", f"rjmp {code.increment_label}", "1:")
    text.group("", f"rjmp {carried[0].increment_label}")
    for code in carried:
        code.leave(text)


def _clobbers(codes: Sequence[ShapeCode], *, asked: bool) -> str:
    used = [*_CHANGED] if asked else [*_CHANGED, *_OPERANDS]
    if any(code.counts for code in codes):
        used.append(COMPONENTS)
    if any(code.runs > 1 for code in codes):
        used.append(RUNS)
    return ", ".join(f'"r{register}"' for register in sorted(used))
