"""A mistake in logging is told, and not learnt; a change of the motor or of a sensor is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.errors import InputError
from gen.refinement.network.mistaken import check_mistakes
from gen.runs import Run
from tests.refinement.network.motor import read, run, tree


def percent(run: Run) -> Run:
    return replace(run, pwm=np.rint(run.pwm / 2.55).astype(np.int64))


def exchanged(run: Run) -> Run:
    return replace(run, temps={"winding": run.temps["casing"], "casing": run.temps["winding"]})


@pytest.mark.parametrize(
    ("mistake", "place", "said"),
    [
        (percent, "column pwm", "PWM looks like percent, where the file's is in counts"),
        (exchanged, "column winding_degC", "winding_degC and casing_degC look like each other's"),
    ],
)
def test_it_is_refused_with_the_run_and_the_column(mistake: type, place: str, said: str) -> None:
    motor = read(tree())
    right = run(motor, 1)
    with pytest.raises(InputError) as told:
        check_mistakes(motor, [("monday.csv", right), ("tuesday.csv", mistake(run(motor, 2)))])
    assert (told.value.file, told.value.place) == ("tuesday.csv", place)
    assert said in told.value.message


def test_what_became_of_a_motor_or_a_sensor_is_none() -> None:
    motor = read(tree())
    worn, blocked = tree(), tree()
    worn["network"]["heats"][0]["power_W"] = {"poly": [0.0003, 0.02, 0.0]}
    blocked["network"]["paths"][1]["conductance_W_per_K"]["power"]["forced"] = 0.0
    runs = [(f"run {seed}", run(read(other), seed)) for seed, other in enumerate((worn, blocked), 1)]
    apart = run(motor, 3)
    off = {name: values + by for (name, values), by in zip(apart.temps.items(), (-12.0, 12.0), strict=True)}
    slow = run(motor, 4)
    check_mistakes(
        motor, [*runs, ("offsets", replace(apart, temps=off)), ("slow", replace(slow, pwm=np.minimum(slow.pwm, 100)))]
    )
