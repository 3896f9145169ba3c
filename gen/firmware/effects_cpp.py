"""Print the effects' tapes as C++, and tell the templates the rest."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from gen.lowering.effects.program import (
    GUARD_BITS,
    KELVIN_BITS,
    KELVIN_LIMIT,
    WEIGHT_BITS,
    EffectComponent,
    EffectsProgram,
)
from gen.lowering.effects.tape import Step, Tape
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import CARRY_FACTOR, RESIDUE_BITS, WORD_BITS
from gen.lowering.float32 import FloatComponent
from gen.lowering.program import Program
from gen.reference.lanes import word_bits

_PER_LINE = 8


def channel_names(effects: EffectsProgram) -> list[str]:
    """Each channel's name in the C++ enumeration; columns that differ in case or other signs alone are numbered."""
    names = ["AMBIENT"]
    for number, channel in enumerate(effects.channels[1:], start=1):
        name = re.sub(r"[^A-Z0-9]+", "_", channel.column.upper()).strip("_") or "COLUMN"
        names.append(f"{name}_{number}" if name in names else name)
    return names


def effects_context(program: Program) -> dict[str, Any] | None:
    """What the templates need of the effects; None without any.

    Parameters
    ----------
    program
        What is emitted.
    """
    effects = program.effects
    if effects is None:
        return None
    places = {
        member: (shape.identifier, f"{shape.place}[{index}]")
        for shape in program.shapes
        for index, member in enumerate(shape.members)
    }
    tracked: list[dict[str, Any]] = []
    for index, limits in zip(effects.tracked, effects.rise_limits, strict=True):
        lowered = program.components[index]
        assert isinstance(lowered, FixedComponent | FloatComponent)
        shape, place = places[index]
        part = effects.component(index)
        tracked.append(
            {
                "name": lowered.name,
                "place": place,
                "shape": shape,
                "limits": limits,
                "base": _shifted(f"(int64_t)${{model}}.state.{place}.x[0].hi", word_bits(lowered) - KELVIN_BITS),
                "felt": effects.felt.index(index) if index in effects.felt else None,
                "part": None if part is None else _component(effects, part, lowered),
            }
        )
    return {
        "tracked": tracked,
        "parts": [component for component in tracked if component["part"]],
        "states": any(part.followers or part.inners or part.lags for part in effects.components),
        "heating": [c["name"] for c in tracked if c["part"] and c["part"]["heats"]],
        "finer": [c["name"] for c in tracked if c["felt"] is not None and c["part"] and c["part"]["sixth"]],
        "shown": [component["name"] for component in tracked if component["part"]],
        "felt": [component for component in tracked if component["felt"] is not None],
        "channels": [
            {
                "id": name,
                "column": channel.column,
                "low": channel.low,
                "high": channel.high,
                "neutral": channel.neutral,
            }
            for name, channel in zip(channel_names(effects), effects.channels, strict=True)
        ],
        "elapsed_limit": effects.elapsed_limit,
        "kelvin_bits": KELVIN_BITS,
        "kelvin_end": KELVIN_LIMIT << KELVIN_BITS,
        "start_end": KELVIN_LIMIT * 1000,
        "weight_bits": WEIGHT_BITS,
        "carry_factor": CARRY_FACTOR,
        "chain_bits": WORD_BITS + GUARD_BITS,
        "word_bits": WORD_BITS + GUARD_BITS - RESIDUE_BITS,
    }


def _component(
    effects: EffectsProgram, part: EffectComponent, lowered: FixedComponent | FloatComponent
) -> dict[str, Any]:
    name = lowered.name
    printer = _Printer(name, effects)
    drives = printer.body(part.drives)
    lines = []
    ends = [f"{KELVIN_LIMIT << KELVIN_BITS}"] * len(part.drives.outputs)
    bits = [KELVIN_BITS] * len(ends)
    targets = [f"target[{number - (part.chain is not None)}]" for number in range(len(ends))]
    if part.chain is not None:
        ends[0], bits[0], targets[0] = str(part.chain.limit), part.chain.fraction_bits, "*drive"
    for number, (place, end, q) in enumerate(zip(targets, ends, bits, strict=True)):
        lines.append(f"{place} = {printer.output(part.drives, number, q, end, wide=place == '*drive')};")
    start = printer.body(part.start)
    begins = [f"const int32_t rise_mK = {printer.output(part.start, 0, 0, str(1 << 30))};"]
    number = 1
    if part.chain is not None:
        text = printer.output(part.start, number, part.chain.fraction_bits, str(part.chain.limit), wide=True)
        begins.append(f"{name}_rest(e, {text});")
        number += 1
    for i in range(len(part.followers)):
        text = printer.output(part.start, number, KELVIN_BITS, str(KELVIN_LIMIT << KELVIN_BITS))
        begins.append(f"e->own[{i}] = above({text});")
        number += 1
    for i, inner in enumerate(part.inners):
        q = inner.fraction_bits
        most = KELVIN_LIMIT << q if q == KELVIN_BITS else 1 << WEIGHT_BITS
        begins.append(f"e->inner[{i}] = above({printer.output(part.start, number, q, str(most))});")
        number += 1
    readings = []
    printer.reading()
    for tape in part.readings:
        body = printer.body(tape)
        last = printer.output(tape, 0, KELVIN_BITS, str(KELVIN_LIMIT << KELVIN_BITS))
        readings.append({"lines": body, "result": last, "timed": ("elapsed", 0) in tape.operands})
    layout = lowered.layout if isinstance(lowered, FixedComponent) else None
    return {
        "order": lowered.order,
        "substeps": lowered.substeps,
        "saturates": lowered.saturates,
        "layout": layout,
        "chain": part.chain,
        "added": _shifted(
            "(e->x[0] >> 16)" if layout else "(int64_t)e->chain.x[0].hi", part.chain.fraction_bits - KELVIN_BITS
        )
        if part.chain is not None
        else None,
        "heats": part.heats,
        "followers": part.followers,
        "inners": part.inners,
        "lags": part.lags,
        "notes": part.notes,
        "sixth": part.sixth,
        "driven": _shifted(f"((int64_t){name}_drive - {name}_first)", part.chain.fraction_bits - KELVIN_BITS)
        if part.chain is not None
        else None,
        "drives": drives + lines,
        "moment": any(kind in ("rise", "reverse") for kind, _ in part.drives.operands)
        or any(step.op == "row" for step in part.drives.steps),
        "inner_used": any(kind == "inner" for kind, _ in part.drives.operands),
        "start": start + begins,
        "readings": readings,
        "tables": printer.tables,
    }


def _shifted(text: str, shift: int) -> str:
    """An int64 expression times 2^-shift, to nearest."""
    if shift > 0:
        return f"(({text} >> {shift - 1}) + 1) >> 1"
    return f"{text} * {1 << -shift}" if shift else text


class _Printer:
    """Prints tapes of one component; tables by |PWM| are shared among them."""

    def __init__(self, name: str, effects: EffectsProgram) -> None:
        self._name, self._effects = name, effects
        self._fixed = effects.arithmetic == "fixed"
        self._known: dict[tuple[Any, ...], str] = {}
        self._reading = False
        self.tables: list[str] = []

    def reading(self) -> None:
        """From now on the rise is what a sensor is held to."""
        self._reading = True

    def body(self, tape: Tape) -> list[str]:
        """One line for each step that is more than a number."""
        texts, lines = self._texts(tape)
        kind = "int32_t" if self._fixed else "float"
        return [f"const {kind} n{number} = {texts[number]};" for number in lines]

    def output(self, tape: Tape, number: int, bits: int, end: str, *, wide: bool = False) -> str:
        """An output as words of 2^-bits, within +/- end."""
        texts, lines = self._texts(tape)
        at = tape.outputs[number]
        value = f"n{at}" if at in lines else texts[at]
        if not self._fixed:
            return f"words({value}, {_single(2.0**bits)}, {end}L)"
        shift = tape.output_bits(number) - bits
        text = f"held({_shifted(f'(int64_t){value}', shift)}, -INT64_C({end}), INT64_C({end}))"
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
            kind = "int32_t" if self._fixed else "float"
            numbers = [f"{int(v)}L" if self._fixed else _single(float(v)) for v in step.table]
            rows = ",\n".join("    " + ", ".join(numbers[i : i + _PER_LINE]) for i in range(0, len(numbers), _PER_LINE))
            unit = f"  // 2^-{step.q}" if self._fixed else ""
            self.tables.append(f"static const {kind} {self._known[key]}[] PROGMEM = {{{unit}\n{rows},\n}};\n")
        return self._known[key]


def _single(value: float) -> str:
    """A float literal that reads back as the same float32."""
    text = np.format_float_scientific(np.float32(value), unique=True, trim="0")
    return f"{text}f"
