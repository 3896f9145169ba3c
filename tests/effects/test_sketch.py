"""The sketch with channels and effects on the emulated Mega: what it reads, logs, tells the model, and keeps."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gen.coefficients import Coefficients, parse
from gen.firmware.project import project_files
from gen.lowering.lower import Program, lower
from gen.reference.model import ReferenceModel
from gen.verify.avr.compile import ArduinoCore, build_elf
from tests.device.board import Board
from tests.effects.cases import effect
from tests.verify_helpers import ROOT

CURRENT, FAN = 54, 62
ZERO_V, PER_V = 2.5, 10.0
CHANNEL = 0x8000
COUNTS = 2.2 * 5.0 / 1024 * PER_V
"""Two counts of the converter: simavr rounds down twice."""
EFFECTS = [
    effect("load_heating", "bearing", heating_K_per_s_A2=2e-3),
    effect("airflow", "casing", channel="fan", cooling_per_s=2e-3),
    effect("sensor_lag", "casing", lag_s=20.0),
    effect("sensor_offset", "magnet", offset_K=1.5),
]
INPUTS = [
    {"column": "current_A", "analog_pin": CURRENT, "zero_V": ZERO_V, "per_V": PER_V, "min": -20.0, "max": 20.0},
    {"column": "fan", "contact_pin": FAN},
]


@pytest.fixture(scope="module")
def refined() -> Coefficients:
    document = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    document["wiring"]["channels"] = INPUTS
    document["wiring"]["memory"] = {"interval_s": 60}
    return parse(json.dumps({**document, "effects": EFFECTS}).encode())


@pytest.fixture(scope="module")
def program(refined: Coefficients) -> Program:
    return lower(refined, "fixed", "table")


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("effects-cache")


@pytest.fixture(scope="module")
def elf(refined: Coefficients, program: Program, cache: Path) -> Path:
    for path, text in project_files(refined, program, "coeffs.json", None).items():
        target = cache / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text)
    library = cache / "lib" / "my1016" / "src"
    sources = sorted([*(cache / "src").glob("*.cpp"), *library.glob("*.cpp")])
    core = ArduinoCore(cache)
    return build_elf(sources, [cache / "src", library], cache / "firmware.elf", core=core, optimisation="-Os")


@pytest.fixture
def board(refined: Coefficients, elf: Path, cache: Path) -> Board:
    board = Board(elf, cache, refined)
    _drive(board, 0.0, fan=False)
    return board


def _drive(board: Board, amperes: float, *, fan: bool) -> None:
    board.drive_analog(CURRENT, ZERO_V + amperes / PER_V)
    board.drive_pin(FAN, False if fan else None)


def test_channels_are_logged_and_act_as_in_the_reference(board: Board, program: Program) -> None:
    board.set_celsius("ambient", 24.5)
    first = board.started()
    assert {"current_A", "fan"} <= set(first.columns)
    board.send("rows 1")
    rows = [*first.rows, *board.hear(2.0).rows]
    _drive(board, 12.0, fan=False)
    board.send("255")
    rows += board.hear(25.0).rows
    assert float(rows[-1]["current_A"]) == pytest.approx(12.0, abs=COUNTS)
    _drive(board, -6.0, fan=True)
    rows += board.hear(25.0).rows
    assert float(rows[-1]["current_A"]) == pytest.approx(-6.0, abs=COUNTS)
    assert {row["fan"] for row in rows} == {"0.000", "1.000"}
    names = program.model.component_names
    reference = ReferenceModel(program, {name: [5500] for name in names}, _told(rows[0]))
    acting, sample, compared = 0, 0, 0
    for row in rows:
        while sample < round(float(row["time_s"]) * 4):
            sample += 1
            reference.set_channels(_told(row))
            reference.step(np.array([acting]))
        if sample:
            # The board gives out whole thousandths, rounded down.
            given = [float(row[f"{name}_model_degC"]) for name in names]
            assert given == pytest.approx(reference.rises[:, 0] + 24.5, abs=0.00201), row
            compared += 1
        acting = int(row["pwm"])
    assert compared > 190
    rise = float(rows[-1]["bearing_model_degC"]) - float(rows[0]["bearing_model_degC"])
    assert rise > 4.0, "the current must have heated the bearing"


def _told(row: dict[str, str]) -> NDArray[np.int64]:
    values = [24.5, float(row["current_A"]), float(row["fan"])]
    return np.array([[round(value * 1000.0)] for value in values])


def test_a_channel_out_of_range_is_not_used_and_flagged(board: Board) -> None:
    _drive(board, 5.0, fan=False)
    board.started()
    assert float(board.hear(4.0).rows[-1]["current_A"]) == pytest.approx(5.0, abs=COUNTS)
    board.drive_analog(CURRENT, 5.0)  # 25 A
    row = board.hear(4.0).rows[-1]
    assert row["current_A"] == ""
    assert int(row["flags"]) & CHANNEL
    _drive(board, 5.0, fan=False)
    row = board.hear(4.0).rows[-1]
    assert not int(row["flags"]) & CHANNEL


def test_states_of_the_effects_outlast_a_reset(board: Board) -> None:
    _drive(board, 15.0, fan=False)
    board.started()
    rows = board.hear(160.0).rows
    copied = [next(row for row in rows if float(row["time_s"]) >= time) for time in (60.0, 120.0)]
    board.press_reset()
    after = board.started()
    assert after.events[-1].endswith("start from memory")
    start, then = float(after.rows[0]["bearing_model_degC"]), [float(row["bearing_model_degC"]) for row in copied]
    assert then[0] > 50.0, "only the effect heats here"
    assert min(abs(start - value) for value in then) < 1.0, "a copy is made every minute"
