"""The report of an emitted project: one HTML file without outside links, the same bytes everywhere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from functools import cache, singledispatch
from math import ceil, floor, log2
from typing import Any, Literal

import numpy as np
from jinja2 import Environment

from gen.coefficients import Coefficients
from gen.firmware.alarm_text import alarm_texts
from gen.firmware.effects_report import effect_rows
from gen.firmware.model_charts import course_chart, response_charts, schedule_charts
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import RESIDUE_BITS, WORD_BITS
from gen.lowering.float32 import LOW_BITS, FloatComponent
from gen.lowering.program import AnyComponent, Program
from gen.lowering.recursion.dynamics import domain_rows
from gen.lowering.recursion.guarantee import rounded_up
from gen.model import Component
from gen.model.schedules import EXACT
from gen.pages.charts import Chart, plain, power, scientific
from gen.pages.environment import page_environment
from gen.reference.model import ReferenceModel
from gen.version import __version__

#: Length of the step responses, in s; the board's reference runs for their first part only (see ``_samples``).
HORIZON_S = 10_800
LEVELS = (20, 40, 60, 80, 100)
_POINTS, _LATER_POINTS = 80, 60
#: Products of order, substeps and samples that the reference may take: about a quarter of a second.
_WORK = 19_200

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
    window, responses = _responses(replace(program, effects=None))  # of the baseline: effects have no such exact ones
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
            comparisons=[row for combination in combinations for row in comparisons(combination)],
            targets=TARGETS,
            course=course_chart(*own["error_course"].values()) if own and "error_course" in own else None,
            limit_name=limit_name,
            limit=limit,
            window=window,
            figures=[
                (component, schedule_charts(program.model, component), charts)
                for component, charts in zip(program.model.components, responses, strict=True)
            ],
            words=[row for component in program.components for row in words(component)],
            constants=constants(program),
            rows=_rows(program),
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
    if not differing and own.get("exceeded"):
        return Verdict("different", "Equal, but not as accurate as it must be", detail, "; ".join(own["exceeded"]))
    if not differing:
        return Verdict("equal", "Equal, word for word", detail)
    failed = next(target for target in targets if target["differing"])
    return Verdict("different", "Different", detail, f"First mismatch, {failed['target']}: {failed['mismatch']}")


#: Columns of the table of comparisons: how `gen verify` calls its targets.
TARGETS = ("g++ -O2", "clang++ -O2", "g++ sanitized", "clang++ sanitized", "ATmega2560 (simavr)")


def comparisons(combination: Mapping[str, Any]) -> list[tuple[str, str, list[tuple[str, bool]]]]:
    """Rows of the table of comparisons: combination, what was compared, and for each target a text and its alarm."""
    label = f"{combination['arithmetic']}/{combination['schedule']}"
    found: dict[str, dict[str, Mapping[str, Any]]] = {}
    for target in combination["targets"]:
        name, _, what = target["target"].partition(", ")
        found.setdefault(what or "states, random profiles", {})[name] = target
    rows = []
    for what, by_target in found.items():
        cells = []
        for name in TARGETS:
            target = by_target.get(name)
            differing = target["differing"] if target else 0
            text = f"{_count(target['words'])}" if target else "–"
            cells.append((f"{_count(differing)} of {text} differ" if differing else text, differing > 0))
        rows.append((label, what, cells))
    return rows


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


def _responses(program: Program) -> tuple[float, list[list[Chart]]]:
    """How long the board's reference ran, in s, and for each component the step responses and their errors."""
    model = program.model
    levels = sorted(
        {min(max(round(model.full_scale * p / 100), model.domain_pwm[0]), model.domain_pwm[1]) for p in LEVELS}
    )
    work = sum(component.order * component.substeps for component in program.components)
    stride = max(1, min(_WORK // work, round(HORIZON_S / model.sample_time)) // _POINTS)
    # At rest at ambient, or as near to it as the domain allows.
    starts = {c.name: min(max(0, c.start_range_mK[0]), c.start_range_mK[1]) for c in program.components}
    board = ReferenceModel(program, {name: [start] * len(levels) for name, start in starts.items()})
    rises = [board.rises]
    for _ in range(_POINTS):
        for _ in range(stride):
            board.step(np.array(levels))
        rises.append(board.rises)
    interval = stride * model.sample_time
    window = interval * _POINTS
    later = max(0.0, HORIZON_S - window) / _LATER_POINTS
    times = [interval * k for k in range(_POINTS + 1)] + [
        window + later * (k + 1) for k in range(_LATER_POINTS) if later
    ]
    later_count = _LATER_POINTS if later else 0
    charts = []
    for number, component in enumerate(model.components):
        start = Decimal(starts[component.name]) / 1000
        exact = [exact_response(component, pwm, start, [(interval, _POINTS), (later, later_count)]) for pwm in levels]
        own = [[float(point[number, lane]) for point in rises] for lane in range(len(levels))]
        labels = [f"{pwm / model.full_scale:.0%}" for pwm in levels]
        charts.append(response_charts(component.name, labels, times, exact, own))
    return window, charts


def exact_response(component: Component, pwm: int, start: Decimal, parts: list[tuple[float, int]]) -> list[Decimal]:
    """The exact rise at constant PWM, in decimals (a float64 solution would differ in its last digits by machine).

    Parameters
    ----------
    component, pwm, start
        What runs, and from which rise at rest.
    parts
        Intervals in s, and how many points follow at each.
    """
    n = component.order
    generator = np.full((n + 1, n + 1), Decimal(0))
    generator[range(n - 1), range(1, n)] = Decimal(1)
    generator[n - 1, :n] = [-Decimal(a) for a in component.denominator([pwm])[0, :0:-1].tolist()]
    generator[n - 1, n] = Decimal(float(component.effective_gain([pwm])[0])) * pwm
    state = np.array([start, *[Decimal(0)] * (n - 1), Decimal(1)])
    result = [start]
    with localcontext(EXACT):
        for interval, count in parts:
            scaled = generator * Decimal(interval)
            halvings = max(0, ceil(log2(float(np.abs(scaled).sum(axis=1).max()) + 1e-9)) + 1)
            scaled = scaled / Decimal(2**halvings)
            step = term = np.array([[Decimal(int(i == j)) for j in range(n + 1)] for i in range(n + 1)])
            for k in range(1, 25):
                term = term @ scaled / Decimal(k)
                step = step + term
            for _ in range(halvings):
                step = step @ step
            for _ in range(count):
                state = step @ state
                result.append(state[0])
    return result
