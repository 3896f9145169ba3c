"""Effects against an integration of their equations that shares no code with them."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients, parse
from gen.coefficients.schema import json_schema
from gen.coefficients.versions import VERSION
from gen.errors import InputError
from gen.lowering.lower import lower
from gen.model.effects import registry
from gen.model.extended import ExtendedSolution
from tests.model.examples import model
from tests.refinement.plant import COEFFICIENTS

END = 5400
TIME = np.arange(0.0, END + 1.0)
PWM = np.where(TIME < 1800, 204, np.where(TIME < 3000, -128, 0)).astype(np.int64)
CURRENT = np.where(TIME % 1200 < 600, 5.0, 1.0)
VOLTAGE = np.where(TIME < 2500, 22.0, 26.0)
FAN = np.where((TIME > 900) & (TIME < 2700), 1.0, 0.0)
ROOM = 30.0 + 4.0 * np.sin(TIME / 1500.0)
START = {"brush": 12.0, "bearing": 8.0, "magnet": 8.0, "casing": 8.0}


def _with(*effects: dict[str, Any]) -> Coefficients:
    document = json.loads(COEFFICIENTS.read_text(encoding="utf-8"))
    return parse(json.dumps({**document, "effects": list(effects)}).encode())


def _solve(*effects: dict[str, Any], pwm: IntArray = PWM, start: dict[str, float] = START) -> dict[str, FloatArray]:
    made = _with(*effects)
    channels = {"current_A": CURRENT, "voltage_V": VOLTAGE, "fan": FAN}
    ambient = ROOM if made.model.ambient_channel else np.full(TIME.size, 30.0)
    return ExtendedSolution(made.model, made.effects).simulate_times(TIME, pwm, ambient, ROOM, channels, start)


# Parameters; (rise, bearing's rise, second, own rate, baseline's heating, inner state) -> (heating, inner state's
# derivative); inner state at the start.
HEATS: dict[str, tuple[dict[str, Any], Callable[..., tuple[float, float]], float]] = {
    "load_heating": ({"heating_K_per_s_A2": 2e-4}, lambda T, o, k, r, h, z: (2e-4 * float(CURRENT[k]) ** 2, 0.0), 0.0),
    "coupling": ({"source": "bearing", "conductance_per_s": 4e-4}, lambda T, o, k, r, h, z: (4e-4 * (o - T), 0.0), 0.0),
    "radiation": (
        {"loss_K_per_s_1e8K4": 5e-4},
        lambda T, o, k, r, h, z: (-5e-12 * ((T + 303.15) ** 4 - 303.15**4), 0.0),
        0.0,
    ),
    "temperature_dependent_loss": ({"coefficient_per_K": 0.004}, lambda T, o, k, r, h, z: (h * 0.004 * T, 0.0), 0.0),
    "airflow": ({"channel": "fan", "cooling_per_s": 3e-4}, lambda T, o, k, r, h, z: (-3e-4 * FAN[k] * T, 0.0), 0.0),
    "standstill_cooling": (
        {"cooling_factor": 2.5},
        lambda T, o, k, r, h, z: (-1.5 * r * T if PWM[k] == 0 else 0.0, 0.0),
        0.0,
    ),
    "hidden_node": (
        {"heating_K_per_s": 6e-3, "node_tau_s": 1200.0},
        lambda T, o, k, r, h, z: (6e-3 * z, (abs(PWM[k]) / 255.0 - z) / 1200.0),
        0.0,
    ),
    "direction": ({"reverse_heating": 0.3}, lambda T, o, k, r, h, z: (0.3 * h if PWM[k] < 0 else 0.0, 0.0), 0.0),
    "supply_voltage": (
        {"sensitivity": 0.8, "nominal_V": 24.0},
        lambda T, o, k, r, h, z: (0.8 * ((VOLTAGE[k] / 24.0) ** 2 - 1.0) * h, 0.0),
        0.0,
    ),
    "initial_state": (
        {"soak_per_s": 1e-3, "soak_tau_s": 600.0},
        lambda T, o, k, r, h, z: (1e-3 * z, -z / 600.0),
        8.0,
    ),
    "schedule_error": (
        {"pwm": [128, 204], "gain_factor": [1.2, 0.9], "rate_factor": 1.3},
        lambda T, o, k, r, h, z: (
            (1.3 * (1.2 if abs(PWM[k]) <= 128 else 0.9) - 1.0) * h - 0.3 * r * T,
            0.0,
        ),
        0.0,
    ),
}


def _integrated(extra: Callable[..., tuple[float, float]], inner: float, name: str = "casing") -> FloatArray:
    """Runge-Kutta of order 4 with 1 s on the component's own differential equation."""
    model = parse(COEFFICIENTS.read_bytes()).model
    x = np.arange(256)
    own, other = model.component(name), model.component("bearing")
    a, b = own.denominator(x)[:, 1], own.effective_gain(x)
    c, d = other.denominator(x)[:, 1], other.effective_gain(x)

    def slope(y: FloatArray, k: int) -> FloatArray:
        p = abs(int(PWM[k]))
        q, dz = extra(y[0], y[1], k, a[p], b[p] * p, y[2])
        return np.array([b[p] * p - a[p] * y[0] + q, d[p] * p - c[p] * y[1], dz])

    y = np.array([START[name], START["bearing"], inner])
    out = [y[0]]
    for k in range(END):
        k1 = slope(y, k)
        k2 = slope(y + 0.5 * k1, k)
        k3 = slope(y + 0.5 * k2, k)
        y = y + (k1 + 2 * k2 + 2 * k3 + slope(y + k3, k)) / 6.0
        out.append(y[0])
    return np.asarray(out)


@pytest.mark.parametrize("name", list(HEATS))
def test_heat_effect_solves_its_differential_equation(name: str) -> None:
    parameters, extra, inner = HEATS[name]
    solved = _solve({"name": name, "component": "casing", "parameters": parameters})["casing"]
    np.testing.assert_allclose(solved - 30.0, _integrated(extra, inner), atol=2e-5)
    plain = _solve()["casing"]
    assert np.max(np.abs(solved - plain)) > 1.0, "the effect must be visible for the comparison to mean something"


def test_effects_in_parallel_share_the_rise() -> None:
    chosen = ("radiation", "airflow", "direction", "load_heating")
    solved = _solve(*({"name": n, "component": "casing", "parameters": HEATS[n][0]} for n in chosen))["casing"]

    def all_of_them(*state: float) -> tuple[float, float]:
        return sum(HEATS[n][1](*state)[0] for n in chosen), 0.0

    np.testing.assert_allclose(solved - 30.0, _integrated(all_of_them, 0.0), atol=2e-5)


def test_own_time_constant() -> None:
    parameters = {"heating_K_per_s_A2": 2e-4, "tau_s": 900.0}
    added = (
        _solve({"name": "load_heating", "component": "brush", "parameters": parameters})["brush"] - _solve()["brush"]
    )
    expected = [0.0]
    for k in range(END):  # exact for a held drive
        target = 900.0 * 2e-4 * CURRENT[k] ** 2
        expected.append(target + (expected[-1] - target) * np.exp(-1.0 / 900.0))
    np.testing.assert_allclose(added, expected, atol=1e-9)


def test_heat_into_a_part_of_higher_order_passes_all_its_poles() -> None:
    model = parse(COEFFICIENTS.read_bytes()).model
    held = np.full(TIME.size, 204, dtype=np.int64)
    effect = {"name": "direction", "component": "brush", "parameters": {"reverse_heating": 0.5}}
    forward, reverse = _solve(effect, pwm=held)["brush"], _solve(effect, pwm=-held)["brush"]
    # Half as much heating again through the same poles is half the response to the input alone.
    cold = dict.fromkeys(model.component_names, 0.0)
    alone = _solve(pwm=held, start=cold)["brush"] - 30.0
    np.testing.assert_allclose(reverse - forward, 0.5 * alone, atol=1e-8)


def test_temperature_goes_on_rising_after_cut_off() -> None:
    parameters = {"heating_K_per_s": 0.03, "node_tau_s": 1500.0}
    solved = _solve({"name": "hidden_node", "component": "casing", "parameters": parameters})["casing"]
    without, at = _solve()["casing"], 3000
    assert without[at + 120] < without[at]
    assert solved[at + 120] > solved[at] + 0.2


def test_ambient_through_the_thermal_mass_and_at_once() -> None:
    delayed = _solve({"name": "ambient", "component": "casing", "parameters": {"delayed": True}})["casing"]
    solved = _integrated(lambda T, o, k, r, h, z: (r * (0.5 * (ROOM[k] + ROOM[k + 1]) - 30.0), 0.0), 0.0)
    np.testing.assert_allclose(delayed - 30.0, solved, atol=1e-4)
    at_once = {"name": "ambient", "component": "casing", "parameters": {"delayed": False}}
    made = _with(at_once)
    assert made.model.ambient_channel == "ambient_degC"
    assert not made.effects, "reading the ambient is an entry of the file: nothing else is needed"


def test_heat_from_a_measured_part_counts_from_the_ambient() -> None:
    oven = 60.0 + 10.0 * np.sin(TIME / 1000.0)
    parameters = {"source": "oven_degC", "conductance_per_s": 4e-4}
    made = _with({"name": "coupling", "component": "casing", "parameters": parameters})
    solved = ExtendedSolution(made.model, made.effects).simulate_times(
        TIME, PWM, np.full(TIME.size, 30.0), ROOM, {"oven_degC": oven}, START
    )["casing"]
    held = oven[:-1]
    wanted = _integrated(lambda T, o, k, r, h, z: (4e-4 * (held[k] - 30.0 - T), 0.0), 0.0)
    np.testing.assert_allclose(solved - 30.0, wanted, atol=2e-5)


def test_an_ambient_that_is_warm_at_the_start_already_shifts_nothing() -> None:
    """The part shows 38 degC in a room of 36: whatever its rise is counted from, it starts where the sensor is."""
    room = ROOM + 6.0
    made = _with({"name": "ambient", "component": "casing", "parameters": {"delayed": True}})
    shown = ExtendedSolution(made.model, made.effects).simulate_times(
        TIME, PWM, np.full(TIME.size, 30.0), room, {}, START
    )["casing"]
    assert shown[0] == pytest.approx(38.0, abs=1e-9)
    wanted = _integrated(lambda T, o, k, r, h, z: (r * (0.5 * (room[k] + room[k + 1]) - 30.0), 0.0), 0.0)
    np.testing.assert_allclose(shown - 30.0, wanted, atol=1e-4)


@pytest.mark.parametrize(
    ("name", "parameters", "reading", "true_start"),
    [
        ("sensor_offset", {"offset_K": 3.0}, lambda t, T: T + 3.0, 5.0),
        ("sensor_gain", {"gain_error": 0.1}, lambda t, T: 30.0 + 1.1 * (T - 30.0), 8.0 / 1.1),
        ("sensor_gain", {"gain_error": 0.1, "about": "zero_degC"}, lambda t, T: 1.1 * T, 38.0 / 1.1 - 30.0),
        ("drift", {"drift_K_per_h": 2.0}, lambda t, T: T + 2.0 * t / 3600.0, 8.0),
    ],
)
def test_sensor_effects(
    name: str, parameters: dict[str, Any], reading: Callable[[FloatArray, FloatArray], FloatArray], true_start: float
) -> None:
    shown = _solve({"name": name, "component": "casing", "parameters": parameters})["casing"]
    assert shown[0] == pytest.approx(38.0, abs=1e-9), "a run starts from what the sensor shows"
    true = _solve(start={**START, "casing": true_start})["casing"]
    np.testing.assert_allclose(shown, reading(TIME, true), atol=1e-9)


def test_sensor_lag() -> None:
    shown = _solve({"name": "sensor_lag", "component": "casing", "parameters": {"lag_s": 200.0}})["casing"]
    true = _solve()["casing"]
    slope = np.gradient(shown, TIME)
    inside = (TIME > 10) & (np.abs(TIME - 1800) > 5) & (np.abs(TIME - 3000) > 5) & (TIME < END - 5)
    np.testing.assert_allclose((shown + 200.0 * slope)[inside], true[inside], atol=1e-3)


def test_every_effect_is_described_and_named_as_users_know_it() -> None:
    promised = (
        "ambient hidden_node standstill_cooling load_heating coupling radiation temperature_dependent_loss airflow "
        "sensor_offset sensor_gain sensor_lag schedule_error drift direction supply_voltage initial_state"
    )
    assert set(promised.split()) <= set(registry())
    for name, effect in registry().items():
        assert effect.equation and effect.signature and effect.title, name
        assert set(effect.lookalikes) <= set(registry()), name
        for key, schema in effect.parameters.model_json_schema()["properties"].items():
            assert "description" in schema or key in ("tau_s",), f"{name}.{key}"


def test_published_schema_knows_each_effect() -> None:
    validator = Draft202012Validator(json_schema())
    document = json.loads(COEFFICIENTS.read_text(encoding="utf-8")) | {"version": VERSION}
    assert validator.is_valid(document)
    for name, (parameters, _, _) in HEATS.items():
        entry = {"name": name, "component": "casing", "parameters": parameters}
        assert validator.is_valid({**document, "effects": [entry]}), name
        assert not validator.is_valid({**document, "effects": [{**entry, "parameters": {"x": 1}}]}), name


@pytest.mark.parametrize(
    ("entry", "place"),
    [
        ({"name": "haunted", "component": "casing", "parameters": {}}, "$.effects[0].name"),
        ({"name": "drift", "component": "rotor", "parameters": {"drift_K_per_h": 1.0}}, "$.effects[0].component"),
        (
            {"name": "drift", "component": "casing", "parameters": {"drift_K_per_h": 100.0}},
            "$.effects[0].parameters.drift_K_per_h",
        ),
        ({"name": "radiation", "component": "casing", "parameters": {}}, "$.effects[0].parameters"),
        (
            {"name": "drift", "component": "casing", "parameters": {"drift_K_per_h": "a"}, "extra": 1},
            "$.effects[0].extra",
        ),
    ],
)
def test_bad_effect_is_refused_with_its_place(entry: dict[str, Any], place: str) -> None:
    with pytest.raises(InputError) as caught:
        _with(entry)
    assert caught.value.place == place


def test_firmware_takes_what_changes_the_model_and_what_runs_after_it() -> None:
    radiating = _with({"name": "radiation", "component": "casing", "parameters": HEATS["radiation"][0]})
    emitted = lower(radiating, "fixed", "table").effects
    assert emitted is not None
    assert [part.name for part in emitted.components] == ["casing"]
    changed = _with({"name": "standstill_cooling", "component": "casing", "parameters": {"cooling_factor": 2.0}})
    plain = _with()
    for pwm, factor in ((0, 2.0), (1, 1.0), (200, 1.0)):
        poles = [m.model.component("casing").denominator([pwm])[0, 1] for m in (changed, plain)]
        assert poles[0] == pytest.approx(factor * poles[1], rel=1e-12)
    lower(changed, "fixed", "table")


def test_a_peak_of_a_gain_is_a_bell_about_its_middle() -> None:
    """Its factor at the middle, 1 + (factor - 1)/e one width away, and nothing far from it."""
    thermal = model("my1016")
    values = {"pwm": (128,), "gain_factor": (1.1,), "rate_factor": 1.0}
    peak = {"peak_factor": 1.4, "middle_pwm": 150.0, "width_pwm": 20.0}
    folded = registry()["schedule_error"].folded(values | peak, thermal, "casing")
    assert folded is not None
    pwm = np.array([60, 130, 150, 170, 240])
    bell = 1.1 * np.array([1.0, 1.0 + 0.4 / np.e, 1.4, 1.0 + 0.4 / np.e, 1.0])
    base = thermal.component("casing").steady_rise(pwm)
    np.testing.assert_allclose(folded.component("casing").steady_rise(pwm), bell * base, rtol=1e-6)
