"""The firmware beside the plant that the options ask for."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, load, parse
from gen.emulate.board import Board
from gen.emulate.firmware import build_firmware
from gen.emulate.plants.model_plant import ModelPlant
from gen.emulate.plants.plant import Plant
from gen.emulate.plants.rig import RigPlant
from gen.emulate.results import Results, results_of
from gen.emulate.scenario import Scenario, make_plant
from gen.emulate.session import run_session
from gen.errors import InputError
from gen.lowering.lower import lower
from gen.record.profile import Profile
from tests.examples import ROOT

EXAMPLES = ROOT / "examples"
RIG, NETWORK, MASSES = (
    EXAMPLES / name for name in ("my1016/coeffs.json", "my1016_rig/network.json", "two_mass/coeffs.json")
)
WIRED = [
    path
    for path in sorted(EXAMPLES.glob("*/*.json"))
    if '"wiring": {' in (text := path.read_text(encoding="utf-8")) and '"gen-coefficients"' in text
]

BY_HAND: dict[str, Any] = {
    "format": "gen-coefficients",
    "version": 2,
    "name": "by_hand",
    "sample_time_s": 0.25,
    "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 3000},
    "ambient": {"fixed_degC": 25, "channel": "ambient_degC"},
    "validity": {"pwm": [0, 255], "outside": "hold"},
    "domain": {"pwm": [0, 255], "ambient_degC": [0, 45], "temperature_degC": [-10, 120]},
    "network": {
        "nodes": [
            {"name": "shell", "capacity_J_per_K": 200, "sensor": {}},
            {"name": "coil", "capacity_J_per_K": 40, "sensor": {}},
        ],
        "paths": [
            {"between": ["coil", "shell"], "conductance_W_per_K": {"poly": [0.4]}},
            {"between": ["shell", "ambient"], "conductance_W_per_K": {"poly": [0.5]}},
        ],
        "heats": [{"node": "coil", "power_W": {"poly": [3e-4, 0, 0]}}],
    },
    "wiring": {
        "led_pin": 13,
        "thermocouples": [
            {"channel": "shell", "cs": 29, "so": 35, "sck": 31},
            {"channel": "coil", "cs": 33, "so": 35, "sck": 31},
            {"channel": "ambient", "cs": 39, "so": 45, "sck": 41},
        ],
        "encoder": {"pin": 2, "pulses_per_revolution": 100},
    },
    "alarms": [
        {
            "name": "coil_warm",
            "kind": "above_model",
            "component": "coil",
            "threshold_K": 1.5,
            "speed_percent": [10, 100],
            "hysteresis_K": 0.5,
            "persistence_s": 10,
            "settle_s": 20,
        }
    ],
}


@pytest.fixture
def by_hand() -> Coefficients:
    return parse(json.dumps(BY_HAND).encode())


def run(coefficients: Coefficients, plant: Plant, cache: Path, seconds: float, profile: Profile) -> Results:
    firmware = build_firmware(coefficients, "fixed", "table", "coeffs.json", cache)
    assert coefficients.document.wiring is not None
    board = Board(firmware.elf, firmware.cache, coefficients.document.wiring, plant, encoder="batched")
    try:
        return results_of(coefficients.document, board, run_session(board, seconds, profile=profile))
    finally:
        board.close()


@pytest.mark.parametrize("path", WIRED, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_every_wired_example_runs_for_a_minute_as_its_own_plant(path: Path, core: object, cache: Path) -> None:
    loaded = load(path)
    made = make_plant(Scenario(plant="model", sensor_tolerance=0.0, ambient="28"), loaded, path)
    found = run(loaded, made.plant, cache, 60.0, ((0.0, 200),))
    assert found.columns["time_s"].size > 50 and not found.alarms and not found.disbelieved
    for name in loaded.model.component_names:
        measured, modelled = (found.columns[f"{name}{end}"] for end in ("_degC", "_model_degC"))
        assert np.nanmax(np.abs(measured - modelled)) < 1.5, name


def test_a_network_written_by_hand_is_its_own_healthy_motor(by_hand: Coefficients, core: object, cache: Path) -> None:
    """Without errors of the sensors the board is off by its proven bound, half a count, and what a row comes late."""
    channels = ["shell", "coil", "ambient"]
    plant = ModelPlant(
        by_hand, channels, start={"shell": 30.0, "coil": 31.0}, ambient_degC=25.0, pulses_per_revolution=100
    )
    found = run(by_hand, plant, cache, 400.0, ((0.0, 255), (200.0, 60)))
    assert not found.alarms
    fastest = 3e-4 * 255**2 / 40.0
    for part in lower(by_hand, "fixed", "table").parts:
        assert part.proof is not None
        measured, modelled = (found.columns[f"{part.name}{end}"] for end in ("_degC", "_model_degC"))
        late_K = 0.5 * fastest
        assert np.abs(measured - modelled).max() < part.proof.bound_K + 0.125 + 0.001 + late_K
        assert measured.max() > 33.0
    assert np.median(found.columns["speed_rpm"][50:150]) == pytest.approx(3000.0, rel=0.01)


@pytest.mark.parametrize(("fault", "alarms"), [("heat:coil=+30%@60", ["coil_warm"]), ("heat:shell=-3W@60", [])])
def test_a_planted_fault_is_seen(
    by_hand: Coefficients, core: object, cache: Path, tmp_path: Path, fault: str, alarms: list[str]
) -> None:
    made = make_plant(Scenario(fault=fault, ambient="25"), by_hand, tmp_path / "by_hand.json")
    assert isinstance(made.plant, ModelPlant)
    assert made.fault == fault.replace("@60", " from 60 s")
    found = run(by_hand, made.plant, cache, 300.0, ((0.0, 200),))
    assert [alarm.rule for alarm in found.alarms] == alarms
    assert all(alarm.raised_s > 60.0 for alarm in found.alarms)


def test_the_plant_is_the_rig_where_it_has_the_parts_and_else_the_model(by_hand: Coefficients) -> None:
    for path, kind in ((RIG, RigPlant), (NETWORK, RigPlant), (MASSES, ModelPlant)):
        assert isinstance(make_plant(Scenario(), load(path), path).plant, kind)
    assert isinstance(make_plant(Scenario(plant="model"), load(NETWORK), NETWORK).plant, ModelPlant)
    assert isinstance(make_plant(Scenario(), by_hand, Path("by_hand.json")).plant, ModelPlant)


def test_another_file_is_the_plant(tmp_path: Path, by_hand: Coefficients) -> None:
    """A fan that the board's model does not have."""
    tree = json.loads(json.dumps(BY_HAND))
    tree["network"]["channels"] = [{"column": "fan", "range": [0, 1], "neutral": 0}]
    tree["network"]["paths"][1]["factors"] = [{"channel": "fan", "poly": [2.0, 1.0]}]
    other = tmp_path / "other.json"
    other.write_text(json.dumps(tree), encoding="utf-8")
    still, blown = (
        make_plant(Scenario(plant=str(other), channels=told), by_hand, tmp_path / "by_hand.json")
        for told in ((), ("fan=1",))
    )
    assert "fan = 0" in still.about and "fan" not in blown.about
    for made in (still, blown):
        for _ in range(4000):
            made.plant.step(200, 0.25)
    assert blown.plant.temperatures["shell"] < still.plant.temperatures["shell"] - 3.0


@pytest.mark.parametrize(
    ("path", "scenario", "message"),
    [
        (NETWORK, Scenario(plant=str(MASSES)), 'two_mass, has no part "brush"; it has winding, housing'),
        (NETWORK, Scenario(plant="modell"), 'found "modell", expected rig, model or a coefficient file'),
        (NETWORK, Scenario(fault="heat:brush=+20%"), "expected bearing or brush"),
        (NETWORK, Scenario(plant="model", fault="bearing"), "expected heat:NODE"),
        (NETWORK, Scenario(channels=("fan=1",)), "expected airflow_m_s or voltage_V"),
        (NETWORK, Scenario(start="hidden1=50"), "expected PWM:SECONDS or name=degC"),
        (MASSES, Scenario(plant="rig"), 'no part "winding"|no part "housing"'),
        (MASSES, Scenario(load="1"), "says nothing of torque"),
        (MASSES, Scenario(start="brush=50"), "one of winding, housing"),
    ],
)
def test_what_a_plant_has_not_is_one_message(path: Path, scenario: Scenario, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        make_plant(scenario, load(path), path)
    about_option = refused.value.place is not None and refused.value.place.startswith("--")
    assert refused.value.file == (None if about_option else str(path))


def test_the_rig_is_told_its_surroundings() -> None:
    rising = []
    for channels in ((), ("airflow_m_s=6",), ("voltage_V=12",)):
        made = make_plant(Scenario(channels=channels), load(RIG), RIG)
        for _ in range(4000):
            reading = made.plant.step(200, 0.25)
        rising.append(made.plant.temperatures["casing"])
    assert rising[1] < rising[0] - 0.5 and rising[2] < rising[0] - 0.5
    assert reading.channels["voltage_V"] == 12.0
