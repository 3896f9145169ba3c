"""The copy of the states in EEPROM: used when it is true, never when it is not, whatever happens to it."""

from __future__ import annotations

import random
import zlib

import numpy as np
import pytest

from gen.firmware.sketch.device import device_context
from gen.lowering.lower import lower
from tests.device.board import MEMORY, OPEN, Board
from tests.device.conftest import Open
from tests.device.variants import variant

RECORD = 64  # identity 4, number 4, PWM 2, five temperatures 10, states 40, CRC 4
MEASURED = {"brush": 61.25, "bearing": 55.5, "magnet": 52.0, "casing": 50.75, "ambient": 24.5}
COPIED_S = 60 + RECORD * 0.25 + 5.0


def warm(board: Board, higher: float = 0.0) -> Board:
    for channel, celsius in MEASURED.items():
        board.set_celsius(channel, celsius + (higher if channel != "ambient" else 0.0))
    return board


@pytest.fixture(scope="module")
def kept() -> dict[str, bytes]:
    return {}


def image(power_up: Open, kept: dict[str, bytes], copies: int) -> bytes:
    """The EEPROM after some copies, made at PWM 180."""
    key = str(copies)
    if key not in kept:
        board = warm(power_up("often_copied"))
        board.started()
        board.drive(180)
        board.hear(COPIED_S + 60 * (copies - 1))
        assert board.eeprom.counts.refused == 0
        kept[key] = board.eeprom.image
    return kept[key]


def start(power_up: Open, contents: bytes, higher: float = 0.0, name: str = "often_copied") -> tuple[str, Board]:
    board = warm(power_up(name), higher)
    board.eeprom.image = contents
    event = board.started().events[-1]
    return event.removeprefix("0.000 start from "), board


def slots(contents: bytes) -> list[bytes]:
    return [contents[at : at + RECORD] for at in range(0, len(contents) - RECORD, RECORD)]


def test_a_copy_is_sound_and_the_slots_take_turns(power_up: Open, kept: dict[str, bytes]) -> None:
    contents = image(power_up, kept, 3)
    used = [slot for slot in slots(contents) if slot != b"\xff" * RECORD and slot[4:8] != b"\xff" * 4]
    assert sorted(int.from_bytes(slot[4:8], "little") for slot in used) == [1, 2, 3]
    for slot in used:
        assert zlib.crc32(slot[:-4]) == int.from_bytes(slot[-4:], "little")
        assert int.from_bytes(slot[8:10], "little") == 180
        assert np.frombuffer(slot[10:20], "<u2").tolist() == [round(4 * t) for t in MEASURED.values()]
    context = device_context(variant("often_copied"), lower(variant("often_copied"), "fixed", "table"))
    assert context["memory"] is not None
    assert context["memory"]["record_bytes"] == RECORD
    assert context["memory"]["slots"] * RECORD <= 4096 - 8


def test_after_a_reset_the_model_goes_on_where_the_copy_was_made(power_up: Open) -> None:
    board = warm(power_up("often_copied"))
    board.started()
    board.drive(255)
    rows = board.hear(COPIED_S + 60.0).rows
    board.cut_power(1.0, seed=2)  # nothing is left in RAM
    said = board.started()
    assert said.comments["reset"] == "power"
    assert said.events[-1].endswith("start from memory")
    older, copied = (next(row for row in rows if float(row["time_s"]) >= time) for time in (60.0, 120.0))
    for channel in ("brush", "bearing", "magnet", "casing"):
        column = f"{channel}_model_degC"
        assert float(said.rows[0][column]) == pytest.approx(float(copied[column]), abs=0.005)
    assert float(copied["bearing_model_degC"]) - float(older["bearing_model_degC"]) > 0.02  # nor is it the older copy
    assert float(copied["bearing_model_degC"]) - MEASURED["bearing"] > 0.1  # another than a start from measured gives


def test_a_copy_is_not_used_when_the_motor_has_cooled_or_warmed_since(power_up: Open, kept: dict[str, bytes]) -> None:
    contents = image(power_up, kept, 1)
    assert start(power_up, contents, 1.75)[0] == "memory"
    assert start(power_up, contents, -1.75)[0] == "memory"
    assert start(power_up, contents, 2.5)[0] == "measured"
    assert start(power_up, contents, -2.5)[0] == "measured"


def test_a_copy_of_other_coefficients_is_not_used(power_up: Open, kept: dict[str, bytes]) -> None:
    assert start(power_up, image(power_up, kept, 1), name="my1016")[0] == "measured"


def test_a_damaged_copy_is_not_used_and_the_one_before_is(power_up: Open, kept: dict[str, bytes]) -> None:
    contents = image(power_up, kept, 2)
    newest = next(i for i, slot in enumerate(slots(contents)) if slot[4:8] == (2).to_bytes(4, "little"))
    oldest = next(i for i, slot in enumerate(slots(contents)) if slot[4:8] == (1).to_bytes(4, "little"))
    choose = random.Random(5)
    for _ in range(6):
        bit = choose.randrange(RECORD * 8)
        damaged = bytearray(contents)
        damaged[newest * RECORD + bit // 8] ^= 1 << bit % 8
        assert start(power_up, bytes(damaged))[0] == "memory", bit
        damaged[oldest * RECORD + bit // 8] ^= 1 << bit % 8
        assert start(power_up, bytes(damaged))[0] == "measured", bit


@pytest.mark.parametrize("seed", range(3))
def test_an_eeprom_full_of_noise_does_no_harm(power_up: Open, seed: int) -> None:
    event, board = start(power_up, random.Random(seed).randbytes(4096))
    assert event == "measured"
    rows = board.hear(5.0).rows
    assert len(rows) >= 4
    assert board.resets == 0


@pytest.mark.parametrize("written", [0, 1, 3, 12, 25, 40, 55])
def test_a_power_cut_in_mid_write_leaves_the_copy_before(power_up: Open, kept: dict[str, bytes], written: int) -> None:
    contents = image(power_up, kept, 1)
    kind, board = start(power_up, contents)
    assert kind == "memory"
    begun = board.eeprom.counts.writes
    board.hear(58.0)
    while board.eeprom.counts.writes <= begun + written:
        board.run_seconds(0.0005)
    assert board.eeprom.busy
    board.cut_power(1.0, seed=written)
    assert written == 0 or board.eeprom.image != contents
    said = board.started()
    assert said.comments["reset"] == "power"
    assert said.events[-1].endswith("start from memory")
    board.hear(COPIED_S)  # and the next copy is sound again
    numbers = [
        int.from_bytes(slot[4:8], "little")
        for slot in slots(board.eeprom.image)
        if zlib.crc32(slot[:-4]) == int.from_bytes(slot[-4:], "little")
    ]
    assert sorted(numbers) == [1, 2]


def test_the_firmwares_crc_is_written_once(power_up: Open) -> None:
    board = warm(power_up("often_copied"))
    said = board.started()
    assert any("firmware is new" in event for event in said.events)
    board.hear(5.0)
    crc = int(said.comments["firmware"].split()[1], 16)
    assert board.eeprom.image[-8:-4] == crc.to_bytes(4, "little")
    assert board.eeprom.counts.writes == sum(
        byte != 0xFF for byte in board.eeprom.image[-8:]
    )  # an empty cell's is there
    board.press_reset()
    assert not any("firmware is new" in event for event in board.started().events)
    board.eeprom.image = board.eeprom.image[:-1] + bytes(
        [board.eeprom.image[-1] ^ 0x10]
    )  # half written, or worn out: it says nothing
    board.press_reset()
    assert any("firmware is new" in event for event in board.started().events)


def test_a_copy_that_cannot_be_read_again_is_flagged_until_the_next_is_right(power_up: Open) -> None:
    board = warm(power_up("often_copied"))
    board.started()
    board.hear(60.0)

    def sound() -> list[int]:
        found = [
            slot for slot in slots(board.eeprom.image) if zlib.crc32(slot[:-4]) == int.from_bytes(slot[-4:], "little")
        ]
        return sorted(int.from_bytes(slot[4:8], "little") for slot in found)

    board.run_until(lambda: sound() == [1] and not board.eeprom.busy, COPIED_S - 60.0)
    contents = bytearray(board.eeprom.image)
    newest = next(i for i, slot in enumerate(slots(board.eeprom.image)) if slot[4:8] == b"\1\0\0\0")
    contents[newest * RECORD + 20] ^= 1
    board.eeprom.image = bytes(contents)
    assert int(board.hear(2.5).rows[-1]["flags"]) & MEMORY
    board.send("test")
    findings = [event.split(" ", 1)[1] for event in board.hear(5.0).events]
    assert "test eeprom FAILED 0 copies" in findings
    assert "test FAILED" in findings
    board.hear(60.0 + RECORD * 0.25)
    assert len(sound()) == 1
    assert not int(board.hear(2.5).rows[-1]["flags"]) & MEMORY
    board.send("test")
    assert any("test eeprom ok 1 copies" in event for event in board.hear(5.0).events)


def test_a_copy_is_not_used_when_no_sensor_can_confirm_it(power_up: Open, kept: dict[str, bytes]) -> None:
    """The motor may have cooled for hours: a copy that nothing speaks for is no start."""
    board = warm(power_up("often_copied"))
    for chip in board.chips.values():
        chip.set_word(OPEN)
    board.eeprom.image = image(power_up, kept, 1)
    assert board.started().events[-1].endswith("start from ambient")
