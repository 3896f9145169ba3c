"""What drives a model along a run: the same for simulation and refinement but for the ambient that nothing declares."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, parse
from gen.errors import InputError
from gen.refinement.condense import free_run
from gen.replay import ambient_column, check_inputs, inputs_of, read_for
from tests.examples import ROOT

TREE = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
FIXED = TREE["ambient"]
AIRFLOW = {"name": "airflow", "component": "casing", "parameters": {"channel": "fan", "cooling_per_s": 0.001}}
AMBIENT = {"name": "ambient", "component": "casing", "parameters": {"delayed": True}}
RUN = """time_s,pwm,casing_degC,brush_degC,room_degC,ambient_degC,fan,empty
0,100,,,21,22,,
10,100,33,,,23,1,
20,0,34,,25,,,
"""


def model(**changes: object) -> Coefficients:
    return parse(json.dumps(TREE | changes).encode())


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "run.csv"
    file.write_text(RUN)
    return file


def test_gaps_are_held_and_what_was_never_measured_is_not_there(path: Path) -> None:
    coefficients = model()
    found = inputs_of(coefficients, read_for(coefficients, path), "run.csv")
    assert found.ambient.tolist() == [30.0, 30.0, 30.0]
    assert found.measured_ambient is not None
    assert found.measured_ambient.tolist() == [22.0, 23.0, 23.0]
    assert {name: values.tolist() for name, values in found.channels.items()} == {
        "room_degC": [21.0, 21.0, 25.0],
        "fan": [1.0, 1.0, 1.0],
    }
    assert found.first_rise == {"casing": 3.0}


def test_a_part_starts_from_the_first_reading_that_it_can_have(tmp_path: Path) -> None:
    """What a sensor says before it works (-45 degC, or 850 degC of a converter) is none that a board takes."""
    coefficients = model()
    file = tmp_path / "run.csv"
    file.write_text("time_s,pwm,casing_degC,brush_degC\n0,100,-45,-60\n10,100,1800,-60\n20,100,34,\n")
    found = inputs_of(coefficients, read_for(coefficients, file), "run.csv")
    assert found.first_rise == {"casing": 4.0, "brush": -90.0}


@pytest.mark.parametrize(
    ("ambient", "effects", "as_declared", "counted_from"),
    [
        (FIXED, [], True, [30.0, 30.0, 30.0]),
        (FIXED, [], False, [22.0, 23.0, 23.0]),
        (FIXED, [AMBIENT], False, [30.0, 30.0, 30.0]),
        ({**FIXED, "channel": "room_degC"}, [], True, [21.0, 21.0, 25.0]),
        ({**FIXED, "channel": "room_degC"}, [], False, [21.0, 21.0, 25.0]),
    ],
)
def test_the_ambient_that_rises_count_from(
    path: Path, ambient: dict[str, Any], effects: list[Any], as_declared: bool, counted_from: list[float]
) -> None:
    coefficients = model(ambient=ambient, effects=effects)
    found = inputs_of(coefficients, read_for(coefficients, path), "run.csv", as_declared=as_declared)
    assert found.ambient.tolist() == counted_from
    assert found.first_rise == {"casing": 33.0 - counted_from[1]}


def test_what_is_missing_is_named() -> None:
    check_inputs(model(effects=[AIRFLOW, AMBIENT]), {"fan"}, True, "run.csv")
    for effects, message in (
        ([AIRFLOW], 'the effect "airflow" of casing needs the column fan'),
        ([AMBIENT], 'the effect "ambient" of casing needs the column ambient_degC'),
    ):
        with pytest.raises(InputError, match=message) as refused:
            check_inputs(model(effects=effects), {"empty"}, False, "run.csv")
        assert (refused.value.file, refused.value.place) == ("run.csv", "header")
    channel = {key: value for key, value in FIXED.items() if key != "fixed_degC"} | {"channel": "room_degC"}
    coefficients = model(ambient=channel)
    assert ambient_column(coefficients) == "room_degC"
    with pytest.raises(InputError, match="the column room_degC is missing"):
        check_inputs(coefficients, (), False, "run.csv")


def test_a_run_without_ambient_is_judged_as_if_the_room_were_as_declared(tmp_path: Path) -> None:
    """A refined model may know an ambient that a test run lacks: the effect does nothing there, as on the board."""
    path = tmp_path / "run.csv"
    path.write_text("time_s,pwm,casing_degC\n" + "".join(f"{60 * i},150,{30 + i}\n" for i in range(20)))
    _, plain = free_run(model(), model(), path)
    _, with_effect = free_run(model(), model(effects=[AMBIENT]), path)
    np.testing.assert_allclose(with_effect["casing"], plain["casing"], atol=1e-9)


@pytest.mark.parametrize(("noted", "known"), [("21.5", True), ("warm", False), ("nan", False), ("inf", False)])
def test_a_noted_ambient_is_taken_where_no_column_has_it(tmp_path: Path, noted: str, known: bool) -> None:
    coefficients = model(ambient={"channel": "ambient_degC"})
    file = tmp_path / "run.csv"
    file.write_text(f"# ambient_degC: {noted}\ntime_s,pwm,casing_degC\n0,100,30\n10,100,33\n")
    if known:
        run = read_for(coefficients, file)
        assert inputs_of(coefficients, run, "run.csv").ambient.tolist() == [21.5, 21.5]
        assert inputs_of(coefficients, run, "run.csv").first_rise == {"casing": 8.5}
    else:
        with pytest.raises(InputError, match=f'# ambient_degC: found "{noted}", expected a temperature in degC'):
            read_for(coefficients, file)
    measured = tmp_path / "measured.csv"
    measured.write_text(RUN.replace("time_s", f"# ambient_degC: {noted}\ntime_s"))
    assert inputs_of(coefficients, read_for(coefficients, measured), "m.csv").ambient.tolist() == [22.0, 23.0, 23.0]
