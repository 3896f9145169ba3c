"""The sketch with channels and effects on the emulated Mega: what it reads, logs, tells the model, and keeps."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from gen.arrays import IntArray
from gen.avr.compile import ArduinoCore, build_elf
from gen.coefficients import Coefficients, parse
from gen.coefficients.wiring import Thermocouple
from gen.errors import InputError
from gen.firmware.project import project_files
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.reference.model import ReferenceModel
from tests.device.board import OPEN, Board
from tests.effects.cases import effect
from tests.examples import ROOT

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
GEARBOX = "gearbox_degC"
COUPLED = [effect("coupling", "casing", source=GEARBOX, conductance_per_s=5e-3)]
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
    return _built(refined, program, cache)


def _built(refined: Coefficients, program: Program, cache: Path) -> Path:
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
    board.pins.drive_analog(CURRENT, ZERO_V + amperes / PER_V)
    board.pins.drive(FAN, False if fan else None)


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
            # The board gives out whole thousandths, to nearest.
            given = [float(row[f"{name}_model_degC"]) for name in names]
            assert given == pytest.approx(reference.rises[:, 0] + 24.5, abs=0.00051), row
            compared += 1
        acting = int(row["pwm"])
    assert compared > 190
    rise = float(rows[-1]["bearing_model_degC"]) - float(rows[0]["bearing_model_degC"])
    assert rise > 4.0, "the current must have heated the bearing"


def _told(row: dict[str, str]) -> IntArray:
    values = [24.5, float(row["current_A"]), float(row["fan"])]
    return np.array([[round(value * 1000.0)] for value in values])


@pytest.mark.parametrize("volts", [5.0, 0.0])  # 25 A, either way
def test_a_channel_out_of_range_is_not_used_and_flagged(board: Board, volts: float) -> None:
    _drive(board, 5.0, fan=False)
    board.started()
    assert float(board.hear(4.0).rows[-1]["current_A"]) == pytest.approx(5.0, abs=COUNTS)
    board.pins.drive_analog(CURRENT, volts)
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
    board.cut_power(1.0, seed=2)  # nothing is left in RAM
    after = board.started()
    assert after.events[-1].endswith("start from memory")
    start, then = float(after.rows[0]["bearing_model_degC"]), [float(row["bearing_model_degC"]) for row in copied]
    assert then[0] > 50.0, "only the effect heats here"
    assert min(abs(start - value) for value in then) < 1.0, "a copy is made every minute"


@pytest.fixture(scope="module")
def coupled() -> Coefficients:
    """The MY1016 beside a gearbox with a thermocouple of its own, wired instead of the bearing's."""
    document = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    chips = document["wiring"]["thermocouples"]
    next(chip for chip in chips if chip["channel"] == "bearing")["channel"] = GEARBOX
    next(chip for chip in chips if chip["channel"] == GEARBOX)["max_degC"] = 150.0
    return parse(json.dumps({**document, "effects": COUPLED}).encode())


def test_a_thermocouple_of_its_own_is_a_channel(coupled: Coefficients, tmp_path: Path) -> None:
    program = lower(coupled, "fixed", "table")
    assert program.effects is not None
    assert [(c.low, c.high) for c in program.effects.channels[1:]] == [(0, 150_000)], "its plausible range"
    board = Board(_built(coupled, program, tmp_path), tmp_path, coupled)
    first = board.started()
    assert "bearing_degC" not in first.columns
    board.send("rows 1")
    rows = [*first.rows, *board.hear(2.0).rows]
    for celsius in np.linspace(30.5, 70.0, 80):
        board.set_celsius(GEARBOX, float(celsius))
        rows += board.hear(0.25).rows
    rows += board.hear(1.0).rows
    assert rows[-1][GEARBOX] == "70.00"
    assert not any(int(row["flags"]) & CHANNEL for row in rows)
    board.chips[GEARBOX].set_word(OPEN)
    lost = board.hear(10.0).rows
    kept = [row for row in lost if row[GEARBOX] == ""]
    assert len(kept) > 35
    assert all(int(row["flags"]) & CHANNEL for row in kept)
    place = [chip.channel for chip in _thermocouples(coupled)].index(GEARBOX)
    assert kept[-1]["sensors"][place] == "1"
    board.set_celsius(GEARBOX, 69.0)
    again = board.hear(3.0).rows
    assert again[-1][GEARBOX] == "69.00"
    assert not int(again[-1]["flags"]) & CHANNEL
    rows += [*lost, *again]

    names = program.model.component_names
    # The board's model is the reference's, told what was believed; while nothing is, what was believed last.
    reference = ReferenceModel(program, {name: [0] for name in names}, _told_of_gearbox(rows[0][GEARBOX]))
    sample, believed, index = 0, rows[0][GEARBOX], names.index("casing")
    for row in rows:
        believed = row[GEARBOX] or believed
        while sample < round(float(row["time_s"]) * 4):
            sample += 1
            reference.set_channels(_told_of_gearbox(believed))
            reference.step(np.array([0]))
        assert round(float(row["casing_model_degC"]) * 1000.0) == reference.rises_mK[index, 0] + 30_000, row
    assert float(rows[-1]["casing_model_degC"]) > 33.0, "the gearbox must have heated the casing"


def _thermocouples(coefficients: Coefficients) -> tuple[Thermocouple, ...]:
    assert coefficients.document.wiring is not None
    return coefficients.document.wiring.thermocouples


def _told_of_gearbox(celsius: str) -> IntArray:
    return np.array([[30_000], [round(float(celsius) * 1000.0)]])


@pytest.mark.parametrize("channel", ["bearing_degC", "Ambient_degC", "casing_model_degC", "current_degC", "gearbox"])
def test_a_column_that_is_taken_or_none_gets_no_thermocouple(channel: str) -> None:
    document = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    document["wiring"]["channels"] = [{"column": "current_degC", "analog_pin": CURRENT}]
    document["wiring"]["thermocouples"][1]["channel"] = channel
    with pytest.raises(InputError) as caught:
        parse(json.dumps(document).encode())
    assert caught.value.place == "$.wiring.thermocouples[1].channel"
