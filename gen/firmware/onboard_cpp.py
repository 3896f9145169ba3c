"""Print the tapes of the onboard schedule as C++ (gnu++11), a line a step.

The text needs ``{name}_onboard_math.h`` (:func:`math_header`) and ``{name}_platform.h``, which defines ``PROGMEM``,
``pgm_read_byte``, ``pgm_read_dword`` and ``pgm_read_float`` (on the host: nothing, and plain reads).
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace
from importlib.resources import files

import jinja2
import numpy as np

from gen.lowering.onboard.graph import INTEGERS, UNLABELLED
from gen.lowering.onboard.tape import DIVIDE_SHIFT, OnboardComponent, Step
from gen.lowering.program import Arithmetic

_OPERATORS = {"mul": "*", "div": "/", "add": "+", "sub": "-"}
#: Steps whose numbers may differ between components that share a function.
_CONSTANTS = ("constant", "row", "exponential", "scale")
#: What a step calls, and what that calls in turn.
_HELPERS = {
    "div_signed": ("div_signed", "div"),
    "mul_modulo": ("mul",),
    "mul_signed": ("mul_signed", "mul"),
    "mul_signed_modulo": ("mul_signed", "mul"),
    "exponential": ("exponential", "mul"),
}


def helpers(components: Sequence[OnboardComponent]) -> frozenset[str]:
    """The helpers of the math header that the tapes call."""
    return frozenset(h for c in components for step in c.steps for h in _HELPERS.get(step.op, (step.op,)))


def math_header(name: str, arithmetic: Arithmetic, called: frozenset[str]) -> str:
    """The text of ``{name}_onboard_math.h`` with the helpers that are called (:func:`helpers`), and no others."""
    text = files("templates").joinpath("lib/model/src/onboard_math.h.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, keep_trailing_newline=True, autoescape=False)
    return environment.from_string(text).render(name=name, arithmetic=arithmetic, helpers=called)


def schedule_sources(name: str, components: Sequence[OnboardComponent]) -> list[str]:
    """Tables and functions of all components; those whose tapes differ in constants only share one function.

    Each component gets ``static void {name}_schedule_{component}(uint8_t x, uint32_t *rate, int32_t *steady)``, in
    float32 with ``float *``; x must lie in the component's domain.
    """
    groups: dict[Hashable, list[OnboardComponent]] = {}
    for component in components:
        groups.setdefault(_structure(component), []).append(component)
    return [_Printer(name, group).text() for group in groups.values()]


def _structure(component: OnboardComponent) -> Hashable:
    """What components must have in common to share a function."""
    steps = tuple(
        replace(s, label=UNLABELLED, table=(len(s.table),) if s.op in _CONSTANTS else s.table) for s in component.steps
    )
    return component.arithmetic, component.domain, steps, component.rates, component.steady


class _Printer:
    def __init__(self, name: str, members: Sequence[OnboardComponent]) -> None:
        self._name = name
        self._members = members
        self._component = members[0]
        self._fixed = self._component.arithmetic == "fixed"
        self._prefix = f"{name}_{self._component.name}"
        self._own = [
            number
            for number, steps in enumerate(zip(*(m.steps for m in members), strict=True))
            if any(step.table != steps[0].table for step in steps)
        ]
        self._tables: list[str] = []
        self._lines: list[str] = []

    def text(self) -> str:
        component = self._component
        for number, step in enumerate(component.steps):
            if step.op == "input" and step.table == (0, 255):
                continue
            line = f"    const {self._type(number)} n{number} = {self._expression(number, step)};"
            self._lines.append(f"{line}  // {self._comment(number)}")
        for i, number in enumerate(component.rates):
            value = f"(uint32_t)n{number}" if self._fixed else f"n{number}"
            self._lines.append(f"    rate[{i}] = {value};  // R{i}, 1/step{self._format(number)}")
        self._lines.append(f"    *steady = n{component.steady};  // S, K{self._format(component.steady)}")
        if not any(s.op == "input" for s in component.steps):
            self._lines.insert(0, "    (void)x;")
        rate, steady = ("uint32_t", "int32_t") if self._fixed else ("float", "float")
        results = f"{rate} *rate, {steady} *steady"
        where = f"at |PWM| = x ({component.domain[0]}..{component.domain[1]})"
        body = "\n".join(self._lines) + "\n}\n"
        if not self._own:
            return "".join(self._tables) + (
                f"// Nested rates and steady rise of {component.name} {where}.\n"
                f"static void {self._name}_schedule_{component.name}(uint8_t x, {results}) {{\n{body}"
            )
        names = ", ".join(m.name for m in self._members)
        text = [
            self._own_constants(),
            *self._tables,
            f"// Nested rates and steady rise of {names} {where}, which differ in `own` only.\n",
            f"static void __attribute__((noinline)) {self._prefix}_shared(uint8_t x, const {self._prefix}_Own *own,"
            f" {results}) {{\n{body}",
        ]
        for place, member in enumerate(self._members):
            text.append(
                f"static inline void {self._name}_schedule_{member.name}(uint8_t x, {results}) {{\n"
                f"    {self._prefix}_shared(x, &{self._prefix}_own[{place}], rate, steady);\n}}\n"
            )
        return "".join(text)

    def _own_constants(self) -> str:
        """What each member has of its own, in flash."""
        fields, values = [], [[f"    {{  // {m.name}\n"] for m in self._members]
        for number in self._own:
            size = len(self._component.steps[number].table)
            kind = "uint32_t" if self._fixed else "float"
            fields.append(f"    {kind} n{number}{f'[{size}]' if size > 1 else ''};  // {self._comment(number)}\n")
            for lines, member in zip(values, self._members, strict=True):
                words = [self._word(v) for v in member.steps[number].table]
                rows = ",\n         ".join(", ".join(words[i : i + 8]) for i in range(0, size, 8))
                lines.append(f"        {f'{{{rows}}}' if size > 1 else rows},\n")
        initial = "".join("".join(lines) + "    },\n" for lines in values)
        return (
            f"struct {self._prefix}_Own {{\n{''.join(fields)}}};\n"
            f"static const {self._prefix}_Own {self._prefix}_own[{len(self._members)}] PROGMEM = {{\n{initial}}};\n"
        )

    def _word(self, value: float) -> str:
        return _pattern(value) if self._fixed else _single(float(value))

    def _type(self, number: int) -> str:
        step = self._component.steps[number]
        if step.op in INTEGERS:
            return "uint8_t"
        if not self._fixed:
            return "float"
        return "uint32_t" if step.unsigned else "int32_t"

    def _ref(self, number: int) -> str:
        step = self._component.steps[number]
        return "x" if step.op == "input" and step.table == (0, 255) else f"n{number}"

    def _as_unsigned(self, step: Step, place: int) -> str:
        number = step.args[place]
        return self._ref(number) if self._component.steps[number].unsigned else f"(uint32_t){self._ref(number)}"

    def _format(self, number: int) -> str:
        return f", Q{self._component.steps[number].q}" if self._fixed else ""

    def _comment(self, number: int) -> str:
        step = self._component.steps[number]
        label = step.label
        parts = [label.text or step.op]
        if label.unit:
            parts.append(label.unit)
        if self._fixed and step.op not in INTEGERS:
            parts.append(f"Q{step.q}")
        paths = dict.fromkeys(m.steps[number].label.path for m in self._members)
        if label.path:
            parts.append(", ".join(paths))
        return "; ".join(parts)

    def _table(self, number: int, kind: str, values: Sequence[str]) -> str:
        if number in self._own:
            return f"own->n{number}"
        identifier = f"{self._prefix}_n{number}"
        lines = [", ".join(values[i : i + 8]) for i in range(0, len(values), 8)]
        comment = self._comment(number)
        body = ",\n    ".join(lines)
        self._tables.append(
            f"// {comment}\nstatic const {kind} {identifier}[{len(values)}] PROGMEM = {{\n    {body}}};\n"
        )
        return identifier

    def _constant(self, number: int, text: str, kind: str = "float") -> str:
        """A constant, or where a member has its own."""
        if number not in self._own:
            return text
        return f"({kind})pgm_read_dword(&own->n{number})" if self._fixed else f"pgm_read_float(&own->n{number})"

    def _expression(self, number: int, step: Step) -> str:
        a = [self._ref(i) for i in step.args]
        if step.op == "input":
            return f"(uint8_t){_held('x', step)}"
        if step.op == "upper":
            return f"(uint8_t)({a[0]} >> 4)"
        if step.op == "segment":
            inner = step.table[1:-1]
            return f"(uint8_t)({' + '.join(f'({a[0]} >= {int(k)})' for k in inner) or '0'})"
        if step.op == "local":
            starts = self._table(number, "uint8_t", [str(int(k)) for k in step.table[:-1]])
            return f"(uint8_t)({_held(a[0], step)} - pgm_read_byte(&{starts}[{a[1]}]))"
        if step.op == "positive_outside":
            low, high = int(step.table[0]), int(step.table[1])
            tests = ([f"{a[1]} < {low}"] if low > 0 else []) + ([f"{a[1]} > {high}"] if high < 255 else [])
            return f"({a[0]} < 0 && ({' || '.join(tests)})) ? 0 : {a[0]}"
        return self._fixed_expression(number, step, a) if self._fixed else self._float_expression(number, step, a)

    def _fixed_expression(self, number: int, step: Step, a: list[str]) -> str:
        name, s = self._name, step.shift
        match step.op:
            case "constant":
                kind = "uint32_t" if step.unsigned else "int32_t"
                return self._constant(number, f"{int(step.table[0])}{'UL' if step.unsigned else 'L'}", kind)
            case "row":
                table = self._table(number, "uint32_t", [_pattern(v) for v in step.table])
                return f"(int32_t)pgm_read_dword(&{table}[{a[0]}])"
            case "exponential":
                table = self._table(number, "uint32_t", [_pattern(v) for v in step.table])
                return f"{name}_exponential({table}, {a[0]}, {s})"
            case "times":
                return f"{name}_times({a[0]}, {a[1]}, {s})"
            case "mul" | "mul_modulo":
                return f"{name}_mul_shift({a[0]}, {self._as_unsigned(step, 1)}, {s})"
            case "mul_signed" | "mul_signed_modulo":
                return f"{name}_mul_signed({a[0]}, {a[1]}, {s})"
            case "div":
                rest = f"{self._as_unsigned(step, 1)}, {step.shift - DIVIDE_SHIFT}, {str(step.round).lower()}"
                return f"{name}_divide({self._as_unsigned(step, 0)}, {rest})"
            case "div_signed":
                rest = f"{self._as_unsigned(step, 1)}, {step.shift - DIVIDE_SHIFT}, {str(step.round).lower()}"
                return f"{name}_divide_signed({a[0]}, {rest})"
            case "add" | "sub" | "add_modulo" | "sub_modulo":
                sign = "-" if step.op.startswith("sub") else "+"
                mixed = step.unsigned or any(self._component.steps[i].unsigned for i in step.args)
                if not mixed and not step.op.endswith("modulo"):
                    return f"{a[0]} {sign} {a[1]}"
                modulo = f"{self._as_unsigned(step, 0)} {sign} {self._as_unsigned(step, 1)}"
                return modulo if step.unsigned else f"(int32_t)({modulo})"
            case "neg":
                return f"-{a[0]}"
            case "shr":
                if self._component.steps[step.args[0]].unsigned:
                    return f"(int32_t)((({a[0]} >> {s - 1}) + 1u) >> 1)"
                return f"{name}_round_shift({a[0]}, {s - 1})"
            case "floor":
                return f"{a[0]} >> {s}"
            case "shl":
                shifted = f"(uint32_t){a[0]} << {s}"
                return shifted if step.unsigned else f"(int32_t)({shifted})"
        raise ValueError(f"no step {step.op}")

    def _float_expression(self, number: int, step: Step, a: list[str]) -> str:
        match step.op:
            case "constant":
                return self._constant(number, _single(float(step.table[0])))
            case "row":
                table = self._table(number, "float", [_single(float(v)) for v in step.table])
                return f"pgm_read_float(&{table}[{a[0]}])"
            case "exponential":
                table = self._table(number, "float", [_single(float(v)) for v in step.table])
                return f"{self._name}_exponential({table}, {a[0]})"
            case "times":
                return f"{a[0]} * (float){a[1]}"
            case "scale":
                return f"{a[0]} * {self._constant(number, _single(float(step.table[0])))}"
            case "neg":
                return f"-{a[0]}"
            case "mul" | "div" | "add" | "sub":
                return f"{a[0]} {_OPERATORS[step.op]} {a[1]}"
        raise ValueError(f"no step {step.op}")


def _held(x: str, step: Step) -> str:
    low, high = int(step.table[0]), int(step.table[-1])
    text = x
    if high < 255:
        text = f"({x} > {high} ? {high} : {text})"
    if low > 0:
        text = f"({x} < {low} ? {low} : {text})"
    return text


def _pattern(value: float) -> str:
    return f"0x{int(value) & 0xFFFFFFFF:08X}UL"


def _single(value: float) -> str:
    """A float literal that reads back as the same float32."""
    text = np.format_float_scientific(np.float32(value), unique=True, trim="0")
    return f"{text}f"
