"""Motors that somebody changes while they run: what they become, and what they become again."""

from __future__ import annotations

import numpy as np
import pytest

from gen.coefficients import load
from gen.emulate.plants.model_plant import ModelPlant
from gen.emulate.plants.plant import STEP_S, Changeable
from gen.emulate.plants.rig import RigPlant
from gen.errors import InputError
from gen.rig import SensorFault
from gen.rig.sensors import decode
from tests.examples import ROOT

CHANNELS = ("brush", "casing", "ambient")


def plant(kind: str) -> Changeable:
    if kind == "rig":
        return RigPlant(CHANNELS)
    names = {"my1016": CHANNELS, "two_nodes": ("winding", "casing", "ambient"), "network": ("ambient",)}[kind]
    return ModelPlant(load(ROOT / "examples" / kind / "coeffs.json"), names)


def run(motor: Changeable, seconds: float) -> dict[str, float]:
    for _ in range(round(seconds / STEP_S)):
        motor.step(200, STEP_S)
    return dict(motor.temperatures)


@pytest.mark.parametrize("kind", ["rig", "my1016", "two_nodes", "network"])
def test_each_fault_that_is_offered_changes_the_motor(kind: str) -> None:
    healthy = run(plant(kind), 300.0)
    for fault in plant(kind).typical_faults:
        motor = plant(kind)
        motor.set_faults(fault)
        assert max(abs(value - healthy[name]) for name, value in run(motor, 300.0).items()) > 0.01, fault


@pytest.mark.parametrize("kind", ["rig", "my1016", "two_nodes"])
def test_a_motor_that_is_healed_at_once_is_as_if_nothing_had_been(kind: str) -> None:
    motor = plant(kind)
    motor.set_faults(motor.typical_faults[0])
    motor.set_faults("")
    assert run(motor, 60.0) == run(plant(kind), 60.0)


@pytest.mark.parametrize(
    ("kind", "fault"), [("rig", "heat:brush=+50%"), ("my1016", "bearing"), ("my1016", "path:a-b=-5%")]
)
def test_a_fault_that_it_cannot_have_is_refused_and_changes_nothing(kind: str, fault: str) -> None:
    motor = plant(kind)
    with pytest.raises(InputError):
        motor.set_faults(fault)
    assert run(motor, 10.0) == run(plant(kind), 10.0)


@pytest.mark.parametrize("kind", ["rig", "my1016"])
def test_a_thermocouple_breaks_and_is_mended(kind: str) -> None:
    motor = plant(kind)
    run(motor, 5.0)
    motor.set_sensor_faults("casing", (SensorFault("open", 5.0),))
    broken = motor.step(200, STEP_S).words
    assert np.isnan(decode(broken["casing"]))
    assert decode(broken["brush"]) > 20.0
    motor.set_sensor_faults("casing", ())
    assert decode(motor.step(200, STEP_S).words["casing"]) > 20.0


@pytest.mark.parametrize("kind", ["rig", "my1016"])
def test_the_room_gets_the_temperature_that_is_asked_for(kind: str) -> None:
    motor = plant(kind)
    motor.set_ambient(12.5)
    assert run(motor, 1.0)["ambient"] == 12.5


def test_a_load_slows_the_rig_by_its_torque_over_its_constants_and_is_taken_off_again() -> None:
    """The sag of a permanent-magnet motor, R T / k^2, with the winding's 0.35 ohm at 25 degC and 0.0865 Nm/A."""
    motor = RigPlant(CHANNELS)
    run(motor, 5.0)
    free_rpm = motor.motor.speed_rpm
    assert motor.largest_load_Nm == 1.0
    motor.set_load(0.5)
    run(motor, 5.0)
    sag_rpm = 0.35 * (1.0 + 0.0039 * (motor.temperatures["winding"] - 25.0)) * 0.5 / 0.0865**2 * 60.0 / (2.0 * np.pi)
    assert free_rpm - motor.motor.speed_rpm == pytest.approx(sag_rpm, rel=0.1)
    run(motor, 300.0)
    unloaded = plant("rig")
    run(unloaded, 310.0)
    assert motor.temperatures["winding"] > unloaded.temperatures["winding"] + 2.0
    motor.set_load(0.0)
    run(motor, 5.0)
    assert motor.motor.speed_rpm == pytest.approx(free_rpm, rel=0.02)


def test_a_coefficient_file_knows_no_torque() -> None:
    motor = plant("my1016")
    assert motor.largest_load_Nm == 0.0
    with pytest.raises(InputError, match="says nothing of torque"):
        motor.set_load(0.1)
