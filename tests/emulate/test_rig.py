"""The simulated motor on the board's clock."""

from __future__ import annotations

import pytest

from gen.emulate.plants.plant import STEP_S
from gen.emulate.plants.rig import RigPlant
from gen.errors import InputError
from gen.rig import Fault, MotorConfig, SensorConfig, SensorFault

CHANNELS = ("brush", "casing", "ambient")
QUIET = {name: SensorConfig(noise_K=0.0, lag_s=0.0) for name in CHANNELS}


def degrees(word: int) -> float:
    return (word >> 3) / 4.0


def test_words_are_the_true_temperatures() -> None:
    plant = RigPlant(CHANNELS, sensors=QUIET, start_degC={"brush": 61.0, "casing": 45.5}, ambient_degC=22.25)
    words = plant.step(0, STEP_S).words
    assert {name: degrees(word) for name, word in words.items()} == {
        "brush": pytest.approx(61.0, abs=0.5),
        "casing": pytest.approx(45.5, abs=0.25),
        "ambient": 22.25,
    }


def test_pulses_are_the_shafts_turns() -> None:
    plant = RigPlant(CHANNELS, pulses_per_revolution=500)
    plant.step(0, STEP_S)
    pulses = sum(plant.step(255, STEP_S).pulses for _ in range(400))
    assert pulses == int(plant.motor.revolutions * 500)
    assert pulses / 100.0 == pytest.approx(2650 / 60 * 500, rel=0.05)


def test_times_are_the_boards() -> None:
    faults = {"brush": (SensorFault("open", 10.0, 20.0),)}
    plant = RigPlant(CHANNELS, sensors=QUIET, sensor_faults=faults)
    plant.step(0, STEP_S)  # before the board gets power
    open_at = [k * STEP_S for k in range(1, 121) if plant.step(0, STEP_S).words["brush"] & 4]
    assert (open_at[0], open_at[-1]) == (10.0, 20.0 - STEP_S)


def test_a_fault_of_the_motor_begins_on_the_boards_clock() -> None:
    healthy, faulty = (
        RigPlant(CHANNELS, motor=MotorConfig(faults=faults)) for faults in ((), (Fault("bearing", 50.0),))
    )
    apart = []
    for k in range(400):
        healthy.step(178, STEP_S)
        faulty.step(178, STEP_S)
        if healthy.temperatures != faulty.temperatures:
            apart.append(k * STEP_S)
    assert apart[0] == pytest.approx(50.0, abs=2 * STEP_S)


def test_ambient_and_load_move() -> None:
    idle = RigPlant(CHANNELS, ambient_degC=lambda t: 30.0 + t)
    loaded = RigPlant(CHANNELS, ambient_degC=lambda t: 30.0 + t, load_Nm=0.5)
    for _ in range(200):
        idle.step(200, STEP_S)
        loaded.step(200, STEP_S)
    assert idle.temperatures["ambient"] == pytest.approx(30.0 + 199 * STEP_S, abs=STEP_S)
    assert loaded.temperatures["winding"] > idle.temperatures["winding"] + 1.0


def test_a_channel_that_the_motor_does_not_have() -> None:
    with pytest.raises(InputError, match='no part "gearbox"; it is the MY1016 and has winding, brush'):
        RigPlant(("brush", "gearbox"))


def test_a_column_is_the_sensor_of_the_node_that_it_names() -> None:
    plain, named = (
        RigPlant(channels, start_degC={"winding": 60.0}, seed=3) for channels in (("winding",), ("winding_degC",))
    )
    for _ in range(20):
        assert plain.step(200, STEP_S).words["winding"] == named.step(200, STEP_S).words["winding_degC"]
