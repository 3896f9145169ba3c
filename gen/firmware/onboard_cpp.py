"""Print the tapes of the onboard schedule as C++ (gnu++11), a line a step.

The text needs ``{name}_onboard_math.h`` (:func:`math_header`) and ``{name}_platform.h``, which defines ``PROGMEM``,
``pgm_read_byte``, ``pgm_read_dword`` and ``pgm_read_float`` (on the host: nothing, and plain reads).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import log2

import jinja2
import numpy as np

from gen.lowering.kinds import Arithmetic
from gen.lowering.onboard.graph import INTEGERS
from gen.lowering.onboard.tape import DIVIDE_SHIFT, OnboardComponent, Step
from gen.model.dynamics import MAX_PWM
from gen.templating import folder

_OPERATORS = {"mul": "*", "div": "/", "add": "+", "sub": "-"}
#: What a step calls, and what that calls in turn.
_HELPERS = {
    "div_signed": ("div_signed", "div"),
    "mul_modulo": ("mul",),
    "mul_signed": ("mul_signed", "mul"),
    "mul_signed_modulo": ("mul_signed", "mul"),
}


def helpers(components: Sequence[OnboardComponent]) -> frozenset[str]:
    """The helpers of the math header that the tapes call."""
    return frozenset(h for c in components for step in c.steps for h in _HELPERS.get(step.op, (step.op,)))


def math_header(name: str, arithmetic: Arithmetic, called: frozenset[str]) -> str:
    """The text of ``{name}_onboard_math.h`` with the helpers that are called (:func:`helpers`), and no others."""
    text = (folder("project") / "lib/model/src/onboard_math.h.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, keep_trailing_newline=True, autoescape=False)
    return environment.from_string(text).render(name=name, arithmetic=arithmetic, helpers=called)


def schedule_source(name: str, component: OnboardComponent) -> str:
    """Tables and function of one component.

    ``static void {name}_schedule_{component}(uint8_t x, uint32_t *rate, int32_t *steady)``, in float32 with
    ``float *``; x must lie in the component's domain.
    """
    return SchedulePrinter(name, component).text()


class SchedulePrinter:
    """Prints one component's tape.

    Parameters
    ----------
    name, component
        As of :func:`schedule_source`.
    """

    def __init__(self, name: str, component: OnboardComponent) -> None:
        self._name = name
        self._component = component
        self._fixed = component.arithmetic == "fixed"
        self._prefix = f"{name}_{component.name}"
        self._tables: list[str] = []
        self._lines: list[str] = []

    def text(self) -> str:
        """See :func:`schedule_source`."""
        component = self._component
        lines = self._body()
        rate, steady = ("uint32_t", "int32_t") if self._fixed else ("float", "float")
        head = (
            f"// Nested rates and steady rise of {component.name} at |PWM| = x"
            f" ({component.domain[0]}..{component.domain[1]}).\n"
            f"static void {self._name}_schedule_{component.name}(uint8_t x, {rate} *rate, {steady} *steady) {{\n"
        )
        return "".join(self._tables) + head + "\n".join(lines) + "\n}\n"

    def _body(self) -> list[str]:
        component = self._component
        for number, step in enumerate(component.steps):
            if step.op == "input" and step.table == (0, MAX_PWM):
                continue
            line = f"    const {self._type(number)} n{number} = {self._expression(number, step)};"
            self._lines.append(f"{line}  // {self._comment(step)}")
        for i, number in enumerate(component.rates):
            value = f"(uint32_t)n{number}" if self._fixed else f"n{number}"
            self._lines.append(f"    rate[{i}] = {value};  // R{i}, 1/step{self._format(number)}")
        self._lines.append(f"    *steady = n{component.steady};  // S, K{self._format(component.steady)}")
        if not any(s.op == "input" for s in component.steps):
            self._lines.insert(0, "    (void)x;")
        return self._lines

    def _type(self, number: int) -> str:
        step = self._component.steps[number]
        if step.op in INTEGERS:
            return "uint8_t"
        if not self._fixed:
            return "float"
        return "uint32_t" if step.unsigned else "int32_t"

    def _ref(self, number: int) -> str:
        step = self._component.steps[number]
        return "x" if step.op == "input" and step.table == (0, MAX_PWM) else f"n{number}"

    def _as_unsigned(self, step: Step, place: int) -> str:
        number = step.args[place]
        return self._ref(number) if self._component.steps[number].unsigned else f"(uint32_t){self._ref(number)}"

    def _format(self, number: int) -> str:
        return f", Q{self._component.steps[number].q}" if self._fixed else ""

    def _comment(self, step: Step) -> str:
        label = step.label
        parts = [label.text or step.op]
        if label.unit:
            parts.append(label.unit)
        if self._fixed and step.op not in INTEGERS:
            parts.append(f"Q{step.q}")
        if label.path:
            parts.append(label.path)
        return "; ".join(parts)

    def _table(self, number: int, kind: str, values: Sequence[str], each: int = 1) -> str:
        """Print a table; every one of the values is ``each`` numbers."""
        identifier = f"{self._prefix}_n{number}"
        lines = rows(values, each)
        comment = self._comment(self._component.steps[number])
        body = ",\n    ".join(lines)
        self._tables.append(
            f"// {comment}\nstatic const {kind} {identifier}[{len(values) * each}] PROGMEM = {{\n    {body}}};\n"
        )
        return identifier

    def _expression(self, number: int, step: Step) -> str:
        a = [self._ref(i) for i in step.args]
        if step.op == "input":
            return f"(uint8_t){_held('x', step)}"
        if step.op == "segment":
            return f"(uint8_t)({interval(a[0], [int(k) for k in step.table[1:-1]])})"
        if step.op == "local":
            starts = self._table(number, "uint8_t", [str(int(k)) for k in step.table[:-1]])
            return f"(uint8_t)({_held(a[0], step)} - pgm_read_byte(&{starts}[{a[1]}]))"
        if step.op == "positive_outside":
            low, high = int(step.table[0]), int(step.table[1])
            tests = ([f"{a[1]} < {low}"] if low > 0 else []) + ([f"{a[1]} > {high}"] if high < MAX_PWM else [])
            below = f"{a[0]} < 0" if self._fixed else f"{self._name}_negative({a[0]})"
            return f"({below} && ({' || '.join(tests)})) ? 0 : {a[0]}"
        return self._fixed_expression(number, step, a) if self._fixed else self._float_expression(number, step, a)

    def _fixed_expression(self, number: int, step: Step, a: list[str]) -> str:
        name, s = self._name, step.shift
        match step.op:
            case "constant":
                return f"{int(step.table[0])}{'UL' if step.unsigned else 'L'}"
            case "row":
                table = self._table(number, "uint32_t", [pattern(v) for v in step.table])
                return f"(int32_t)pgm_read_dword(&{table}[{a[0]}])"
            case "power_series":
                table = self._table(number, "uint8_t", [five_bytes(v) for v in step.table], 5)
                return self._power_series(step, table, len(step.table), a[0])
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
                return self._sum(step, a)
            case "neg":
                return f"-{a[0]}"
            case "shr":
                return self._rounded_shift(step, a[0])
            case "floor":
                return f"{a[0]} >> {s}"
            case "shl":
                shifted = f"(uint32_t){a[0]} << {s}"
                return shifted if step.unsigned else f"(int32_t)({shifted})"
        raise ValueError(f"no step {step.op}")

    def _sum(self, step: Step, a: list[str]) -> str:
        """A sum or difference; where words are unsigned or may wrap, it is taken modulo 2^32."""
        sign = "-" if step.op.startswith("sub") else "+"
        mixed = step.unsigned or any(self._component.steps[i].unsigned for i in step.args)
        if not mixed and not step.op.endswith("modulo"):
            return f"{a[0]} {sign} {a[1]}"
        modulo = f"{self._as_unsigned(step, 0)} {sign} {self._as_unsigned(step, 1)}"
        return modulo if step.unsigned else f"(int32_t)({modulo})"

    def _rounded_shift(self, step: Step, value: str) -> str:
        if self._component.steps[step.args[0]].unsigned:
            return f"(int32_t)((({value} >> {step.shift - 1}) + 1u) >> 1)"
        return f"{self._name}_round_shift({value}, {step.shift - 1})"

    def _power_series(self, step: Step, table: str, terms: int, x: str) -> str:
        u = f"(uint8_t)({MAX_PWM} - {x})" if step.shift else x
        return f"{self._name}_power_series({table}, {terms}, {u})"

    def _float_expression(self, number: int, step: Step, a: list[str]) -> str:
        match step.op:
            case "constant":
                return single(float(step.table[0]))
            case "row":
                table = self._table(number, "float", [single(float(v)) for v in step.table])
                return f"pgm_read_float(&{table}[{a[0]}])"
            case "exponential":
                table = self._table(number, "float", [single(float(v)) for v in step.table])
                return f"{self._name}_exponential({table}, {a[0]})"
            case "times":
                return f"{a[0]} * (float){a[1]}"
            case "scale":
                return f"{self._name}_times_power<{round(log2(float(step.table[0])))}>({a[0]})"
            case "neg":
                return f"-{a[0]}"
            case "mul" | "div" | "add" | "sub":
                return f"{a[0]} {_OPERATORS[step.op]} {a[1]}"
        raise ValueError(f"no step {step.op}")


def _held(x: str, step: Step) -> str:
    low, high = int(step.table[0]), int(step.table[-1])
    text = x
    if high < MAX_PWM:
        text = f"({x} > {high} ? {high} : {text})"
    if low > 0:
        text = f"({x} < {low} ? {low} : {text})"
    return text


def pattern(value: float) -> str:
    """A literal of a word's 32 bits."""
    return f"0x{int(value) & 0xFFFFFFFF:08X}UL"


def five_bytes(value: float) -> str:
    """A number of 40 bits, lowest byte first."""
    return ", ".join(f"0x{byte:02X}" for byte in int(value).to_bytes(5, "little", signed=True))


def rows(values: Sequence[str], each: int = 1) -> list[str]:
    """A table's lines, at most eight numbers in each."""
    size = max(1, 8 // each)
    return [", ".join(values[i : i + size]) for i in range(0, len(values), size)]


def single(value: float) -> str:
    """A float literal that reads back as the same float32."""
    text = np.format_float_scientific(np.float32(value), unique=True, trim="0")
    return f"{text}f"


def interval(x: str, knots: list[int], first: int = 0) -> str:
    """How many of the knots, in ascending order, x has reached, plus `first`: a binary search as one expression.

    A sum of comparisons would say the same, but g++ 12 at -O2 adds up some of them wrongly (8 or 16 at a time, where it
    takes them as vectors).
    """
    if not knots:
        return str(first)
    middle = len(knots) // 2
    below, above = interval(x, knots[:middle], first), interval(x, knots[middle + 1 :], first + middle + 1)
    return f"({x} < {knots[middle]} ? {below} : {above})"
