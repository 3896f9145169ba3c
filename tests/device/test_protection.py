"""The emitted sketch on the emulated Mega: what moves the motor, what stops it, and what lets it run again."""

from __future__ import annotations

import binascii
from itertools import pairwise

import pytest

from tests.device.board import OPEN, STOPPED, Board
from tests.device.conftest import Open

FORWARD, REVERSE, RELAY = 4, 5, 12


def pwm(board: Board) -> int:
    return round(board.pins.pwm(FORWARD, REVERSE))


def turning(board: Board, seconds: float) -> list[str]:
    """Let it run with an encoder that turns, so that it is no stall; what was said."""
    events = []
    for _ in range(round(seconds)):
        board.encoder.send(5000, 1.0)
        events += board.hear(1.0).events
    return events


def started(power_up: Open) -> Board:
    board = power_up("protected")
    board.encoder.attach(2)
    board.started()
    return board


def running(power_up: Open) -> Board:
    board = started(power_up)
    board.drive(200)
    turning(board, 4)
    assert pwm(board) == 200
    assert board.pins.level(RELAY)
    return board


def checked(line: str) -> str:
    return f"{line}*{binascii.crc_hqx(line.encode(), 0):04X}"


def test_nothing_moves_before_it_is_armed(power_up: Open) -> None:
    board = started(power_up)
    board.send("200")
    assert any(event.endswith("not armed") for event in turning(board, 2))
    assert pwm(board) == 0
    board.drive(200)
    turning(board, 4)
    assert pwm(board) == 200


def test_a_line_that_is_no_command_disarms_and_stops_nothing(power_up: Open) -> None:
    board = running(power_up)
    board.send("2o0")
    board.send("255")
    events = turning(board, 2)
    assert any("rejected lines: 1" in event for event in events)
    assert any(event.endswith("not armed") for event in events)
    assert pwm(board) == 200
    board.send("0")  # what stops needs nothing
    turning(board, 1)
    assert pwm(board) == 0


def test_after_one_checksum_every_line_needs_one(power_up: Open) -> None:
    board = started(power_up)
    for line in (checked("arm"), checked("100")):
        board.send(line)
    turning(board, 3)
    assert pwm(board) == pytest.approx(100, abs=1)
    board.send("0")
    board.send(checked("arm")[:-1] + "0" if not checked("arm").endswith("0") else checked("arm")[:-1] + "1")
    rejected = [int(event.split("rejected lines: ")[1]) for event in turning(board, 2) if "rejected lines" in event]
    assert sum(rejected) == 2
    assert pwm(board) == pytest.approx(100, abs=1)
    board.send(checked("0"))
    turning(board, 1)
    assert pwm(board) == 0


def test_a_silent_line_stops_the_motor_and_any_command_keeps_it(power_up: Open) -> None:
    board = running(power_up)
    for _ in range(3):
        turning(board, 15)
        board.send("?")
    assert pwm(board) == 200
    events = turning(board, 23)
    assert any("protection command_timeout begins" in event for event in events)
    assert pwm(board) == 0
    board.send("200")  # and it has to be armed again
    turning(board, 2)
    assert pwm(board) == 0


def test_a_locked_rotor_stops_the_motor_until_somebody_resets_it(power_up: Open) -> None:
    board = running(power_up)
    said = board.hear(4.0)  # no pulse
    assert any("protection stall begins" in event for event in said.events)
    assert pwm(board) == 0
    assert int(said.rows[-1]["flags"]) & STOPPED
    board.drive(200)
    assert any("not armed: the motor is stopped" in event for event in board.hear(1.0).events)
    assert pwm(board) == 0
    board.send("reset")
    assert any("protection stall ends" in event for event in board.hear(1.0).events)
    board.drive(200)
    turning(board, 4)
    assert pwm(board) == 200


def test_a_rotor_that_locks_again_has_to_stand_longer_each_time(power_up: Open) -> None:
    """Whoever resets and arms it again at once gives it two seconds of current each time."""
    board = started(power_up)
    stood = []
    for _ in range(4):
        board.drive(200)
        events = board.hear(3.0).events  # no pulse
        assert any("protection stall begins" in event for event in events)
        assert pwm(board) == 0
        waited, left_s = 0, []
        while not any("protection stall ends" in event for event in events):
            board.send("reset")
            events = board.hear(1.0).events
            waited += 1
            told = [event for event in events if "to be reset in" in event]
            left_s += [int(event.partition("to be reset in ")[2].split()[0]) for event in told]
            assert len(told) <= 1
            assert waited < 70
        assert len(left_s) >= waited - 1, "each time it is said how long it still takes"
        assert all(abs(told_s - (len(left_s) - k)) <= 1 and told_s > 0 for k, told_s in enumerate(left_s))
        stood.append(waited)
    assert stood[0] == 1
    for waited, pause_s in zip(stood[1:], (15, 30, 60), strict=True):
        assert pause_s - 2 <= waited <= pause_s + 1


def test_a_motor_with_a_sensor_that_was_never_believed_is_not_driven_at_all(power_up: Open) -> None:
    board = power_up("protected")
    board.encoder.attach(2)
    board.set_celsius("brush", 260.0)  # beyond its range: plausible, and never believed
    board.drive(200)
    events = board.started().events
    assert any("protection sensor_unseen begins" in event for event in events)
    for _ in range(3):
        board.drive(200)
        assert any("not armed: " in event for event in turning(board, 1))
        assert pwm(board) == 0


def test_once_each_sensor_was_believed_the_motor_is_driven(power_up: Open) -> None:
    board = power_up("protected")
    board.encoder.attach(2)
    board.chips["magnet"].set_word(OPEN)
    board.started()
    board.drive(200)
    turning(board, 2)
    assert pwm(board) == 0
    board.set_celsius("magnet", 30.0)
    assert any("protection sensor_unseen ends" in event for event in turning(board, 2))
    board.drive(200)
    turning(board, 4)
    assert pwm(board) == 200


def test_a_motor_is_not_driven_blind(power_up: Open) -> None:
    board = running(power_up)
    board.chips["bearing"].set_word(OPEN)
    turning(board, 8)
    assert pwm(board) == 200
    assert any("protection sensor_lost begins" in event for event in turning(board, 4))
    assert pwm(board) == 0
    board.set_celsius("bearing", 30.0)
    assert any("protection sensor_lost ends" in event for event in turning(board, 3))
    assert pwm(board) == 0, "it does not start by itself"


def test_a_hot_motor_runs_again_only_once_it_is_cool_whatever_is_sent_or_reset(power_up: Open) -> None:
    board = started(power_up)
    for celsius in range(30, 126, 1):  # at 4 K/s, which is believed
        board.set_celsius("brush", float(celsius))
        board.run_seconds(0.25)
    board.drive(200)
    events = turning(board, 8)
    assert any("protection brush_limit begins" in event for event in events)
    assert not board.pins.level(RELAY)
    for _ in range(3):
        board.send("reset")
        board.drive(200)
        turning(board, 2)
        assert pwm(board) == 0
        assert not board.pins.level(RELAY)
    turning(board, 6)  # 18 bytes of EEPROM
    board.press_reset()
    board.started()
    board.send("reset")
    board.drive(200)
    turning(board, 2)
    assert pwm(board) == 0
    for celsius in range(125, 104, -1):
        board.set_celsius("brush", float(celsius))
        board.run_seconds(0.25)
    board.hear(2.0)
    assert not board.pins.level(RELAY), "it does not close unasked"
    board.send("reset")
    board.hear(1.0)
    assert board.pins.level(RELAY)
    board.drive(200)
    turning(board, 4)
    assert pwm(board) == 200


def test_resets_in_time_do_not_keep_a_limit_away_and_nothing_hot_is_armed(power_up: Open) -> None:
    board = started(power_up)
    board.drive(200)
    turning(board, 2)
    for celsius in range(30, 123, 1):
        board.set_celsius("brush", float(celsius))
        board.encoder.send(1250, 0.25)
        board.run_seconds(0.25)
    for _ in range(4):
        board.send("reset")
        board.encoder.send(2500, 0.5)
        board.hear(0.5)  # less than its persistence
    assert pwm(board) == 0
    board.send("reset")
    board.send("arm")
    events = board.hear(1.0).events
    assert any("not armed" in event for event in events)


def test_pwm_rises_by_its_ramp_falls_at_once_and_waits_before_it_turns_round(power_up: Open) -> None:
    board = started(power_up)
    board.drive(255)
    seen = []
    for _ in range(12):
        board.encoder.send(1000, 0.25)
        board.hear(0.25)
        seen.append(pwm(board))
    assert seen == sorted(seen)
    assert max(b - a for a, b in pairwise(seen)) <= 33  # 255 in 2 s: 31.9 in a sample
    assert seen[-1] == 255
    board.drive(-255)
    seen = []
    for _ in range(16):
        board.encoder.send(1000, 0.25)
        board.hear(0.25)
        seen.append(pwm(board))
    still = [i for i, value in enumerate(seen) if value == 0]
    assert len(still) >= 3  # a second
    assert seen[-1] == -255
    board.send("0")
    board.hear(0.5)
    assert pwm(board) == 0


def test_the_relay_is_open_until_the_model_has_started(power_up: Open) -> None:
    board = power_up("protected")
    place, _ = board.variable("now")
    started = place + 6  # behind the seconds and milliseconds
    board.run_until(lambda: board.pins.level(RELAY), 6.0, step_s=0.001)
    assert board.memory.peek(started, 1) == b"\1"
    board.press_reset()
    assert not board.pins.level(RELAY)
    board.run_until(lambda: board.memory.peek(started, 1) == b"\0", 1.0, step_s=0.001)
    assert not board.pins.level(RELAY)


def test_a_button_resets_as_the_command_does_and_believes_no_sensor(power_up: Open) -> None:
    board = running(power_up)
    board.set_celsius("casing", 60.0)  # it jumped
    turning(board, 12)
    assert pwm(board) == 0
    for level in (False, None):
        board.pins.drive(22, level)
        board.hear(0.5)
    said = board.hear(3.0)
    assert said.rows[-1]["sensors"][3] != "0"
    board.send("accept casing")
    assert board.hear(3.0).rows[-1]["sensors"][3] == "0"


@pytest.mark.parametrize("line", ["accept", "accept ", "accept nobody", "accept brus", "accept brushes"])
def test_only_a_channel_can_be_accepted(power_up: Open, line: str) -> None:
    board = started(power_up)
    board.send(line)
    assert any("rejected lines: 1" in event for event in board.hear(1.0).events)


def test_both_directions_have_the_frequency_that_is_asked_for(power_up: Open) -> None:
    """31.4 kHz: both pins are of one timer, which counts the undivided clock."""
    board = power_up("fast_pwm")
    board.started()
    for command in (128, -128):
        board.drive(command)
        board.hear(2.0)
        assert board.pins.pwm(6, 7) == pytest.approx(command, abs=1)
        assert board.memory.peek(0xA1, 1)[0] & 7 == 1  # TCCR4B
