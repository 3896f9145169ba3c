"""The hazards' motor against closed forms, its judge on made-up moments, a handful of hazards, what noise can do."""

from __future__ import annotations

import math
import random
import struct
from dataclasses import replace

import pytest

from benchmarks.hazards.bits import flip_flash, loaded
from benchmarks.hazards.boards import variant
from benchmarks.hazards.commanding import with_sum
from benchmarks.hazards.noise import accepted_per_line, moved_per_hour, obeyed_per_hour
from benchmarks.hazards.plant import COOLING_S, FREE_RPM, HazardPlant, Moment
from benchmarks.hazards.running import Line, names, run_hazard, summed
from benchmarks.hazards.scene import Outcome, longest
from benchmarks.hazards.table import verdict
from gen.emulate.plants.plant import word_of
from gen.lowering.protection import lower_protection

PARTS = {"brush": 100.0, "casing": 90.0}


def plant() -> HazardPlant:
    found = HazardPlant(dict(PARTS), {"brush": 120.0}, {"brush": 0.5, "casing": 0.0}, 20)
    found.relay_closed = lambda: True
    return found


GOOD = Outcome("nothing", 0.0, 0.0, 0.0, 0.0, 11.0, "stands")


def test_a_part_cools_as_first_order_and_warms_with_the_current_squared() -> None:
    motor = plant()
    for _ in range(400):
        motor.step(0, 0.25)
    assert motor.temperatures["casing"] == pytest.approx(25.0 + 65.0 * math.exp(-100.0 / COOLING_S), abs=0.01)
    before = dict(motor.temperatures)
    motor.step(255, 0.25)
    warmed = motor.temperatures["brush"] - before["brush"]
    motor.temperatures |= before
    motor.step(-51, 0.25)
    cooled = (before["brush"] - 25.0) / COOLING_S * 0.25
    assert motor.temperatures["brush"] - before["brush"] + cooled == pytest.approx((warmed + cooled) / 25.0)


def test_the_encoder_gives_the_rotor_s_turns_and_a_locked_rotor_none() -> None:
    motor = plant()
    for _ in range(8):
        motor.step(255, 0.25)
    assert sum(motor.step(255, 0.25).pulses for _ in range(240)) == pytest.approx(FREE_RPM * 20, abs=2)
    motor.locked = True
    motor.speed_rpm = 0.0
    assert sum(motor.step(255, 0.25).pulses for _ in range(8)) == 0


def test_a_shorted_driver_drives_until_the_relay_is_open() -> None:
    motor = plant()
    motor.shorted = True
    motor.step(0, 0.25)
    motor.relay_closed = lambda: False
    motor.step(255, 0.25)
    assert [moment.driven for moment in motor.moments] == [True, False]


@pytest.mark.parametrize(
    ("word", "blind"),
    [
        (word_of(100.0), False),
        (word_of(104.75), False),
        (word_of(94.0), True),
        (word_of(106.0), True),
        (word_of(100.0) | 4, True),
        (0, True),
        (0xFFFF, True),
        (400 << 18, True),  # 100 degC from a MAX31855, whose first half is 50 degC of a MAX6675
    ],
)
def test_blind_is_a_word_that_is_none_or_is_far_from_the_part(word: int, blind: bool) -> None:
    motor = plant()
    motor.lies["brush"] = lambda _degC, _time: word
    motor.step(0, 0.0)
    motor.step(0, 0.0)
    assert motor.moments[-1].blind == blind


def test_driven_blind_is_added_up_across_stops_and_ends_with_the_blindness() -> None:
    def moments(driven: str, blind: str) -> list[Moment]:
        return [Moment(0.25 * i, d == "x", 0.0, b == "x") for i, (d, b) in enumerate(zip(driven, blind, strict=True))]

    assert longest(moments("xxx..xx", "xxxxxxx")) == 5 * 0.25
    assert longest(moments("xxxxxxx", "xx.xxx.")) == 3 * 0.25
    assert longest(moments("...", "xxx")) == 0.0


def test_a_verdict_is_of_the_worst_run_and_of_both_goals() -> None:
    assert replace(GOOD, beyond_driven_K=5.0, beyond_K=50.0, blind_s=11.0).passes
    assert not replace(GOOD, beyond_driven_K=5.1).passes
    assert not replace(GOOD, blind_s=11.25).passes
    runs = [((1, 2), GOOD), ((3, 4), replace(GOOD, beyond_driven_K=9.0, after_s=None, end="driven"))]
    line = summed("ram-bits", "", runs)
    assert line.failed == ((3, 4),)
    assert (line.outcome.beyond_driven_K, line.outcome.after_s, verdict(line)) == (9.0, None, "FAIL 1 of 2")
    assert verdict(Line("x", "", 2, replace(GOOD, blind_s=99.0))) == "(FAIL)"


def test_there_are_the_hazards_that_were_asked_for() -> None:
    assert len(names()) >= 10 + 30


def test_the_checksum_of_a_line_is_xmodem_s() -> None:
    assert with_sum("123456789") == "123456789*31C3"  # its published check value


def test_what_noise_can_do_is_what_counting_random_lines_gives() -> None:
    drawn = random.Random(5)
    lines = drawn.randbytes(60_000_000).replace(b"\r", b"\n").split(b"\n")
    short = [line for line in lines if 0 < len(line) <= 6]
    digits = [line[1:] if line[:1] == b"-" else line for line in short]
    taken = sum(line == b"?" for line in short) + sum(d.isdigit() and len(d) < 6 and int(d) < 256 for d in digits)
    assert taken / len(lines) == pytest.approx(accepted_per_line(), rel=0.25)
    assert 80 < obeyed_per_hour() < 150
    assert 1000.0 * moved_per_hour() < 1e-3


@pytest.mark.parametrize("name", ["open-running", "locked-start", "locked-running", "reset-running", "checksum"])
def test_a_hazard_keeps_to_the_goal(name: str) -> None:
    found = run_hazard(name)
    assert found.passes
    assert found.end.startswith("stands")
    assert found.after_s is not None


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("swapped-commissioned", "bearing warmed, not brush"),
        ("reversed-commissioned", "brush got colder: leads exchanged"),
    ],
)
def test_a_fault_that_commissioning_found_is_not_driven(name: str, words: str) -> None:
    found = run_hazard(name)
    assert found.did.startswith(f"commissioning: {words}, not_commissioned: stop")
    assert found.after_s == 0.0
    assert found.beyond_driven_K == -math.inf


def test_a_lost_sensor_stops_the_motor_after_what_the_file_says() -> None:
    found = run_hazard("open-all-running")
    assert "sensor_lost: stop" in found.did
    assert found.after_s is not None
    assert 10.0 <= found.after_s <= found.allowed_s


def test_a_wrong_program_is_refused_even_where_what_is_wrong_is_the_table_s_own_entry_of_it() -> None:
    """One bit of flash: the entry of `flash_check` does not look at its cause. The CRC is wrong, and must do alone."""
    board = variant("relay")
    entries = lower_protection(board.coefficients)
    wrong = next(entry for entry in entries if entry.source.cause == "flash_check")
    assert wrong.source.action == "open_relay"
    words = {"alarms": 0, "lost": 1, "device": 2}
    packed = struct.pack("<IiHBB", wrong.mask, wrong.restart_mC, wrong.delay, words[wrong.word], wrong.least)
    elf = board.firmware.elf.read_bytes()
    assert elf.count(packed) == 1
    place = elf.index(packed)
    address = next(flash + place - offset for flash, size, offset in loaded(elf) if offset <= place < offset + size)
    bit = wrong.mask.bit_length() - 1
    outcome = flip_flash((address + bit // 8, bit % 8))
    assert "flash_check" not in outcome.did  # the table knows nothing of it ..
    assert outcome.end == "stands, relay open"  # .. and the motor is never driven
    assert outcome.beyond_driven_K == -math.inf
