"""What the build report shows of a network: curves over PWM, words with their ranges, constants and their places."""

from __future__ import annotations

from collections.abc import Sequence
from math import log2

import numpy as np
from markupsafe import Markup

from gen.firmware.model_charts import ends_text
from gen.lowering.network import fixed, float32
from gen.lowering.network.program import HeatProgram, NetworkProgram, TermProgram
from gen.lowering.program import Program
from gen.lowering.recursion.dynamics import domain_rows
from gen.lowering.recursion.guarantee import rounded_up
from gen.model.network import Network
from gen.pages.charts import Chart, Series, power, scientific
from gen.pages.network_drawing import DrawnNode, DrawnPath, network_svg

Cells = tuple[str, ...]
_LETTERS, _GAP = 60, 6
"""Letters that a chart's legend has room for, and what each entry takes beside its own."""


def drawing(program: Program) -> Markup:
    """The network at full speed, each factor at its channel's neutral value."""
    network = program.model.network
    assert network is not None
    top = np.array([program.model.domain_pwm[1]])
    told = network.neutral()
    heats = np.zeros(len(network.nodes))
    for number, heat in enumerate(network.heats):
        factor = float(network.factor_values(heat.factors, told, (1,))[0])
        heats[network.index(heat.node)] += float(network.powers[top[0], number]) * factor
    nodes = [
        DrawnNode(node.name, node.sensor is not None, float(power))
        for node, power in zip(network.nodes, heats, strict=True)
    ]
    paths = []
    for number, path in enumerate(network.paths):
        factor = float(network.factor_values(path.factors, told, (1,))[0])
        conductance = float(network.conductances[top[0], number]) * factor
        if conductance > 0.0:
            other = None if path.second is None else network.index(path.second)
            paths.append(DrawnPath(network.index(path.first), other, conductance))
    return network_svg("network", f"The network at |PWM| {top[0]}: W/K by thickness", nodes, paths)


def curve_charts(program: Program) -> list[Chart]:
    """Conductances and powers over the domain of |PWM|, those alike in kind in one chart, eight at most."""
    network = program.model.network
    assert network is not None
    rows = domain_rows(program.model)
    pwm = rows[::3].tolist()
    paths = [(path.label, network.conductances[rows[::3], k].tolist()) for k, path in enumerate(network.paths)]
    heats = [(heat.node, network.powers[rows[::3], k].tolist()) for k, heat in enumerate(network.heats)]
    return [
        *_charts("conductance", "Conductances", ("G", "W/K"), paths, pwm, program),
        *_charts("power", "Heats", ("P", "W"), heats, pwm, program),
    ]


def _charts(
    kind: str,
    title: str,
    y: tuple[str, str],
    curves: Sequence[tuple[str, list[float]]],
    pwm: list[int],
    program: Program,
) -> list[Chart]:
    made = []
    for first, last in _groups([name for name, _ in curves]):
        lines = [Series(name, pwm, own, i) for i, (name, own) in enumerate(curves[first:last])]
        text = f"{title} over |PWM| {pwm[0]} to {pwm[-1]}, each factor 1. {ends_text(lines)}"
        made.append(
            Chart(f"{kind}-{first}", title, text, "|PWM| (counts)", *y, tuple(lines), shade=program.model.validity)
        )
    return made


def _groups(names: Sequence[str]) -> list[tuple[int, int]]:
    """Neighbours whose legend fits one chart, as ranges."""
    found, first, used = [], 0, 0
    for number, name in enumerate(names):
        used += len(name) + _GAP
        if number > first and used > _LETTERS:
            found.append((first, number))
            first, used = number, len(name) + _GAP
    return [*found, (first, len(names))] if names else []


def state_words(network: NetworkProgram) -> list[Cells]:
    """Rows of the table of states: node, range, guaranteed error, format, resolution, headroom, terms of the series."""
    low_bits = fixed.LOW_BITS if network.arithmetic == "fixed" else float32.LOW_BITS
    made: list[Cells] = []
    for k, state in enumerate(network.states):
        low, high = float(network.proof.low[k]), float(network.proof.high[k])
        room = 31 - network.fraction_bits - log2(max(abs(low), abs(high)))
        bits = network.fraction_bits + low_bits
        made.append(
            (
                state.name,
                f"{low:.0f} .. {high:.0f}",
                scientific(rounded_up(float(network.proof.error[k]))),
                f"int{32 + low_bits}, Q{bits}",
                f"{power(2, -bits)} K",
                f"{max(0.0, np.floor(room * 10) / 10):.1f}",
                str(state.orders),
            )
        )
    return made


def network_constants(program: Program) -> list[Cells]:
    """Rows of the table of constants: state, constant, unit, format, JSON path, place in the C++."""
    lowered, network = program.network, program.model.network
    assert lowered is not None
    assert network is not None
    source = f"lib/{program.model.name}/src/{program.model.name}"
    rows: list[Cells] = []
    number = 0
    for state in lowered.states:
        for term in state.terms:
            rows.append(_term_row(lowered, network, state.name, state.shift, term, f"{source}_step.cpp: R{number}"))
            number += 1
        rows += [_heat_row(lowered, state.name, heat, f"{source}_step.cpp") for heat in state.heats]
    for k, factor in enumerate(lowered.factors):
        place = f"{source}_step.cpp: factor{k}()"
        rows.append(("all", factor.label, "1", f"int32, Q{factor.bits}", "$.network, factors", place))
    for k, law in enumerate(lowered.laws):
        place = f"{source}_step.cpp: {law.kind}{k}()"
        rows.append((lowered.states[law.first].name, law.kind, "K", "int32", f"$.network.{law.label}", place))
    for reading in lowered.readings:
        if reading.offset:
            path = f"$.network.nodes[{reading.node}].sensor.offset_K"
            form = f"int32, Q{lowered.fraction_bits}"
            rows.append((reading.name, "sensor's offset", "K", form, path, f"{source}.cpp: READING"))
        if reading.gain is not None and lowered.gains is not None:
            path = f"$.network.nodes[{reading.node}].sensor.gain_error"
            form = f"uint32, Q{lowered.gains.shown} and Q{lowered.gains.back}"
            of = "of the rise" if reading.gain.about_ambient else "of degC"
            rows.append((reading.name, f"sensor's gain, {of}", "1", form, path, f"{source}.cpp: READING"))
        if reading.drift is not None:
            path = f"$.network.nodes[{reading.node}].sensor.drift_K"
            form = f"int32, Q{lowered.fraction_bits}"
            rows.append(
                (reading.name, "where its sensor's drift ends", "K", form, path, f"{source}_step.cpp: REFERENCE")
            )
    return rows


def _term_row(
    lowered: NetworkProgram, network: Network, state: str, shift: int, program: TermProgram, place: str
) -> Cells:
    term = program.term
    form = f"uint32, Q{32 + shift}" if lowered.arithmetic == "fixed" else "float32"
    what = "rate" if program.constant else "rate over |PWM|"
    if term.label.startswith("paths"):
        key = f"$.network.{term.label}.conductance_W_per_K, "
    elif term.label.startswith("heats"):
        key = f"$.network.{term.label}, power_W, "
    else:
        field = "" if term.source == "reference" else ".lag_s"
        return state, what, "1 per sample", form, f"$.network.{term.label}{field}, $.sample_time_s", place
    node = min(term.target, len(network.nodes) - 1)
    return state, what, "1 per sample", form, f"{key}nodes[{node}].capacity_J_per_K, $.sample_time_s", place


def _heat_row(lowered: NetworkProgram, state: str, program: HeatProgram, place: str) -> Cells:
    form = "uint32" if lowered.arithmetic == "fixed" else "float32"
    what = "heat" if program.constant else "heat over |PWM|"
    key = f"$.network.{program.heat.label}.power_W, nodes[{program.heat.target}].capacity_J_per_K, $.sample_time_s"
    return state, what, "K per sample", form, key, place


def tabulated(program: Program) -> str:
    """All words over |PWM| as text, a line for each |PWM|."""
    lowered = program.network
    assert lowered is not None
    columns: list[list[str]] = [["|PWM|", *(str(pwm) for pwm in domain_rows(program.model))]]
    for state in lowered.states:
        held: tuple[TermProgram | HeatProgram, ...] = (*state.terms, *state.heats)
        for own in held:
            if own.constant:
                continue
            label = own.term.label if isinstance(own, TermProgram) else own.heat.label
            columns.append([f"{state.name}.{label}", *(f"{value:.9g}" for value in own.words.tolist())])
    widths = [max(map(len, column)) for column in columns]
    lines = zip(*columns, strict=True)
    return "\n".join("  ".join(t.rjust(w) for t, w in zip(line, widths, strict=True)) for line in lines)
