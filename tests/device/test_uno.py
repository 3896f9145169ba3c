"""The sketch on an Uno: what its file may say, that it has room, and that an emulated ATmega328P runs it."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen import toolchain
from gen.avr.chip import UNO
from gen.avr.compile import sizes
from gen.coefficients import Coefficients, parse
from gen.coefficients.wiring.pins import PINS_OF
from gen.emulate.board import Board
from gen.emulate.firmware import build_firmware
from gen.emulate.plants.plant import Reading, word_of
from gen.errors import CheckFailed, InputError
from gen.firmware.boards import BOARDS
from gen.firmware.project import project_files
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from gen.reference.simulate import simulate_run
from gen.runs import read_run
from tests.examples import ROOT, example

TREE: dict[str, Any] = json.loads((ROOT / "tests" / "coefficients" / "version2" / "uno.json").read_text())
PULSES_PER_S = 500


class Warm:
    """A casing at 40 degC in a room of 25 degC, turning while it is driven."""

    def __init__(self, word: int = word_of(40.0)) -> None:
        self._word = word

    def step(self, pwm: int, dt_s: float) -> Reading:
        """See `gen.emulate.plants.plant.Plant.step`."""
        return Reading({"casing": self._word, "ambient": word_of(25.0)}, round(PULSES_PER_S * dt_s) if pwm else 0)


def changed(change: Callable[[dict[str, Any]], None]) -> Coefficients:
    tree = copy.deepcopy(TREE)
    change(tree)
    return parse(json.dumps(tree).encode())


def wired(**keys: object) -> Coefficients:
    return changed(lambda tree: tree["wiring"].update(keys))


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("uno")


@pytest.fixture
def board(cache: Path) -> Board:
    loaded = changed(lambda _: None)
    firmware = build_firmware(loaded, "fixed", "table", "uno.json", cache)
    assert sizes(firmware.elf).flash <= UNO.flash_bytes
    assert loaded.document.wiring is not None
    return Board(firmware.elf, cache, loaded.document.wiring, Warm(), encoder="true")


def run(board: Board, seconds: float) -> str:
    """Let it run beside its plant; give what it said."""
    end = board.seconds + seconds
    while board.seconds < end:
        board.begin_step()
        board.mega.run_seconds(board.steps_end_s - board.seconds)
        board.end_step()
    return board.mega.uart.take().decode()


def test_it_measures_drives_counts_and_follows_the_model(board: Board, tmp_path: Path) -> None:
    said = run(board, 6.0)
    board.command(153)
    said += run(board, 300.0)
    assert board.pwm == 153
    assert board.mega.pins.duty(9) == pytest.approx(153 / 255)
    path = tmp_path / "run.csv"
    path.write_text("".join(f"{line}\n" for line in said.splitlines() if line[:1] != "#"), encoding="utf-8")
    measured = read_run(path, ["casing"])
    assert measured.ambient is not None
    assert measured.ambient[-1] == 25.0
    assert measured.temps["casing"][-1] == 40.0
    assert measured.extras["speed_rpm"][-1] == pytest.approx(PULSES_PER_S * 60 / 20, rel=0.01)
    model = measured.extras["casing_model_degC"]
    shown = simulate_run(changed(lambda _: None), measured, "exact", "measured", "run.csv")["casing_degC"]
    assert np.ptp(model) > 1.0
    # A row says neither when in its second the PWM changed nor how the room's reading went within it.
    np.testing.assert_allclose(model, shown, atol=0.03)


def test_its_self_test_passes_and_a_copy_outlives_the_power(board: Board) -> None:
    run(board, 6.0)
    board.mega.uart.send(b"test\n")
    text = run(board, 30.0)
    assert "test passed" in text
    assert "test ram ok" in text
    run(board, 610.0)
    board.mega.cut_power(2.0)
    assert "start from memory" in run(board, 8.0)


SUM_40 = round(16 * 1024 * 5302 / (5302 + 1000))
"""Sixteen conversions of a thermistor at 40 degC on 1 kOhm: 10e3 exp(3950 (1/313.15 - 1/298.15)) = 5302 ohm."""
AMBIENT = {"channel": "ambient", "cs": 5, "so": 7, "sck": 8}
OTHERS: dict[str, dict[str, Any]] = {
    "converter, and PWM of Timer 2": {
        "thermocouples": [
            {
                "channel": "casing",
                **{"chip": "NTC", "analog_pin": 14, "r25_ohm": 10_000, "beta_K": 3950, "series_ohm": 1000},
            },
            AMBIENT,
        ],
        "channels": [{"column": "current_A", "analog_pin": 15}],
        "drive": {"pwm_pin": 3, "direction_pin": 4, "frequency_Hz": 31373},
        "supply": {"bandgap_mV": 1100},
    },
    "another controller's PWM": {
        "thermocouples": [{"channel": "casing", "chip": "MAX31856", "cs": 4, "so": 7, "sck": 8, "sdi": 9}, AMBIENT],
        "observe": {"forward_pin": 10, "reverse_pin": 11},
    },
}


@pytest.mark.parametrize("wiring", OTHERS)
def test_other_parts_work_there_too(wiring: str, cache: Path) -> None:
    def change(tree: dict[str, Any]) -> None:
        tree["wiring"] = {"board": "uno", "memory": None, **OTHERS[wiring]}
        if "supply" in OTHERS[wiring]:
            tree["protection"] = [{"cause": "supply_low", "delay_s": 1, "action": "log"}]

    loaded = changed(change)
    firmware = build_firmware(loaded, "fixed", "table", "uno.json", cache)
    assert loaded.document.wiring is not None
    plant = Warm(SUM_40) if "supply" in OTHERS[wiring] else Warm()
    board = Board(firmware.elf, cache, loaded.document.wiring, plant)
    run(board, 6.0)
    board.command(-102)
    board.mega.uart.send(b"test\n")
    said = run(board, 30.0)
    assert "test passed" in said
    assert "FAILED" not in said
    pwm = int([line for line in said.splitlines() if re.match(r"\d", line)][-1].split(",")[1])
    assert abs(pwm + 102) <= (2 if "observe" in OTHERS[wiring] else 0)  # what the observer takes for its own scatter
    assert board.pwm == -102


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("schedule", ["table", "onboard"])
def test_the_whole_motor_has_room_without_copies(cache: Path, arithmetic: Arithmetic, schedule: ScheduleKind) -> None:
    loaded = example("my1016_uno")
    firmware = build_firmware(loaded, arithmetic, schedule, "coeffs.json", cache)
    taken = sizes(firmware.elf)
    assert taken.flash <= UNO.flash_bytes
    assert taken.ram <= UNO.ram_bytes - 512


def test_the_example_is_the_megas_with_another_wiring() -> None:
    mega, uno = example("my1016").document, example("my1016_uno").document
    assert uno.components == mega.components
    assert uno.alarms == mega.alarms
    assert (uno.board, mega.board) == ("uno", "mega")


def test_what_has_no_room_is_refused_with_its_sizes(cache: Path) -> None:
    tree = json.loads((ROOT / "examples" / "my1016_uno" / "coeffs.json").read_text())
    del tree["wiring"]["memory"]
    with pytest.raises(CheckFailed, match=r"^the sketch and its stack take \d{5} bytes of flash and \d{4} of RAM, "):
        build_firmware(parse(json.dumps(tree).encode()), "fixed", "table", "coeffs.json", cache)


@pytest.mark.parametrize(
    ("keys", "place", "says"),
    [
        ({"led_pin": 22}, "$.wiring.led_pin", "the Uno has no pin 22; expected 0..19"),
        ({"encoder": {"pin": 18, "pulses_per_revolution": 20}}, "$.wiring.encoder.pin", "expected one of 2, 3"),
        (
            {"encoder": {"pin": 5, "pulses_per_revolution": 20, "method": "counter"}},
            "$.wiring.encoder.method",
            "no timer of the Uno is free",
        ),
        ({"drive": {"forward_pin": 9, "reverse_pin": 4}}, "$.wiring.drive.reverse_pin", "one of 3, 5, 6, 9, 10, 11"),
        (
            {"drive": {"forward_pin": 9, "reverse_pin": 6, "frequency_Hz": 31373}},
            "$.wiring.drive.reverse_pin",
            "Timer 0's",
        ),
        (
            {"channels": [{"column": "current_A", "analog_pin": 13}]},
            "$.wiring.channels[0].analog_pin",
            "pin 13 of the Uno measures no voltage; expected 14..19",
        ),
    ],
)
def test_a_pin_that_cannot_is_refused_at_its_place(keys: dict[str, Any], place: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        wired(**keys)
    assert caught.value.place == place
    assert says in caught.value.message


def test_voltages_are_converted_at_the_unos_inputs() -> None:
    loaded = wired(channels=[{"column": "current_A", "analog_pin": 17}])
    files = project_files(loaded, lower(loaded, "fixed", "table"), "uno.json", None)
    converter = files["src/converter.cpp"]
    assert re.search(r"\{0x43, \d+, \d+\},  // .*pin A3", converter)
    assert "DIDR0 = 8;" in converter
    assert "MUX5" not in converter
    assert "DIDR2" not in converter


def test_the_project_is_the_unos() -> None:
    loaded = changed(lambda _: None)
    files = project_files(loaded, lower(loaded, "fixed", "table"), "uno.json", None)
    assert re.search(r"\[env:uno\]\nplatform = .*\nboard = uno\n", files["platformio.ini"])
    assert not re.search(r"env:mega|atmega2560", files["platformio.ini"])
    assert "Firmware for the Arduino Uno" in files["README.md"]
    assert "Mega" not in files["README.md"]
    assert "Arduino Uno" in files["wiring.svg"]


def test_pins_lie_where_the_arduino_core_has_them() -> None:
    """By the compiler: the core's own tables of the Uno."""
    text = (toolchain.arduino_core("standard") / "variants/standard/pins_arduino.h").read_text()
    table = text[text.index("digital_pin_to_port_PGM[]") :]
    ports = re.findall(r"\bP([BCD])\s*,", table[: table.index("}")])
    masks = re.findall(r"_BV\((\d)\)", text[text.index("digital_pin_to_bit_mask_PGM[]") :].split("};")[0])
    uno = BOARDS["uno"]
    assert [uno.port_bit(pin) for pin in range(20)] == [
        (port, int(bit)) for port, bit in zip(ports, masks, strict=True)
    ]
    last = text[text.index("digital_pin_to_timer_PGM[] = {") :].split("};")[0]
    last = re.sub(r"#if defined\(__AVR_ATmega8__\).*?#else(.*?)#endif", r"\1", last, flags=re.S)
    timers = re.findall(r"^\s*(NOT_ON_TIMER|TIMER\d[AB])\b", last, re.M)
    on_timer = {pin: int(name[5]) for pin, name in enumerate(timers) if name != "NOT_ON_TIMER"}
    assert on_timer == dict(uno.pwm_timers)
    assert set(on_timer) == PINS_OF["uno"].pwm
    assert (uno.label(13), uno.label(14), uno.label(19)) == ("13", "A0", "A5")
