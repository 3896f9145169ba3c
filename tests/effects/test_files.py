"""Files with effects: what `gen simulate` makes of them, wiring that cannot be, the report, the schema."""

from __future__ import annotations

import json
import re
from typing import Any, Literal

import numpy as np
import pytest

from gen.coefficients import Coefficients, parse
from gen.errors import InputError
from gen.firmware.effects_report import effect_rows
from gen.firmware.project import project_files
from gen.lowering.lower import lower
from gen.reference.simulate import simulate_run
from gen.runs import Run
from tests.effects.cases import effect
from tests.examples import ROOT

PLAIN = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))


def _with(*effects: dict[str, Any], **changes: object) -> Coefficients:
    return parse(json.dumps({**PLAIN, **changes, "effects": list(effects)}).encode())


def _run() -> Run:
    time = np.arange(0.0, 600.0, 1.0)
    return Run(
        time_s=time,
        pwm=np.where(time < 300, 200, -80).astype(np.int64),
        temps={name: np.full(time.size, 35.0) for name in ("brush", "bearing", "magnet", "casing")},
        ambient=np.where(time < 200, 25.0, 27.0),
        extras={"current_A": np.where(time % 60 < 30, 6.0, 1.0)},
    )


@pytest.mark.parametrize(("arithmetic", "limit"), [("fixed", 2e-3), ("float", 3e-3)])
def test_simulation_in_the_boards_arithmetic_follows_the_exact_one(
    arithmetic: Literal["fixed", "float"], limit: float
) -> None:
    coefficients = _with(
        effect("load_heating", "casing", heating_K_per_s_A2=5e-4),
        effect("coupling", "bearing", source="casing", conductance_per_s=3e-4),
        effect("direction", "magnet", reverse_heating=0.4),
        effect("sensor_offset", "magnet", offset_K=1.0),
    )
    exact = simulate_run(coefficients, _run(), "exact", "measured", "run.csv")
    board = simulate_run(coefficients, _run(), arithmetic, "measured", "run.csv")
    for name in ("bearing", "magnet", "casing"):
        # The exact solution takes channels and ambient straight between rows in part: whence the limit.
        assert np.max(np.abs(board[f"{name}_degC"] - exact[f"{name}_degC"])) < limit
    plain = simulate_run(_with(), _run(), arithmetic, "measured", "run.csv")
    assert np.max(np.abs(board["casing_degC"] - plain["casing_degC"])) > 3.0


def test_a_missing_channel_is_named() -> None:
    run = _run()
    coefficients = _with(effect("supply_voltage", "casing", nominal_V=24.0))
    with pytest.raises(InputError, match='"supply_voltage" of casing needs the column voltage_V'):
        simulate_run(coefficients, run, "fixed", "measured", "run.csv")


@pytest.mark.parametrize(
    ("channel", "place"),
    [
        ({"column": "current_A"}, "$.wiring.channels[0]"),
        ({"column": "current_A", "analog_pin": 54, "contact_pin": 55}, "$.wiring.channels[0]"),
        ({"column": "current_A", "analog_pin": 22}, "$.wiring.channels[0].analog_pin"),
        ({"column": "current_A", "analog_pin": 54, "per_V": 0.0}, "$.wiring.channels[0].per_V"),
        ({"column": "current_A", "analog_pin": 54, "min": 3.0, "max": 1.0}, "$.wiring.channels[0].max"),
        ({"column": "current_A", "analog_pin": 54, "per_V": 1e300, "max": 1.0}, "$.wiring.channels[0].per_V"),
        ({"column": "fan", "contact_pin": 13}, "$.wiring.channels[0].contact_pin"),
        ({"column": "pwm", "contact_pin": 55}, "$.wiring.channels[0].column"),
        ({"column": "ambient_degC", "analog_pin": 55}, "$.wiring.channels[0].column"),
        ({"column": "casing_model_degC", "analog_pin": 55}, "$.wiring.channels[0].column"),
        ({"column": "a b", "contact_pin": 55}, "$.wiring.channels[0].column"),
    ],
)
def test_a_channel_that_cannot_be_is_refused_with_its_place(channel: dict[str, Any], place: str) -> None:
    wiring = {**PLAIN["wiring"], "channels": [channel]}
    with pytest.raises(InputError) as caught:
        _with(wiring=wiring)
    assert caught.value.place == place


LAG = effect("sensor_lag", "casing", lag_s=20.0)


@pytest.mark.parametrize(
    ("effects", "place", "message"),
    [
        ([effect("antigravity", "casing")], "$.effects[0].name", "expected the name of an effect"),
        ([effect("sensor_lag", "rotor", lag_s=20.0)], "$.effects[0].component", 'found "rotor"'),
        ([effect("sensor_lag", "casing")], "$.effects[0].parameters", 'missing key "lag_s"'),
        ([effect("sensor_lag", "casing", lag_s=-20.0)], "$.effects[0].parameters.lag_s", "expected at least 1"),
        ([effect("sensor_lag", "casing", lag_s=True)], "$.effects[0].parameters.lag_s", "found true"),
        ([effect("sensor_lag", "casing", lag_s="20")], "$.effects[0].parameters.lag_s", "expected a number"),
        ([effect("sensor_lag", "casing", lag=20.0)], "$.effects[0].parameters.lag", 'expected "lag_s"'),
        ([LAG, {**LAG, "evidence": {"p": 0.01}}], "$.effects[1]", "there already"),
        (
            [effect("coupling", "casing", source="casing", conductance_per_s=1e-4)],
            "$.effects[0].parameters.source",
            'found "casing", expected the name of another component',
        ),
        (
            [effect("coupling", "casing", source="bearin", conductance_per_s=1e-4)],
            "$.effects[0].parameters.source",
            'found "bearin"',
        ),
        (
            [effect("load_heating", "casing", channel="pwm", heating_K_per_s_A2=1e-4)],
            "$.effects[0].parameters.channel",
            "every run file's own",
        ),
        (
            [effect("load_heating", "casing", channel="load\n#error", heating_K_per_s_A2=1e-4)],
            "$.effects[0].parameters.channel",
            "cannot be the name",
        ),
        (
            [effect("schedule_error", "casing", pwm=[50, 100], gain_factor=[1.0])],
            "$.effects[0].parameters",
            "1 factors for 2 PWM levels",
        ),
    ],
)
def test_an_effect_that_cannot_be_is_refused_with_its_place(
    effects: list[dict[str, Any]], place: str, message: str
) -> None:
    with pytest.raises(InputError) as caught:
        _with(*effects)
    assert caught.value.place == place
    assert message in caught.value.message


def test_columns_that_differ_in_signs_alone_are_different_channels_in_the_firmware() -> None:
    columns = ["load 1", "load_1", "LOAD_1", "\u00e4", "ambient"]
    coefficients = _with(
        *(effect("load_heating", "casing", channel=column, heating_K_per_s_A2=1e-4) for column in columns)
    )
    files = project_files(coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", None)
    found = re.findall(r"MY1016_(CHANNEL_\w+),  // ", files["lib/my1016/src/my1016.h"])
    assert len(found) == len(set(found)) == len(columns) + 1


def test_the_report_has_each_effects_gain_beside_its_cost() -> None:
    lag = effect("sensor_lag", "casing", lag_s=20.0)
    lag["evidence"] = {"left_out_rmse_K": {"before": 1.25, "after": 0.3}}
    coefficients = _with(lag, effect("standstill_cooling", "bearing", cooling_factor=1.5))
    costs = [{"name": "sensor_lag", "component": "casing", "cycles": 2800, "flash_bytes": 1100, "ram_bytes": 12}]
    rows = effect_rows(coefficients, {"effects": costs})
    assert rows[0][1:] == ("casing", "1.25", "0.3", "2800", "1100", "12")
    assert rows[1][2] == "not stated"
    assert rows[1][4].startswith("none")  # folded into the table
    assert effect_rows(coefficients, None)[0][4] == "not measured"
    text = project_files(coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", None)["report.html"]
    assert "a sensor that follows slowly" in text
    assert "1.25" in text


def test_the_built_project_declares_the_channels_and_says_how_an_effect_acts() -> None:
    coefficients = _with(effect("load_heating", "brush", heating_K_per_s_A2=2e-4))
    files = project_files(coefficients, lower(coefficients, "float", "onboard"), "coeffs.json", None)
    assert "MY1016_CHANNEL_CURRENT_A" in files["lib/my1016/src/my1016.h"]
    assert "E' = r (I^2 - I0^2) - rate E" in files["lib/my1016/src/my1016_effects.cpp"]
    assert json.loads(files["manifest.json"])["effects"]["channels"] == ["ambient_degC", "current_A"]
