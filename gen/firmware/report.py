"""The report of an emitted project: one HTML file without outside links, the same bytes everywhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, singledispatch
from math import floor, log2
from typing import Any, Literal

import numpy as np
from jinja2 import Environment

from gen.coefficients import Coefficients
from gen.firmware.alarm_text import alarm_texts
from gen.firmware.contract import contract
from gen.firmware.effects_report import effect_rows
from gen.firmware.model_charts import course_chart, response_charts, schedule_charts
from gen.firmware.network_report import curve_charts, drawing, network_constants, state_words, tabulated
from gen.firmware.step_responses import levels, responses
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import RESIDUE_BITS, WORD_BITS
from gen.lowering.float32 import LOW_BITS, FloatComponent
from gen.lowering.program import AnyComponent, Program
from gen.lowering.recursion.dynamics import domain_rows
from gen.lowering.recursion.guarantee import rounded_up
from gen.model import Component
from gen.model.network_parts import Node
from gen.pages.charts import plain, power, scientific
from gen.pages.environment import page_environment
from gen.version import __version__

Cells = tuple[str, ...]


@dataclass(frozen=True)
class Verdict:
    """The report's first line: its state gives the colour."""

    state: Literal["equal", "different", "none"]
    headline: str
    detail: str
    mismatch: str = ""


def report_html(coefficients: Coefficients, program: Program, verification: Mapping[str, Any] | None) -> str:
    """Write the report.

    Parameters
    ----------
    coefficients, program
        What is emitted.
    verification
        What ``gen verify --json`` found, or None; one of another coefficient file counts as None.
    """
    if verification is not None and verification.get("coefficients_sha256") != coefficients.sha256:
        verification = None
    combinations = verification["combinations"] if verification is not None else []
    wanted = (program.arithmetic, program.schedule)
    own = next((c for c in combinations if (c["arithmetic"], c["schedule"]) == wanted), None)
    limit, limit_name = coefficients.accuracy.limit(program.arithmetic)
    whole_run = own.get("step_errors") if own is not None else None
    steps = responses(replace(program, effects=None), whole_run)  # of the baseline: effects have no such exact ones
    network, known = program.network, program.model.network
    parts: tuple[Component | Node, ...] = program.model.components if known is None else known.sensed
    labels = [f"{pwm / program.model.full_scale:.0%}" for pwm in levels(program.model)]
    return (
        _environment()
        .get_template("report.html.j2")
        .render(
            version=__version__,
            coefficients=coefficients,
            program=program,
            verdict=verdict(own),
            own=own,
            combinations=combinations,
            comparisons=comparisons(combinations),
            compared_words=count_words(combinations),
            targets=targets_of(combinations),
            course=course_chart(*own["error_course"].values()) if own and "error_course" in own else None,
            contract=contract(program),
            limit_name=limit_name,
            limit=limit,
            horizon=round(steps[0].times[-1]),
            window=steps[0].ran[-1],
            responses=[
                (part, response_charts(part.name, labels, step)) for part, step in zip(parts, steps, strict=True)
            ],
            drawing=drawing(program) if network is not None else None,
            curves=curve_charts(program) if network is not None else [],
            schedules=[(part, schedule_charts(program.model, part)) for part in program.model.components],
            words=[row for component in program.components for row in words(component)],
            states=state_words(network) if network is not None else [],
            constants=constants(program) if network is None else network_constants(program),
            rows=_rows(program) if network is None else tabulated(program),
            alarms=alarm_texts(coefficients),
            effects=effect_rows(coefficients, own),
            affected=[part.name for part in program.effects.components] if program.effects is not None else [],
        )
    )


@cache
def _environment() -> Environment:
    return page_environment(count=_count, up=_up, sci=scientific, num=plain)


def _magnitudes(component: AnyComponent) -> list[float]:
    """Largest magnitude of x1 .. xn, rounded up; 0 where none is proven."""
    if component.proof is None:
        return [0.0] * component.order
    proof = component.proof.describe()
    return [float(max(map(abs, proof["rise_range_K"]))), *proof["increment_range_K"]]


def _range(component: AnyComponent, i: int) -> str:
    if component.proof is None:
        return "none proven"
    proof = component.proof.describe()
    return _span(*proof["rise_range_K"]) if i == 0 else f"±{_up(proof['increment_range_K'][i - 1])}"


def _span(low: float, high: float) -> str:
    return f"{scientific(low)} .. {scientific(high)}"


def _headroom(bits: float) -> str:
    return f"{floor(bits * 10.0 + 1e-6) / 10.0:.1f}"


def _count(value: float) -> str:
    """Digits in groups of three, with narrow no-break spaces."""
    return f"{value:,}".replace(",", "\u202f")


def _up(value: float) -> str:
    """Two significant digits, rounded up."""
    return scientific(rounded_up(value))


def verdict(own: Mapping[str, Any] | None) -> Verdict:
    """The verdict on the emitted combination, or that there is none."""
    if own is None or not own["targets"]:
        return Verdict("none", "Not verified yet", "run gen verify for this coefficient file, then build again.")
    targets = own["targets"]
    differing = sum(target["differing"] for target in targets)
    names = dict.fromkeys(target["target"].partition(", ")[0] for target in targets)
    detail = (
        f"{_count(sum(target['samples'] for target in targets))} samples and "
        f"{_count(sum(target['words'] for target in targets))} words compared, {_count(differing)} "
        f"word{'' if differing == 1 else 's'} differ{'s' if differing == 1 else ''}; targets: {', '.join(names)}."
    )
    refuted = own.get("refuted")
    if own.get("proven_K"):
        detail += f" The bounds were proven anew from the C++: {_count(own['inequalities'])} inequalities hold."
    if not differing and refuted:
        return Verdict("different", "Equal, but the guarantee does not follow", detail, f"Refuted: {refuted}")
    if not differing and own.get("exceeded"):
        return Verdict("different", "Equal, but not as accurate as it must be", detail, "; ".join(own["exceeded"]))
    if not differing:
        return Verdict("equal", "Equal, word for word", detail)
    failed = next(target for target in targets if target["differing"])
    return Verdict("different", "Different", detail, f"First mismatch, {failed['target']}: {failed['mismatch']}")


#: Columns of the table of comparisons: how `gen verify` calls its targets; behind them the emulated chips.
HOSTS = ("g++ -O2", "clang++ -O2", "g++ sanitized", "clang++ sanitized")


def targets_of(combinations: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Columns of the table of comparisons."""
    names = (target["target"].partition(", ")[0] for combination in combinations for target in combination["targets"])
    chips = dict.fromkeys(name for name in names if name.endswith("(simavr)"))
    return (*HOSTS, *(chips or ("ATmega2560 (simavr)",)))


@dataclass(frozen=True)
class Comparison:
    """A row of the table of comparisons.

    Attributes
    ----------
    combinations
        Which ones have these counts.
    compared
        What was compared.
    cells
        For each of the targets a text, and whether it is an alarm.
    """

    combinations: str
    compared: str
    cells: tuple[tuple[str, bool], ...]


def comparisons(combinations: Sequence[Mapping[str, Any]]) -> list[Comparison]:
    """Rows of the table of comparisons; combinations with the same counts share one."""
    found: dict[tuple[str, tuple[tuple[str, bool], ...]], list[str]] = {}
    for combination in combinations:
        label = f"{combination['arithmetic']}/{combination['schedule']}"
        by_kind: dict[str, dict[str, Mapping[str, Any]]] = {}
        for target in combination["targets"]:
            name, _, what = target["target"].partition(", ")
            by_kind.setdefault(what or "states, random profiles", {})[name] = target
        for what, by_target in by_kind.items():
            cells = tuple(_compared(by_target.get(name)) for name in targets_of(combinations))
            found.setdefault((what, cells), []).append(label)
    return [Comparison(", ".join(labels), what, cells) for (what, cells), labels in found.items()]


def _compared(target: Mapping[str, Any] | None) -> tuple[str, bool]:
    """How many words a target compared, and whether any of them differ."""
    if target is None:
        return "–", False
    text = _count(target["words"])
    return (f"{_count(target['differing'])} of {text} differ", True) if target["differing"] else (text, False)


def count_words(combinations: Sequence[Mapping[str, Any]]) -> tuple[int, int]:
    """How many words were compared in all combinations, and how many of them differ."""
    targets = [target for combination in combinations for target in combination["targets"]]
    return sum(target["words"] for target in targets), sum(target["differing"] for target in targets)


@singledispatch
def words(component: object) -> list[Cells]:
    """Rows of the table of words: component, word, unit, range, format, resolution, headroom in bits."""
    raise TypeError(f"no formats for a {type(component).__name__}")


@words.register
def _(component: FixedComponent) -> list[Cells]:
    layout, name = component.layout, component.name
    result = []
    for i, (bits, magnitude) in enumerate(zip(layout.fraction_bits, _magnitudes(component), strict=True)):
        room = _headroom(WORD_BITS - 1 - bits - log2(magnitude)) if magnitude else "saturates"
        kind = f"int{WORD_BITS}, Q{bits}"
        result.append((name, f"x{i + 1}", "K", _range(component, i), kind, f"{power(2, -bits)} K", room))
    for i, bits in enumerate(layout.rate_fraction_bits):
        column = component.rates[:, i]
        span = _span(column.min() * 2.0**-bits, column.max() * 2.0**-bits)
        room = _headroom(32.0 - log2(int(column.max()) + 1))
        result.append((name, f"R{i}", "1", span, f"uint32, Q{bits}", power(2, -bits), room))
    bits = layout.fraction_bits[0] - RESIDUE_BITS
    span = _span(component.steady.min() * 2.0**-bits, component.steady.max() * 2.0**-bits)
    room = _headroom(31.0 - log2(int(np.abs(component.steady).max()) + 1))
    return [*result, (name, "S", "K", span, f"int32, Q{bits}", f"{power(2, -bits)} K", room)]


@words.register
def _(component: FloatComponent) -> list[Cells]:
    name, low = component.name, LOW_BITS
    result = []
    for i, (bits, magnitude) in enumerate(zip(component.fraction_bits, _magnitudes(component), strict=True)):
        room = _headroom(31 - bits - log2(magnitude)) if magnitude else "saturates"
        kind = f"int{32 + low}, Q{bits + low}"
        result.append((name, f"x{i + 1}", "K", _range(component, i), kind, f"{power(2, -bits - low)} K", room))
    for i in range(component.order):
        span = _span(float(component.rates[:, i].min()), float(component.rates[:, i].max()))
        result.append((name, f"R{i}", "1", span, "float32", "24 bits", "floating"))
    bits = component.fraction_bits[0]
    span = _span(float(component.steady.min()) * 2.0**-bits, float(component.steady.max()) * 2.0**-bits)
    room = _headroom(31.0 - log2(int(np.abs(component.steady).max()) + 1))
    return [*result, (name, "S", "K", span, f"int32, Q{bits}", f"{power(2, -bits)} K", room)]


def constants(program: Program) -> list[Cells]:
    """Rows of the table of constants: component, constant, unit, format, JSON path, place in the C++."""
    model = program.model
    source = f"lib/{model.name}/src/{model.name}"
    places = {m: f"{shape.place}[{i}]" for shape in program.shapes for i, m in enumerate(shape.members)}
    result: list[Cells] = []
    for number, component in enumerate(program.components):
        path, fixed = f"$.components[{number}]", not isinstance(component, FloatComponent)
        at = "TABLE[|PWM|]" if program.schedule == "table" else "now"
        file = f"{source}_schedule.cpp" if program.schedule == "table" else f"{source}_model.h"
        member = f"{at}.{places[number]}."
        formats = {row[1]: row[4] for row in words(component)}
        for i in range(component.order):
            rate = f"{member}rate[{i}]" if fixed or program.onboard else f"TABLE[|PWM|], {component.name}.R{i}"
            origin = f"{path}.poles, $.sample_time_s"
            result.append((component.name, f"R{i}", "1", formats[f"R{i}"], origin, f"{file}: {rate}"))
        steady = f"{member}steady" if fixed or program.onboard else f"TABLE[|PWM|], {component.name}.S"
        result.append((component.name, "S", "K", formats["S"], f"{path}.gain, {path}.poles", f"{file}: {steady}"))
        place = f"{source}.cpp: {model.name}_start()" if fixed else f"{source}_step.h: {model.name}_rest()"
        kind, domain = "int32", "$.domain.temperature_degC, $.domain.ambient_degC"
        start = "start {}..{}".format(*component.start_range_mK)
        result.append((component.name, start, "mK", kind, domain, place))
    for tape in program.onboard:
        for n, step in enumerate(tape.steps):
            if step.table:
                origin = f"$.{step.label.path}" if step.label.path else "derived"
                kind = f"Q{step.q}" if tape.arithmetic == "fixed" else "float32"
                place = f"{source}_schedule.cpp: {model.name}_schedule_{tape.name}(), n{n}"
                result.append((tape.name, step.label.text or step.op, step.label.unit or "—", kind, origin, place))
    return result


def _rows(program: Program) -> str:
    """All tabulated words as text, a line for each |PWM|."""
    names = [f"{c.name}.{word}" for c in program.components for word in [*(f"R{i}" for i in range(c.order)), "S"]]
    columns: list[list[str]] = [["|PWM|", *(str(pwm) for pwm in domain_rows(program.model))]]
    for name, column in zip(names, [v for c in program.components for v in [*c.rates.T, c.steady]], strict=True):
        columns.append([name, *(str(v) if isinstance(v, int) else f"{v:.9g}" for v in column.tolist())])
    widths = [max(map(len, column)) for column in columns]
    lines = zip(*columns, strict=True)
    return "\n".join("  ".join(t.rjust(w) for t, w in zip(line, widths, strict=True)) for line in lines)
