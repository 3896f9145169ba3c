"""The look ahead of the firmware on the emulated Mega, beside a motor that then does what was said."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from gen.coefficients import Coefficients, parse
from gen.emulate.model_plant import ModelPlant
from gen.emulate.results import Results
from tests.emulate.test_scenario import BY_HAND, run

LIMIT_degC = 60.0
FULL, DERATED = 255, 60


def foreseeing(**others: object) -> Coefficients:
    forecast = {
        "horizon_s": 300,
        "steps_per_sample": 40,
        "near_s": 15,
        "limits": [{"component": "coil", "limit_degC": LIMIT_degC}],
    }
    return parse(json.dumps(BY_HAND | {"forecast": forecast, "alarms": []} | others).encode())


def ran(coefficients: Coefficients, cache: Path, seconds: float) -> Results:
    channels = ["shell", "coil", "ambient"]
    plant = ModelPlant(coefficients, channels, ambient_degC=25.0, pulses_per_revolution=100)
    return run(coefficients, plant, cache, seconds, ((0.0, FULL),))


def test_the_limit_is_reached_when_the_rows_have_said_that_it_will(core: object, cache: Path) -> None:
    columns = ran(foreseeing(), cache, 150.0).columns
    time, said = columns["time_s"], columns["time_to_limit_s"]
    reached_s = float(time[np.argmax(columns["coil_model_degC"] >= LIMIT_degC)])
    assert 60.0 < reached_s < 140.0
    known = np.isfinite(said) & (time < reached_s)
    assert time[known].min() < 5.0
    early_s = reached_s - time[known] - said[known]
    # No later; and earlier by a row, a second that is cut, and a count of the sensor, which is 0.25 K of 0.25 K/s.
    assert early_s.min() >= 0.0
    assert early_s.max() < 3.5
    held = columns["holdable_pwm"][time < reached_s]
    assert 0 < np.nanmin(held) <= np.nanmax(held) < FULL


def test_a_motor_that_is_derated_in_time_never_reaches_its_limit_and_runs_on(core: object, cache: Path) -> None:
    wiring = BY_HAND["wiring"] | {"drive": {"forward_pin": 4, "reverse_pin": 5}}
    table = [{"cause": "limit_near", "action": "derate", "derate_pwm": DERATED}]
    columns = ran(foreseeing(wiring=wiring, protection=table), cache, 400.0).columns
    pwm = columns["pwm"]
    assert columns["coil_degC"].max() < LIMIT_degC
    first = int(np.argmax(pwm == DERATED))
    assert pwm[first] == DERATED
    assert columns["coil_degC"][first:].min() > LIMIT_degC - 10.0
    later = pwm[first:]
    assert {DERATED, FULL} == set(later.tolist()), "it comes back to what is asked for when there is time again"
    # By the PWM that acts, a derating would end its own cause and come back every few seconds.
    assert np.count_nonzero(np.diff(later)) < 0.1 * later.size
