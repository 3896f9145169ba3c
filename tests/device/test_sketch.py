"""The emitted sketch on the emulated Mega: what it reads, drives, and survives."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from gen.avr.compile import sizes
from gen.emulate.wiring.devices import ResetCause
from gen.lowering.lower import lower
from gen.reference.model import ReferenceModel
from tests.device.board import (
    AMBIENT,
    DROPPED,
    LATE,
    NOISY,
    ONES,
    OPEN,
    STALL,
    STOPPED,
    TEMPERATURES,
    ZEROS,
    Board,
    Said,
    program_crc,
    warm,
    word,
)
from tests.device.conftest import Open
from tests.device.variants import CHANNELS, VARIANTS, variant

SAMPLE_S = 0.25


@pytest.mark.parametrize("name", VARIANTS)
def test_every_wiring_builds_and_runs(power_up: Open, name: str) -> None:
    board = power_up(name)
    said = board.started()
    assert said.comments["coefficients_sha256"] == variant(name).sha256
    assert said.comments["reset"] == "power"
    assert said.rows[0]["time_s"] == "0.000"
    later = board.hear(10.0)
    assert np.all(np.diff([float(row["time_s"]) for row in later.rows]) > 0)
    assert len(later.rows) >= 4
    assert not any(int(row["flags"]) & (LATE | DROPPED) for row in later.rows)
    assert board.resets == 0


def test_the_model_starts_from_the_measured_temperatures_and_equals_the_reference(power_up: Open) -> None:
    board = warm(power_up())
    first = board.started()
    assert first.events[-1].endswith("start from measured")
    assert {c: float(first.rows[0][f"{c}_degC"]) for c in TEMPERATURES} == TEMPERATURES
    rows = list(first.rows)
    for pwm, seconds in ((255, 7), (-128, 12), (7, 5), (0, 6)):
        board.drive(pwm)
        rows += board.hear(seconds).rows

    program = lower(variant("my1016"), "fixed", "table")
    starts = {c: [round((TEMPERATURES[c] - TEMPERATURES["ambient"]) * 1000)] for c in CHANNELS[:-1]}
    reference = ReferenceModel(program, starts, np.array([[round(TEMPERATURES["ambient"] * 1000)]]))
    acting, sample, compared = 0, 0, 0
    for row in rows:
        while sample < round(float(row["time_s"]) / SAMPLE_S):
            reference.step(np.array([acting]))
            sample += 1
        if sample:
            # The board gives out whole thousandths, to nearest.
            given = [float(row[f"{c}_model_degC"]) for c in CHANNELS[:-1]]
            assert given == pytest.approx(reference.rises[:, 0] + TEMPERATURES["ambient"], abs=0.00051), row
            compared += 1
        acting = int(row["pwm"])
    assert compared > 30
    assert {int(row["pwm"]) for row in rows} == {0, 255, -128, 7}


@pytest.mark.parametrize(
    ("bad", "code"), [(OPEN, 1), (0x7FFC, 1), (ZEROS, 2), (ONES, 3), (0x8000, 3), (word(300), 4), (word(45), 5)]
)
def test_a_bad_sample_is_flagged_at_once_and_used_nowhere(power_up: Open, bad: int, code: int) -> None:
    board = warm(power_up())
    board.started()
    board.hear(3.0)
    board.chips["bearing"].set_word(bad)
    bad_s = board.hear(0.5).rows
    board.set_celsius("bearing", TEMPERATURES["bearing"])
    rows = bad_s + board.hear(4.0).rows
    flagged = [row for row in rows if row["sensors"] != "00000"]
    assert flagged[0]["sensors"] == f"0{code}000"
    assert all(row["bearing_degC"] == "" for row in flagged)
    assert {row["bearing_degC"] for row in rows if row not in flagged} == {"55.50"}
    assert {row["sensors"][1] for row in flagged} <= {str(code), "5", "8"}
    assert rows[-1]["sensors"] == "00000"
    model = [float(row["bearing_model_degC"]) for row in rows]
    assert max(model) - min(model) < 0.05  # the model runs on


def test_a_frozen_sensor_is_flagged_once_the_model_moves(power_up: Open) -> None:
    board = power_up("soon_stuck")  # 20 s, 0.1 K
    board.started()
    assert {row["sensors"] for row in board.hear(30.0).rows} == {"00000"}  # at PWM 0 the model of a cold motor stays
    board.drive(255)
    rows = board.hear(60.0).rows
    first = next(row for row in rows if row["sensors"][3] == "6")
    assert float(first["casing_model_degC"]) == pytest.approx(30.1, abs=0.01)
    assert first["casing_degC"] == ""
    assert rows[-1]["sensors"][1:] == "6660"  # the ambient has no model
    board.set_celsius("casing", 30.5)
    assert board.hear(3.0).rows[-1]["casing_degC"] == "30.50"


def test_without_the_ambient_the_last_one_goes_on(power_up: Open) -> None:
    board = warm(power_up())
    board.started()
    board.chips["ambient"].set_word(OPEN)
    rows = board.hear(5.0).rows
    assert rows[-1]["ambient_degC"] == ""
    assert int(rows[-1]["flags"]) & AMBIENT
    assert float(rows[-1]["casing_model_degC"]) == pytest.approx(TEMPERATURES["casing"], abs=0.1)


def test_a_sketch_without_thermocouples_answering_starts_from_ambient(power_up: Open) -> None:
    board = power_up(connected=False)
    said = board.started()
    assert said.events[-1].endswith("start from ambient")
    assert said.rows[-1]["sensors"] == "33333"  # pulled up: all ones
    assert board.seconds == pytest.approx(6.0, abs=1.0)  # it waited for them


def test_pwm_goes_to_one_pin_or_the_other(power_up: Open) -> None:
    board = power_up()
    board.started()
    for pwm in (100, -255, 1, 0, -64):
        board.drive(pwm)
        board.hear(0.6)
        assert board.pins.pwm(4, 5) == pytest.approx(pwm, abs=1)
        assert np.sign(board.pins.pwm(4, 5)) == np.sign(pwm)
        assert min(board.pins.duty(4), board.pins.duty(5)) == 0


def test_the_watchdog_resets_a_board_that_hangs(power_up: Open) -> None:
    board = power_up()
    board.started()
    board.drive(200)
    board.hear(1.0)
    board.write("tick_due", board.read("tick_due") + 1_000_000)  # no sample for 1000 s
    board.hear(1.7)
    assert board.resets == 0
    said = board.hear(1.2)
    assert board.resets == 1
    assert said.comments["reset"] == "watchdog"
    assert board.pins.pwm(4, 5) == 0
    assert board.started().rows[-1]["pwm"] == "0"
    board.hear(10.0)
    assert board.resets == 1


@pytest.mark.parametrize(("cause", "text"), [(ResetCause.POWER_ON, "power"), (ResetCause.BROWN_OUT, "brown-out")])
def test_the_reset_cause_is_said(power_up: Open, cause: ResetCause, text: str) -> None:
    board = power_up()
    board.started()
    board.cut_power(0.5, cause=cause)
    assert board.started().comments["reset"] == text


def test_late_samples_are_counted_and_read_no_chip_early(power_up: Open) -> None:
    board = warm(power_up())
    board.started()
    board.hear(2.0)
    board.write("tick_due", board.read("tick_due") - 1100)  # as if a second had been slept through
    said = board.hear(4.0)
    late = [row for row in said.rows if int(row["flags"]) & LATE]
    assert {row["sensors"] for row in late[1:]} == {"77777"}  # the first is late, but its conversion is finished
    assert all(row["brush_degC"] == "" for row in late[1:])
    assert said.rows[-1]["sensors"] == "00000"
    assert all(chip.counts.early == 0 for chip in board.chips.values())
    board.send("?")
    assert any(re.search(r"late [45] dropped 0", event) for event in board.hear(1.0).events)


def test_the_clock_may_roll_over(power_up: Open) -> None:
    board = warm(power_up())
    board.start_clock_at(2**32 - 8000)
    rows = board.started().rows + board.hear(20.0).rows
    assert int.from_bytes(board.memory.peek(*board.variable("timer0_millis")), "little") < 20_000
    assert not any(int(row["flags"]) & LATE for row in rows)
    times = [float(row["time_s"]) for row in rows if float(row["time_s"]) % 1 == 0]
    assert times == [float(i) for i in range(len(times))]
    assert board.resets == 0


@pytest.mark.parametrize(("name", "pin"), [("my1016", 2), ("counted", 47)])
def test_speed_comes_from_the_pulses_and_a_stall_is_flagged(power_up: Open, name: str, pin: int) -> None:
    board = power_up(name)
    board.encoder.attach(pin)
    board.started()
    board.drive(200)
    board.encoder.send(5 * 22_000, 5.0)
    rows = board.hear(5.0).rows
    assert float(rows[len(rows) // 2]["speed_rpm"]) == pytest.approx(2640, rel=0.005)
    assert not any(int(row["flags"]) & STALL for row in rows)
    rows = board.hear(4.0).rows
    stalled = [float(row["time_s"]) for row in rows if int(row["flags"]) & STALL]
    assert 1.0 <= stalled[0] - float(rows[0]["time_s"]) <= 2.3  # 2 s after the last pulse, up to 1 s before that row
    board.drive(30)  # too little to turn it: no stall
    assert not int(board.hear(1.0).rows[-1]["flags"]) & STALL
    board.drive(-200)  # backwards it has to turn as well
    assert int(board.hear(3.5).rows[-1]["flags"]) & STALL


def test_a_late_sample_does_not_make_the_motor_faster(power_up: Open) -> None:
    """Pulses are divided by the time in which they came, not by the time in which they should have come."""
    board = power_up()
    board.encoder.attach(2)
    board.started()
    board.send("rows 1")
    board.encoder.send(5 * 11_000, 5.0)
    board.hear(2.1)
    board.write("tick_due", board.read("tick_due") + 125)  # half a sample later
    rows = board.hear(1.5).rows
    assert len(rows) >= 4
    assert [float(row["speed_rpm"]) for row in rows] == pytest.approx([1320.0] * len(rows), rel=0.005)


@pytest.mark.parametrize(("name", "pin"), [("my1016", 2), ("counted", 47)])
def test_a_noisy_encoder_line_is_flagged_and_costs_no_sample(power_up: Open, name: str, pin: int) -> None:
    """360 000 edges a second leave 44 cycles for an interrupt of some 50: the board would do nothing else."""
    board = power_up(name)
    board.encoder.attach(pin)
    board.started()
    board.send("rows 1")
    board.encoder.send(5 * 360_000, 5.0)
    board.hear(1.0)
    rows = board.hear(3.5).rows
    assert all(int(row["flags"]) & NOISY for row in rows)
    assert all(row["speed_rpm"] == "" for row in rows)
    step = 0.25 if name == "my1016" else 0.1
    times = np.array([float(row["time_s"]) for row in rows])
    assert np.diff(times) == pytest.approx(step, abs=1e-6)
    assert board.resets == 0
    board.hear(2.0)
    board.encoder.send(3 * 22_000, 3.0)  # and it is heard again
    row = board.hear(2.5).rows[-1]
    assert float(row["speed_rpm"]) == pytest.approx(2640, rel=0.005)
    assert not int(row["flags"]) & NOISY


def test_no_pulse_is_lost_at_full_speed(power_up: Open) -> None:
    board = power_up()
    board.encoder.attach(2)
    board.started()
    board.send("rows 1")
    board.hear(0.5)
    board.encoder.send(66_000, 3.0)
    rows = board.hear(3.6).rows
    turned = sum(int(row["speed_rpm"]) for row in rows) / 60.0 * 0.25  # whole rpm in each sample
    assert turned * 500 == pytest.approx(66_000, abs=len(rows) * 500 / 60.0 * 0.25)


@pytest.mark.parametrize("pwm", [0, 30, 128, 254, 255, -90])
def test_anothers_pwm_is_measured(power_up: Open, pwm: int) -> None:
    board = power_up("observed")
    board.pins.drive_wave(4, max(pwm, 0) / 255)
    board.pins.drive_wave(5, max(-pwm, 0) / 255)
    board.started()
    rows = board.hear(5.0).rows
    assert all(abs(int(row["pwm"]) - pwm) <= 2 for row in rows)
    board.drive(10)
    assert any("rejected" in event for event in board.hear(1.0).events)
    if 0 < pwm < 240:  # a small change is one, too
        board.pins.drive_wave(4, (pwm + 10) / 255)
        assert abs(int(board.hear(2.0).rows[-1]["pwm"]) - pwm - 10) <= 2


def test_the_profile_runs_and_ends(power_up: Open) -> None:
    board = power_up("profile")
    board.started()
    board.send("arm")
    board.send("profile on")
    rows = board.hear(5.0).rows
    changes = [(float(row["time_s"]), int(row["pwm"])) for old, row in pairwise(rows) if row["pwm"] != old["pwm"]]
    steps = [pwm for _, pwm in changes]
    assert steps[-2:] == [-50, 0]
    assert changes[-1][0] - changes[-2][0] == 2.0
    board.send("arm")
    board.send("profile on")
    assert board.hear(0.7).rows[-1]["pwm"] == "100"
    board.send("profile off")
    assert board.hear(0.7).rows[-1]["pwm"] == "0"


def test_an_alarm_that_says_so_stops_the_motor_until_reset(power_up: Open) -> None:
    board = power_up(test_alarms=True)
    board.started()
    board.drive(200)
    board.hear(1.0)
    board.write("test_alarms", 0x0011)
    said = board.hear(1.0)
    assert said.rows[-1]["pwm"] == "0"
    assert said.rows[-1]["alarms"] == "17"
    assert int(said.rows[-1]["flags"]) & STOPPED
    assert any(event.endswith("alarm test") for event in said.events)
    board.drive(200)
    assert board.hear(1.0).rows[-1]["pwm"] == "0"
    board.send("reset")
    assert board.hear(1.0).rows[-1]["pwm"] == "0"  # it does not start by itself
    board.drive(200)
    assert board.hear(1.0).rows[-1]["pwm"] == "200"
    board.write("test_alarms", 0x0001)
    assert any(event.endswith("alarm test") for event in board.hear(1.0).events)  # raised again, it is told again


def follow(board: Board, seconds: float, excess: float) -> Said:
    """Run on with thermocouples that read what the model says, the casing's so many kelvins more."""
    whole = Said()
    for _ in range(round(seconds / 5.0)):
        said = board.hear(5.0)
        whole.rows += said.rows
        whole.events += said.events
        for channel in CHANNELS[:-1]:
            model = float(said.rows[-1][f"{channel}_model_degC"])
            board.set_celsius(channel, model + (excess if channel == "casing" else 0.0))
    return whole


def test_a_hot_casing_raises_the_studys_alarm(power_up: Open) -> None:
    """The whole way: PWM 50 %, 600 s to settle, 60 s of persistence."""
    board = power_up()
    board.started()
    board.drive(128)
    assert {row["sensors"] for row in follow(board, 300.0, 0.0).rows} == {"00000"}
    for excess in range(1, 9):
        said = follow(board, 5.0, float(excess))
    said = follow(board, 360.0, 8.0)
    assert {row["sensors"] for row in said.rows} == {"00000"}
    (event,) = [event for event in said.events if "alarm" in event]
    assert event.endswith(" alarm fault")
    assert 655 <= float(event.split()[0]) <= 670
    assert said.rows[-1]["alarms"] == "1"
    board.send("reset")
    assert follow(board, 5.0, 8.0).rows[-1]["alarms"] == "0"
    assert follow(board, 70.0, 8.0).rows[-1]["alarms"] == "1"  # the casing is still hot


def test_a_jump_is_not_used_until_somebody_accepts_it(power_up: Open) -> None:
    board = warm(power_up())
    board.started()
    board.hear(2.0)
    board.set_celsius("casing", 20.0 + TEMPERATURES["casing"])
    board.hear(1.0)
    rows = board.hear(60.0).rows
    assert {(row["casing_degC"], row["sensors"]) for row in rows} == {("", "00050")}
    board.send("reset")  # meant for something else
    assert board.hear(3.0).rows[-1]["sensors"] == "00050"
    board.send("accept casing")
    board.hear(2.0)
    row = board.hear(1.0).rows[-1]
    assert (float(row["casing_degC"]), row["sensors"]) == (20.0 + TEMPERATURES["casing"], "00000")


def test_the_self_test_knows_the_flash(power_up: Open, tmp_path: Path) -> None:
    board = warm(power_up())
    said = board.started()
    crc = program_crc(board.elf, tmp_path)
    assert said.comments["firmware"] == f"crc32 {crc} of {sizes(board.elf).flash} bytes"
    board.send("test")
    said = board.hear(5.0)
    findings = [event.split(" ", 1)[1] for event in said.events]
    assert f"test flash ok {crc} not sealed" in findings
    assert "test cpu ok r0..r31, SREG" in findings
    assert any(re.fullmatch(r"test clock ok (\d+) us of 16 ms", finding) for finding in findings)
    assert "test sensors ok 00000" in findings
    assert "test passed" in findings
    assert not any(int(row["flags"]) & LATE for row in said.rows)
    board.chips["magnet"].set_word(OPEN)
    board.write("at_start", 0)
    board.send("test")
    findings = [event.split(" ", 1)[1] for event in board.hear(5.0).events]
    assert f"test flash FAILED {crc} not sealed" in findings
    assert any(finding.startswith("test ram ok ") for finding in findings)
    assert "test sensors FAILED 00100" in findings
    assert "test FAILED" in findings


def test_the_self_test_sees_that_the_stack_came_near_the_variables(power_up: Open) -> None:
    board = power_up()
    board.started()
    board.memory.poke(board.memory.symbol("__heap_start").address - 0x800000 + 40, b"\0")  # the stack was down to here
    board.send("test")
    findings = [event.split(" ", 1)[1] for event in board.hear(5.0).events]
    assert "test ram FAILED 40 bytes untouched" in findings
    assert "test FAILED" in findings


def test_a_board_run_in_slices_shorter_than_its_sleep_does_not_stop(power_up: Open) -> None:
    board = power_up()
    board.started()
    before = board.seconds
    for _ in range(8000):  # an interrupt falls together with a slice's end now and then
        board.run_seconds(0.0005)
    assert board.seconds - before == pytest.approx(4.0, abs=0.1)
    assert len(board.hear(0.1).rows) >= 3
