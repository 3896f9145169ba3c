"""The look ahead of the firmware on the emulated Mega, beside a motor that then does what was said."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from gen.coefficients import Coefficients, parse
from gen.emulate.plants.model_plant import ModelPlant
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


def test_a_motor_that_cannot_run_on_is_held_at_what_it_can_and_comes_back_by_itself(core: object, cache: Path) -> None:
    """Full PWM would take the coil to 113 degC; asked for less for a while, and then backwards."""
    wiring = BY_HAND["wiring"] | {"drive": {"forward_pin": 4, "reverse_pin": 5, "reversal_pause_s": 0}}
    forecast = {
        "horizon_s": 1200,
        "steps_per_sample": 100,
        "near_s": 40,
        "limits": [{"component": "coil", "limit_degC": LIMIT_degC}],
    }
    table = [{"cause": "limit_near", "action": "derate", "derate_pwm": "holdable"}]
    coefficients = foreseeing(wiring=wiring, forecast=forecast, protection=table)
    plant = ModelPlant(coefficients, ["shell", "coil", "ambient"], ambient_degC=25.0, pulses_per_revolution=100)
    less_s, back_s = 800.0, 1000.0
    profile = ((0.0, FULL), (less_s, DERATED), (back_s, -FULL))
    columns = run(coefficients, plant, cache, 1150.0, profile).columns
    time, pwm, coil = columns["time_s"], columns["pwm"], columns["coil_model_degC"]
    assert coil.max() <= LIMIT_degC, "never beyond"
    derated = (time < less_s - 5.0) & (time > time[np.argmax(pwm < FULL)])
    steady = derated & (time > 600.0)
    assert pwm[derated].min() > 0 and pwm[derated].max() < FULL, "it never stands, and is never let go meanwhile"
    assert np.ptp(pwm[steady]) <= 2, "it does not hunt"
    assert coil[steady].max() > LIMIT_degC - 4.0, "and is held at what it can, not at less"
    said = columns["holdable_pwm"][steady]
    assert np.abs(said - pwm[steady]).max() <= 2
    held_W = 3e-4 * float(np.median(pwm[steady])) ** 2
    assert 0.93 * (LIMIT_degC - 25.0) < held_W * (1 / 0.4 + 1 / 0.5) <= LIMIT_degC - 25.0, (
        "for ever is the steady state"
    )
    assert set(pwm[(time > less_s + 2.0) & (time < back_s - 5.0)].tolist()) == {DERATED}, "never more than is asked for"
    again = pwm[time > back_s + 2.0]
    assert again[0] == -FULL, "it comes back by itself, and turns as it is told"
    assert again.max() < 0 and again[-1] > -FULL, "and is held again"
