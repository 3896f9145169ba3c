"""One body for schedules that differ in their numbers only, such as those of several first-order parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gen.firmware.onboard_cpp import SchedulePrinter, five_bytes, pattern, rows, schedule_source, single
from gen.lowering.onboard.graph import INTEGERS, UNLABELLED
from gen.lowering.onboard.tape import OnboardComponent, Step

#: Steps whose table the body itself is built on; other tables are numbers that may differ.
_STRUCTURAL = (*INTEGERS, "positive_outside", "scale")


def schedule_sources(name: str, components: Sequence[OnboardComponent]) -> list[str]:
    """:func:`gen.firmware.onboard_cpp.schedule_source` of all components, alike ones with a common body."""
    groups: dict[object, list[OnboardComponent]] = {}
    for component in components:
        groups.setdefault(_structure(component), []).append(component)
    return [
        _SharedPrinter(name, group).text() if len(group) > 1 else schedule_source(name, group[0])
        for group in groups.values()
    ]


def _structure(component: OnboardComponent) -> object:
    steps = tuple(replace(s, label=UNLABELLED, table=_shape(s)) for s in component.steps)
    return component.arithmetic, component.domain, component.rates, component.steady, steps


def _shape(step: Step) -> tuple[float, ...]:
    """What of a step's table has to be alike."""
    if step.op == "power_series":
        return ()  # a shorter one is as well a longer one with zeros
    return step.table if step.op in _STRUCTURAL else (len(step.table),)


def _as_long(group: Sequence[OnboardComponent]) -> list[OnboardComponent]:
    """The components with power series of common lengths."""
    lengths = [max(len(s.table) for s in steps) for steps in zip(*(c.steps for c in group), strict=True)]
    return [
        replace(
            c,
            steps=tuple(
                replace(s, table=(0,) * (n - len(s.table)) + s.table) if s.op == "power_series" else s
                for s, n in zip(c.steps, lengths, strict=True)
            ),
        )
        for c in group
    ]


class _SharedPrinter(SchedulePrinter):
    """Prints the first component's tape; what the others have other numbers for comes from a structure in flash."""

    def __init__(self, name: str, group: Sequence[OnboardComponent]) -> None:
        self._group = _as_long(group)
        super().__init__(name, self._group[0])
        self._kind = f"{name}_{'_'.join(c.name for c in group)}"
        self._fields: list[int] = []

    def text(self) -> str:
        """Structure, its values, the common body, and a function for each component."""
        names = ", ".join(c.name for c in self._group)
        lines = self._body()
        result = ("uint32_t", "int32_t") if self._fixed else ("float", "float")
        fields = "".join(f"    {self._field(n)};  // {self._comment(self._component.steps[n])}\n" for n in self._fields)
        values = ",\n".join(f"    {{{self._values(c)}}}" for c in self._group)
        low, high = self._component.domain
        arguments = f"uint8_t x, {result[0]} *rate, {result[1]} *steady"
        calls = "".join(
            f"static inline void {self._name}_schedule_{c.name}({arguments}) {{\n"
            f"    {self._kind}_schedule(&{self._kind}[{i}], x, rate, steady);\n}}\n"
            for i, c in enumerate(self._group)
        )
        return "".join(self._tables) + (
            f"// What the schedules of {names} differ in.\n"
            f"struct {self._kind}_Numbers {{\n{fields}}};\n"
            f"static const {self._kind}_Numbers {self._kind}[{len(self._group)}] PROGMEM = {{\n{values}}};\n"
            f"// Nested rates and steady rise of {names} at |PWM| = x ({low}..{high}).\n"
            "static void __attribute__((noinline))\n"
            f"{self._kind}_schedule(const {self._kind}_Numbers *own, {arguments}) {{\n"
            + "\n".join(lines)
            + "\n}\n"
            + calls
        )

    def _field(self, number: int) -> str:
        step = self._component.steps[number]
        size = len(step.table)
        if step.op == "power_series":
            return f"uint8_t n{number}[{5 * size}]"
        return f"{'uint32_t' if self._fixed else 'float'} n{number}{f'[{size}]' if size > 1 else ''}"

    def _values(self, component: OnboardComponent) -> str:
        parts = []
        for n in self._fields:
            step = component.steps[n]
            each = 5 if step.op == "power_series" else 1
            numbers = [
                five_bytes(v) if each > 1 else pattern(v) if self._fixed else single(float(v)) for v in step.table
            ]
            lines = ",\n      ".join(rows(numbers, each))
            comment = f"  // {step.label.path}\n     " if step.label.path else ""
            parts.append(f"{comment}{{{lines}}}" if len(numbers) > 1 else f"{comment}{lines}")
        return ",".join(parts)

    def _float_expression(self, number: int, step: Step, a: list[str]) -> str:
        if not self._differs(number):
            return super()._float_expression(number, step, a)
        match step.op:
            case "row":
                return f"pgm_read_float(&own->n{number}[{a[0]}])"
            case "exponential":
                return f"{self._name}_exponential(own->n{number}, {a[0]})"
        return f"pgm_read_float(&own->n{number})"

    def _fixed_expression(self, number: int, step: Step, a: list[str]) -> str:
        if not self._differs(number):
            return super()._fixed_expression(number, step, a)
        kind = self._type(number)
        match step.op:
            case "row":
                return f"({kind})pgm_read_dword(&own->n{number}[{a[0]}])"
            case "power_series":
                return self._power_series(step, f"own->n{number}", len(step.table), a[0])
        return f"({kind})pgm_read_dword(&own->n{number})"

    def _differs(self, number: int) -> bool:
        """Whether a step's numbers are not the same for all; they then become a field."""
        op = self._component.steps[number].op
        if (
            op not in ("constant", "row", "exponential", "power_series")
            or len({c.steps[number].table for c in self._group}) == 1
        ):
            return False
        self._fields.append(number)
        return True

    def _comment(self, step: Step) -> str:
        return "; ".join(part for part in (step.label.text or step.op, step.label.unit) if part)
