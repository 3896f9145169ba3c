"""Alarms stay latched across resets and losses of power, until somebody resets them."""

from __future__ import annotations

import random
import zlib
from functools import cache

import pytest

from gen.firmware.sketch.device import device_context
from gen.lowering.lower import lower
from tests.device.board import MEMORY, Board
from tests.device.conftest import Open
from tests.device.variants import variant

RECORD = 18  # identity 4, number 4, alarms 2, protection 4, CRC 4
WRITTEN_S = 1.0
AT_ONCE_S = 0.1
"""From the sample on that raised it."""


@cache
def place() -> tuple[int, int]:
    context = device_context(variant("often_copied"), lower(variant("often_copied"), "fixed", "table"))
    assert context["latch"] is not None
    return context["latch"]["at"], context["latch"]["slots"]


def records(contents: bytes) -> list[tuple[int, int]]:
    """Number and alarms of every sound record, the newest last; each is there twice."""
    at, count = place()
    found = [contents[at + i * RECORD : at + (i + 1) * RECORD] for i in range(count)]
    sound = [record for record in found if zlib.crc32(record[:-4]) == int.from_bytes(record[-4:], "little")]
    return sorted({(int.from_bytes(r[4:8], "little"), int.from_bytes(r[8:10], "little")) for r in sound})


def raised(power_up: Open, alarms: int) -> Board:
    """A board that has raised alarms and has had the time to keep them."""
    board = power_up("often_copied", test_alarms=True)
    board.started()
    board.write("test_alarms", alarms)
    board.hear(WRITTEN_S)
    return board


def shown(board: Board) -> int:
    return int(board.hear(2.5).rows[-1]["alarms"])


@pytest.mark.parametrize("kind", ["reset", "power", "brown-out"])
def test_an_alarm_outlives_every_kind_of_reset(power_up: Open, kind: str) -> None:
    board = raised(power_up, 0x0005)
    if kind == "reset":
        board.press_reset()
    else:
        board.cut_power(1.0, seed=3)
    said = board.started()
    assert any("alarms kept from before the reset" in event for event in said.events)
    assert shown(board) == 5
    board.press_reset()
    board.started()
    assert shown(board) == 5  # and the next one


def test_an_alarm_is_kept_a_tenth_of_a_second_after_it_was_raised(power_up: Open) -> None:
    board = power_up("often_copied", test_alarms=True)
    board.started()
    board.write("test_alarms", 0x0010)
    board.run_until(lambda: board.read("stopped") != 0, 0.5, step_s=0.001)
    board.run_seconds(AT_ONCE_S)
    assert records(board.eeprom.image)[-1][1] == 0x0010
    board.cut_power(1.0, seed=5)
    board.started()
    assert shown(board) == 0x0010


def test_a_motor_that_an_alarm_stopped_stays_stopped(power_up: Open) -> None:
    board = raised(power_up, 0x0010)  # brush_limit, which stops the motor
    board.press_reset()
    board.started()
    board.drive(200)
    said = board.hear(3.0)
    assert {row["pwm"] for row in said.rows[-2:]} == {"0"}
    assert int(said.rows[-1]["flags"]) & 0x2000


def test_alarms_that_were_reset_stay_reset(power_up: Open) -> None:
    board = raised(power_up, 3)
    board.send("reset")
    board.hear(WRITTEN_S)
    assert [alarms for _, alarms in records(board.eeprom.image)] == [3, 0]
    board.press_reset()
    said = board.started()
    assert not any("kept" in event for event in said.events)
    assert shown(board) == 0


@pytest.mark.parametrize("written", range(0, RECORD, 3))
def test_a_power_cut_in_mid_write_leaves_the_record_before(power_up: Open, written: int) -> None:
    board = raised(power_up, 1)
    begun = board.eeprom.counts.writes
    board.write("test_alarms", 3)
    while board.eeprom.counts.writes <= begun + min(written, 8):  # identity, CRC and number differ in 9 bytes or more
        board.run_seconds(0.0005)
    assert board.eeprom.busy
    board.cut_power(1.0, seed=written)
    board.started()
    assert shown(board) in (1, 3)
    board.write("test_alarms", 7)
    board.hear(WRITTEN_S)
    assert records(board.eeprom.image)[-1][1] == 7


def test_any_single_bit_that_turns_is_seen_and_nothing_is_forgotten(power_up: Open) -> None:
    board = raised(power_up, 9)
    at, _ = place()
    contents = board.eeprom.image
    twins = [i for i in range(place()[1]) if contents[at + i * RECORD] != 0xFF]
    assert len(twins) == 2
    choose = random.Random(2)
    for _ in range(4):
        bit = choose.randrange(RECORD * 8)
        damaged = bytearray(contents)
        for twin, kept in zip(choose.sample(twins, 2), (9, 0), strict=True):
            damaged[at + twin * RECORD + bit // 8] ^= 1 << bit % 8
            other = power_up("often_copied", test_alarms=True)
            other.eeprom.image = bytes(damaged)
            other.started()
            assert shown(other) == kept


def test_slots_take_turns_and_only_changes_are_written(power_up: Open) -> None:
    board = raised(power_up, 1)
    for alarms in (3, 7, 15, 31, 63):
        board.write("test_alarms", alarms)
        board.hear(WRITTEN_S)
    assert records(board.eeprom.image) == [(5, 31), (6, 63)]
    before = board.eeprom.counts.writes
    board.hear(20.0)
    assert board.eeprom.counts.writes == before


def test_alarms_come_before_a_copy_that_is_being_written(power_up: Open) -> None:
    board = power_up("often_copied", test_alarms=True)
    board.started()
    board.hear(61.0)  # 60 bytes of a copy from 60 s on, one a sample
    begun = board.eeprom.counts.writes
    board.write("test_alarms", 1)
    board.hear(WRITTEN_S)
    assert records(board.eeprom.image) == [(1, 1)]
    board.hear(20.0)
    assert board.eeprom.counts.writes >= begun + RECORD + 40
    board.cut_power(1.0, seed=2)  # nothing is left in RAM
    assert board.started().events[-1].endswith("start from memory")


def test_a_worn_out_byte_is_flagged_and_the_alarm_goes_to_the_next_slot(power_up: Open) -> None:
    """What was written is read again: an alarm that is not kept must not look as if it were."""
    board = raised(power_up, 1)
    board.write("test_alarms", 3)
    board.run_until(lambda: records(board.eeprom.image)[-1] == (2, 3) and not board.eeprom.busy, WRITTEN_S)
    contents = bytearray(board.eeprom.image)
    place_of_it = next(at for at in range(place()[0], 4096) if contents[at + 4 : at + 10] == b"\2\0\0\0\3\0")
    contents[place_of_it + 8] ^= 0x04
    board.eeprom.image = bytes(contents)
    said = board.hear(1.5)
    assert any(int(row["flags"]) & MEMORY for row in said.rows)
    board.hear(WRITTEN_S)
    assert records(board.eeprom.image)[-1] == (3, 3)
    assert not int(board.hear(2.5).rows[-1]["flags"]) & MEMORY
    board.press_reset()
    board.started()
    assert shown(board) == 3
