"""Every effect of the catalogue against its equation written down here, at orders 1 and 2, folded and not.

Nothing of the catalogue is used to say what is right: the model's numbers, the effects' heat, states, starts and
readings are literals of this file, solved with step size control. Three programs of the repository are held against
that: what `gen simulate --arithmetic exact` integrates, what judges the board, and the board's reference.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gen.arrays import FloatArray
from gen.coefficients import Coefficients, parse
from gen.lowering.effects import lower_effects
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.model.effects import Applied, registry
from gen.model.extended import ExtendedSolution
from gen.reference.model import ReferenceModel
from gen.verification.held import HeldSolution

TS = 0.25
#: PWM and samples for which it is held: driven, in reverse, at standstill.
PROFILE = ((180, 240), (-120, 240), (0, 240))
FIXED, SHOWN = 25.0, 45.0  # degC: what the model counts from, and what the sensor shows at the start
CHANNELS = {"current_A": 6.0, "voltage_V": 21.0, "fan": 1.5, "gearbox_degC": 70.0, "heater_W": 40.0}
COMPONENT = {1: "casing", 2: "winding"}


def gain(order: int, x: int) -> float:
    return 6e-4 + 9e-4 * x / 255 if order == 1 else 2e-5 + 3e-5 * x / 255


def poles(order: int, x: int) -> list[float]:
    slow = 0.002 + 0.004 * x / 255
    return [slow] if order == 1 else [0.004 + 0.006 * x / 255, 0.02 + 0.01 * x / 255]


def straight(value: Callable[[int], float]) -> dict[str, Any]:
    """A schedule of the file that is a straight line over |PWM|."""
    return {"table": {"pwm": [0, 255], "value": [value(0), value(255)], "interpolation": "linear"}}


def _component(order: int) -> dict[str, Any]:
    return {
        "name": COMPONENT[order],
        "order": order,
        "gain": straight(lambda x: gain(order, x)),
        "poles": [{"real": straight(lambda x, i=i: -poles(order, x)[i])} for i in range(order)],  # type: ignore[misc]
    }


DOCUMENT: dict[str, Any] = {
    "format": "gen-coefficients",
    "version": 1,
    "name": "by_hand",
    "sample_time_s": TS,
    "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 3000},
    "ambient": {"fixed_degC": FIXED},
    "validity": {"pwm": [0, 255], "outside": "hold"},
    "domain": {"pwm": [0, 255], "ambient_degC": [-20.0, 60.0], "temperature_degC": [-20.0, 250.0]},
    "accuracy": {"fixed_limit_K": 1e-4},
    "components": [_component(1), _component(2)],
}


@dataclass(frozen=True)
class Now:
    """What an equation may use: rise (K), seconds, PWM and |PWM|, own rate (1/s), baseline's heating (K/s)."""

    T: float
    t: float
    pwm: int
    x: int
    rate: float
    heat: float
    other: float  # rise of the other component
    z: float  # the effect's inner state


def nothing(now: Now) -> float:
    return 0.0


def as_it_is(T: float, t: float) -> float:
    return T


@dataclass(frozen=True)
class Case:
    """An effect and what it means."""

    name: str
    parameters: dict[str, Any]
    heat: Callable[[Now], float] = nothing  # K/s
    inner: Callable[[Now], float] = nothing  # z'
    inner_start: float = 0.0
    tau_s: float | None = None  # of its own state
    reading: Callable[[float, float], float] = as_it_is  # (degC, s) -> degC
    true_start: float = SHOWN  # degC
    lag_s: float | None = None
    room: float = FIXED  # measured ambient
    moved: float = 0.0  # its state at the start, K
    instead: bool = False  # it counts from the room at once
    folds: frozenset[int] = field(default_factory=frozenset)  # orders at which the file's model holds it


def _bump(x: int) -> float:
    table = 1.1 - 0.2 * min(max(x - 100, 0), 100) / 100
    return table * (1.0 + 0.3 * math.exp(-(((x - 150) / 30) ** 2)))


BOTH = frozenset({1, 2})
CASES = {
    "airflow": Case("airflow", {"channel": "fan", "cooling_per_s": 3e-4}, lambda n: -3e-4 * 1.5 * n.T),
    "ambient, at once": Case("ambient", {}, room=29.0, instead=True, folds=BOTH),
    "ambient, delayed": Case("ambient", {"delayed": True}, lambda n: n.rate * 4.0, room=29.0, moved=4.0),
    "ambient, own time constant": Case(
        "ambient", {"delayed": True, "tau_s": 90.0}, lambda n: 4.0 / 90.0, tau_s=90.0, room=29.0, moved=4.0
    ),
    "coupling, exchange": Case(
        "coupling", {"source": "other", "conductance_per_s": 4e-4}, lambda n: 4e-4 * (n.other - n.T)
    ),
    "coupling, one way": Case(
        "coupling", {"source": "other", "conductance_per_s": 4e-4, "exchange": False}, lambda n: 4e-4 * n.other
    ),
    "coupling, own time constant": Case(
        "coupling",
        {"source": "other", "conductance_per_s": 4e-4, "exchange": False, "tau_s": 70.0},
        lambda n: 4e-4 * n.other,
        tau_s=70.0,
    ),
    "coupling, measured part": Case(
        "coupling", {"source": "gearbox_degC", "conductance_per_s": 4e-4}, lambda n: 4e-4 * (70.0 - 25.0 - n.T)
    ),
    "coupling, heater": Case(
        "coupling", {"source": "heater_W", "conductance_per_s": 4e-4, "exchange": False}, lambda n: 4e-4 * 40.0
    ),
    "direction": Case("direction", {"reverse_heating": 0.3}, lambda n: 0.3 * n.heat if n.pwm < 0 else 0.0),
    "drift": Case("drift", {"drift_K_per_h": 3.0}, reading=lambda T, t: T + 3.0 * t / 3600.0),
    "hidden_node": Case(
        "hidden_node",
        {"heating_K_per_s": 0.03, "node_tau_s": 60.0},
        lambda n: 0.03 * n.z,
        lambda n: (n.x / 255 - n.z) / 60.0,
    ),
    "hidden_node, squared exchange": Case(
        "hidden_node",
        {"heating_K_per_s": 0.03, "node_tau_s": 60.0, "exponent": 2, "exchange": True},
        lambda n: 0.03 * (n.z - (n.x / 255) ** 2),
        lambda n: ((n.x / 255) ** 2 - n.z) / 60.0,
    ),
    "hidden_node, own time constant": Case(
        "hidden_node",
        {"heating_K_per_s": 0.03, "node_tau_s": 60.0, "tau_s": 80.0},
        lambda n: 0.03 * n.z,
        lambda n: (n.x / 255 - n.z) / 60.0,
        tau_s=80.0,
    ),
    "initial_state": Case(
        "initial_state",
        {"soak_per_s": 2e-3, "soak_tau_s": 50.0},
        lambda n: 2e-3 * n.z,
        lambda n: -n.z / 50.0,
        inner_start=20.0,
    ),
    "load_heating": Case(
        "load_heating",
        {"heating_K_per_s_A2": 2e-4, "reference_A": 2.0},
        lambda n: 2e-4 * (6.0**2 - 2.0**2),
    ),
    "load_heating, own time constant": Case(
        "load_heating", {"heating_K_per_s_A2": 2e-4, "tau_s": 60.0}, lambda n: 2e-4 * 6.0**2, tau_s=60.0
    ),
    "radiation": Case(
        "radiation",
        {"loss_K_per_s_1e8K4": 1e-3},
        lambda n: -1e-3 * (((n.T + 298.15) / 100) ** 4 - (298.15 / 100) ** 4),
    ),
    "schedule_error": Case(
        "schedule_error",
        {"pwm": [100, 200], "gain_factor": [1.1, 0.9], "peak_factor": 1.3, "middle_pwm": 150.0, "width_pwm": 30.0},
        lambda n: (_bump(n.x) - 1.0) * n.heat,
        folds=BOTH,
    ),
    "schedule_error, another rate": Case(
        "schedule_error",
        {"pwm": [100], "gain_factor": [1.2], "rate_factor": 1.5},
        lambda n: (1.5 * 1.2 - 1.0) * n.heat - 0.5 * n.rate * n.T,
        folds=frozenset({1}),
    ),
    "sensor_gain": Case(
        "sensor_gain",
        {"gain_error": 0.25},
        reading=lambda T, t: 25.0 + 1.25 * (T - 25.0),
        true_start=25.0 + 16.0,  # whole thousandths of a kelvin, as the board starts
    ),
    "sensor_gain, from zero": Case(
        "sensor_gain",
        {"gain_error": 0.25, "about": "zero_degC"},
        reading=lambda T, t: 1.25 * T,
        true_start=36.0,
    ),
    "sensor_lag": Case("sensor_lag", {"lag_s": 25.0}, lag_s=25.0),
    "sensor_offset": Case("sensor_offset", {"offset_K": -2.5}, reading=lambda T, t: T - 2.5, true_start=47.5),
    "standstill_cooling": Case(
        "standstill_cooling",
        {"cooling_factor": 2.5},
        lambda n: -1.5 * n.rate * n.T if n.pwm == 0 else 0.0,
        folds=frozenset({1}),
    ),
    "standstill_cooling, slower": Case(
        "standstill_cooling",
        {"cooling_factor": 0.4},
        lambda n: 0.6 * n.rate * n.T if n.pwm == 0 else 0.0,
        folds=frozenset({1}),
    ),
    "supply_voltage": Case(
        "supply_voltage",
        {"sensitivity": 0.8, "nominal_V": 24.0},
        lambda n: 0.8 * ((21.0 / 24.0) ** 2 - 1.0) * n.heat,
    ),
    "temperature_dependent_loss": Case(
        "temperature_dependent_loss", {"coefficient_per_K": 0.004}, lambda n: 0.004 * n.T * n.heat
    ),
}


#: A case that is the model alone when its heat is left out.
PLAIN = "direction"


def test_every_effect_of_the_catalogue_has_an_equation_here() -> None:
    assert {case.name for case in CASES.values()} == set(registry())


@cache
def by_hand(order: int, label: str, without: bool = False) -> FloatArray:
    """What the sensor shows after each sample, degC; `without` the effect's heat."""
    case, rest = CASES[label], 3 - order
    counted_from = case.room if case.instead else FIXED

    def polynomial(n: int, x: int) -> list[float]:
        """Of the derivatives below the highest, from the lowest: 1/s^n, .."""
        p = poles(n, x)
        return [p[0]] if n == 1 else [p[0] * p[1], p[0] + p[1]]

    def higher(n: int, x: int, state: FloatArray, drive: float) -> list[float]:
        a = polynomial(n, x)
        return [*state[1:], drive - sum(c * s for c, s in zip(a, state, strict=True))]

    def slope(t: float, y: FloatArray, pwm: int) -> list[float]:
        x = abs(pwm)
        base, added, other = y[:order], y[order : 2 * order], y[2 * order : 2 * order + rest]
        z, own, lagged = y[-3:]
        a = [*polynomial(order, x), 1.0]
        now = Now(base[0] + added[0] + own, t, pwm, x, a[0] / a[1], gain(order, x) * x / a[1], other[0], z)
        q = 0.0 if without else case.heat(now)
        return [
            *higher(order, x, base, gain(order, x) * x),
            *higher(order, x, added, 0.0 if case.tau_s else a[1] * q),
            *higher(rest, x, other, gain(rest, x) * x),
            case.inner(now),
            q - own / case.tau_s if case.tau_s else 0.0,
            (counted_from + now.T - lagged) / case.lag_s if case.lag_s else 0.0,
        ]

    y = np.zeros(2 * order + rest + 3)
    y[0] = case.true_start - counted_from - case.moved
    y[-2 if case.tau_s else order] = case.moved
    y[2 * order] = SHOWN - FIXED if case.room == FIXED else SHOWN - case.room
    y[-3], y[-1] = case.inner_start, case.true_start
    out, t = [], 0.0
    for pwm, samples in PROFILE:
        at = t + TS * np.arange(1, samples + 1)
        solved = solve_ivp(slope, (t, at[-1]), y, "DOP853", at, args=(pwm,), rtol=1e-11, atol=1e-11)
        y, t = solved.y[:, -1], float(at[-1])
        true = solved.y[-1] if case.lag_s else counted_from + solved.y[0] + solved.y[order] + solved.y[-2]
        out += [case.reading(float(T), float(when)) for T, when in zip(true, at, strict=True)]
    return np.array(out)


def entry(order: int, case: Case) -> dict[str, Any]:
    parameters = dict(case.parameters)
    if parameters.get("source") == "other":
        parameters["source"] = COMPONENT[3 - order]
    return {"name": case.name, "component": COMPONENT[order], "parameters": parameters}


@cache
def as_read(order: int, label: str) -> Coefficients:
    """The file with the effect; one that acts on the room acts on both parts."""
    case = CASES[label]
    entries = [entry(n, case) for n in ((1, 2) if registry()[case.name].everywhere else (order,))]
    return parse(json.dumps({**DOCUMENT, "effects": entries}).encode())


@cache
def never_folded(order: int, label: str) -> Coefficients:
    """The same with the effect beside the model, whatever its file says of folding."""
    read, plain = as_read(order, label), parse(json.dumps(DOCUMENT).encode())
    effects = tuple(
        Applied(registry()[e.name], e.component, registry()[e.name].parameters(**e.parameters).model_dump())
        for e in read.document.effects
    )
    model = replace(plain.model, ambient_at_once=read.model.ambient_at_once)  # as the effect has it
    return replace(read, model=model, effects=effects)


Made = Callable[[int, str], Coefficients]
EVERY = [pytest.param(order, label, id=f"{label}, order {order}") for label in CASES for order in (1, 2)]
#: What the file's reader folds is taken as it reads it, and beside the model as well.
BOTH_WAYS = [
    pytest.param(order, label, made, id=f"{label}, order {order}{', not folded' if made is never_folded else ''}")
    for label, case in CASES.items()
    for order in (1, 2)
    for made in ((as_read, never_folded) if order in case.folds else (as_read,))
]
HELD = np.repeat([pwm for pwm, _ in PROFILE], [samples for _, samples in PROFILE])


@cache
def plainly_lowered() -> Program:
    return lower(parse(json.dumps(DOCUMENT).encode()), "fixed", "table")


def lowered(made: Coefficients) -> Program:
    """The board's program; the components' part of it is lowered once for all models that share them."""
    base = plainly_lowered()
    if made.model.components != base.model.components:
        return lower(made, "fixed", "table")
    return replace(base, model=made.model, effects=lower_effects(made, "fixed", base.components))


def measured_from(made: Coefficients, case: Case) -> float:
    """The ambient that the model counts from, degC."""
    return FIXED if made.model.ambient_channel is None else case.room


@pytest.mark.parametrize(("order", "label"), EVERY)
def test_an_effect_is_seen_and_folded_where_it_is_only_a_change_of_entries(order: int, label: str) -> None:
    case, read = CASES[label], as_read(order, label)
    assert (not read.effects) == (order in case.folds)
    difference = by_hand(order, label) - by_hand(order, PLAIN, without=True)
    assert np.max(np.abs(difference)) > 0.04, "what cannot be seen is not compared"


@pytest.mark.parametrize(("order", "label", "made"), BOTH_WAYS)
def test_the_exact_solution_of_runs(order: int, label: str, made: Made) -> None:
    case, coefficients = CASES[label], made(order, label)
    time: FloatArray = np.arange(HELD.size + 1, dtype=np.float64) * TS
    start = SHOWN - measured_from(coefficients, case)
    shown = ExtendedSolution(coefficients.model, coefficients.effects).simulate_times(
        time,
        np.append(HELD, 0),
        np.full(time.size, measured_from(coefficients, case)),
        np.full(time.size, case.room),
        {name: np.full(time.size, value) for name, value in CHANNELS.items()},
        dict.fromkeys(COMPONENT.values(), start),
    )[COMPONENT[order]]
    assert shown[0] == pytest.approx(SHOWN, abs=1e-9)
    np.testing.assert_allclose(shown[1:], by_hand(order, label), rtol=0, atol=1e-5)


@pytest.mark.parametrize(("order", "label", "made"), BOTH_WAYS)
def test_the_solution_that_judges_the_board(order: int, label: str, made: Made) -> None:
    case, coefficients = CASES[label], made(order, label)
    room, above = np.array([case.room]), np.array([SHOWN - case.room])
    solution = HeldSolution(coefficients.model, coefficients.effects, dict.fromkeys(COMPONENT.values(), above), room)
    channels = {name: np.array([value]) for name, value in CHANNELS.items()}
    place, shown = coefficients.model.component_names.index(COMPONENT[order]), []
    for pwm in HELD:
        solution.step(np.array([pwm]), room, channels)
        shown.append(solution.shown()[place, 0] + case.room)
    np.testing.assert_allclose(shown, by_hand(order, label), rtol=0, atol=1e-8)


@pytest.mark.parametrize(("order", "label", "made"), BOTH_WAYS)
def test_the_board_in_fixed_point(order: int, label: str, made: Made) -> None:
    case, coefficients = CASES[label], made(order, label)
    program = lowered(coefficients)
    values = {**CHANNELS, "ambient_degC": case.room}
    columns = [channel.column for channel in program.effects.channels] if program.effects else []
    told = np.array([[round(1000 * values[column])] for column in columns]) if columns else None
    start = {name: [round(1000 * (SHOWN - case.room))] for name in COMPONENT.values()}
    board = ReferenceModel(program, start, told) if told is not None else ReferenceModel(program, start)
    place, shown = program.model.component_names.index(COMPONENT[order]), []
    for pwm in HELD:
        if told is not None:
            board.set_channels(told)
        board.step(np.array([pwm]))
        shown.append(float(board.rises[place, 0]) + case.room)
    np.testing.assert_allclose(shown, by_hand(order, label), rtol=0, atol=2e-5)
