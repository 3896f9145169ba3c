"""Print the effects' tapes as expressions of C++.

The names that a tape's operands have in the emitted C++ are those of the functions in the templates
``lib/model/src/effects*``, and nowhere else: `m` (a Moment), `channel`, `inner`, `value`, `elapsed`, `shown_mK`, `row`.
"""

from __future__ import annotations

from typing import Any, TypedDict

import numpy as np

from gen.lowering.effects.program import EffectsProgram
from gen.lowering.effects.tape import Step, Tape


class Statement(TypedDict):
    """A step of a tape that has a name of its own: n<number>."""

    number: int
    text: str


class Table(TypedDict):
    """Numbers by |PWM| as literals; `bits` is the place of their binary point in fixed point."""

    bits: int
    values: list[str]


class TapePrinter:
    """Prints tapes of one component; tables by |PWM| are shared among them."""

    def __init__(self, name: str, effects: EffectsProgram) -> None:
        self._name, self._effects = name, effects
        self._fixed = effects.arithmetic == "fixed"
        self._known: dict[tuple[Any, ...], str] = {}
        self._reading = False
        self.tables: list[Table] = []

    def reading(self) -> None:
        """From now on the rise is what a sensor is held to."""
        self._reading = True

    def body(self, tape: Tape) -> list[Statement]:
        """One statement for each step that is more than a number."""
        texts, lines = self._texts(tape)
        return [{"number": number, "text": texts[number]} for number in lines]

    def output(self, tape: Tape, number: int, bits: int, end: str, *, wide: bool = False) -> str:
        """An output as words of 2^-bits, within +/- end."""
        texts, lines = self._texts(tape)
        at = tape.outputs[number]
        value = f"n{at}" if at in lines else texts[at]
        if not self._fixed:
            return f"words({value}, {_single(2.0**bits)}, {end}L)"
        shift = tape.output_bits(number) - bits
        text = f"held({shifted(f'(int64_t){value}', shift)}, -INT64_C({end}), INT64_C({end}))"
        return text if wide else f"(int32_t){text}"

    def _texts(self, tape: Tape) -> tuple[list[str], list[int]]:
        texts: list[str] = []
        lines: list[int] = []
        for number, step in enumerate(tape.steps):
            a = [f"n{n}" if n in lines else texts[n] for n in step.args]
            texts.append(self._integer(step, a) if self._fixed else self._float(step, a))
            if step.op not in ("constant",) and not (step.op == "operand" and self._fixed):
                lines.append(number)
        return texts, lines

    def _integer(self, step: Step, a: list[str]) -> str:
        match step.op:
            case "operand":
                return self._operand(step)
            case "constant":
                return f"{int(step.table[0])}L"
            case "row":
                return f"(int32_t)pgm_read_dword(&{self._table(step)}[row])"
            case "mul":
                return f"product({a[0]}, {a[1]}, {step.shifts[0]})"
            case "neg":
                return f"-{a[0]}"
        left, right = (f"rounded({x}, {s})" if s else x for x, s in zip(a, step.shifts, strict=True))
        return f"{left} {'+' if step.op == 'add' else '-'} {right}"

    def _float(self, step: Step, a: list[str]) -> str:
        match step.op:
            case "operand":
                text = f"static_cast<float>({self._operand(step)})"
                return f"{text} * {_single(2.0**-step.q)}" if step.q else text
            case "constant":
                return _single(float(step.table[0]))
            case "row":
                return f"pgm_read_float(&{self._table(step)}[row])"
            case "neg":
                return f"-{a[0]}"
        sign = {"add": "+", "sub": "-", "mul": "*"}[step.op]
        return f"{a[0]} {sign} {a[1]}"

    def _operand(self, step: Step) -> str:
        assert step.operand is not None
        kind, number = step.operand
        match kind:
            case "rise":
                return "value" if self._reading else f"m.rise[{self._effects.felt.index(number)}]"
            case "lagged":
                return "value"
            case "channel":
                return f"channel[{number}]"
            case "inner":
                return f"inner[{number}]"
            case "reverse":
                return "m.reverse"
            case "elapsed":
                return "(int32_t)elapsed"
        return "shown_mK"

    def _table(self, step: Step) -> str:
        key = (step.q, *step.table)
        if key not in self._known:
            self._known[key] = f"{self._name}_table{len(self._known)}"
            literals = [f"{int(v)}L" if self._fixed else _single(float(v)) for v in step.table]
            self.tables.append({"bits": step.q, "values": literals})
        return self._known[key]


def _single(value: float) -> str:
    """A float literal that reads back as the same float32."""
    text = np.format_float_scientific(np.float32(value), unique=True, trim="0")
    return f"{text}f"


def shifted(text: str, shift: int) -> str:
    """An int64 expression times 2^-shift, to nearest."""
    if shift > 0:
        return f"(({text} >> {shift - 1}) + 1) >> 1"
    return f"{text} * {1 << -shift}" if shift else text
