"""The rules that `gen thresholds` derived for the simulated motor: quiet while healthy, right about its faults."""

from __future__ import annotations

import numpy as np

from gen.coefficients import load
from gen.emulate.plants.rig import RigPlant
from gen.emulate.plants.twin import alarm_times
from gen.rig import Fault, MotorConfig, Profile, sensors, warm_start
from tests.examples import ROOT

FAULT_S, DURATION_S = 900.0, 2500.0
PWM = 230
EXAMPLE = ROOT / "examples" / "my1016_rig" / "coeffs.json"


def test_the_thresholds_lie_outside_the_declared_error() -> None:
    assert not [text for text in load(EXAMPLE).warnings if "alarms" in text]


def test_a_healthy_motor_is_quiet_and_both_faults_are_told_apart() -> None:
    coefficients = load(EXAMPLE)
    names = [rule.name for rule in coefficients.document.alarms]
    wiring = coefficients.document.wiring
    assert wiring is not None
    channels = [chip.channel for chip in wiring.thermocouples]
    motors = [
        MotorConfig(),
        MotorConfig(),
        MotorConfig(faults=(Fault("bearing", FAULT_S),)),
        MotorConfig(faults=(Fault("brush", FAULT_S),)),
    ]
    warm = warm_start(Profile((0.0,), (153,), 5400.0))
    starts = [None, warm, None, None]
    plants = [
        RigPlant(channels, motor=motor, sensors=sensors(0), start_degC=start, seed=70 + number)
        for number, (motor, start) in enumerate(zip(motors, starts, strict=True))
    ]
    first = alarm_times(coefficients, plants, [PWM] * len(plants), DURATION_S)
    raised = [{name: t for name, t in zip(names, row, strict=True) if not np.isnan(t)} for row in first]
    assert raised[0] == {}
    assert raised[1] == {}
    assert min(raised[2].values()) > FAULT_S
    assert min(raised[3].values()) > FAULT_S
    assert {"casing_hot", "bearing_fault"} <= raised[2].keys()
    assert "brush_fault" not in raised[2]
    assert {"casing_hot", "brush_fault"} <= raised[3].keys()
    assert "bearing_fault" not in raised[3]
