"""A motor driver with one PWM input and one for the direction."""

from __future__ import annotations

import pytest

from tests.device.board import Board
from tests.device.conftest import Open

#: Variant, PWM pin, direction pin, the latter's level for PWM > 0.
DRIVERS = [("directed", 9, 7, True), ("directed_low", 4, 13, False)]

State = tuple[float, bool]


def seen(board: Board, pwm: int, direction: int, function: str, cycles: int = 2000) -> list[State]:
    """Duty and direction's level at every cycle from a function's next call on."""
    board.run_to(function, 16_000_000)
    states = []
    for _ in range(cycles):
        board.run_cycles(1)
        states.append((board.pins.duty(pwm), board.pins.level(direction)))
    return states


@pytest.mark.parametrize(("name", "pwm", "direction", "forward"), DRIVERS)
def test_a_signed_command_is_a_duty_and_a_level(
    power_up: Open, name: str, pwm: int, direction: int, forward: bool
) -> None:
    board = power_up(name)
    board.started()
    level = forward
    for command in (100, -255, 0, 1, -64, 0, 255):
        board.drive(command)
        assert board.hear(1.3).rows[-1]["pwm"] == str(command)
        level = forward if command > 0 else not forward if command < 0 else level  # at 0 it stays
        # Timer 0 keeps its pin high for OCR + 1 counts of 256.
        assert board.pins.duty(pwm) == pytest.approx(abs(command) / 255, abs=1.01 / 256)
        assert board.pins.duty(pwm) > 0 or command == 0
        assert board.pins.is_output(direction)
        assert board.pins.level(direction) == level
        assert board.pins.signed_pwm(pwm, direction, forward_level=forward) == pytest.approx(command, abs=1)


@pytest.mark.parametrize(("name", "pwm", "direction", "forward"), DRIVERS)
@pytest.mark.parametrize(("before", "after"), [(200, -90), (-255, 255), (-120, 40), (255, -1)])
def test_the_direction_changes_only_while_the_pwm_is_off(
    power_up: Open, name: str, pwm: int, direction: int, forward: bool, before: int, after: int
) -> None:
    board = power_up(name)
    board.started()
    board.drive(before)
    board.hear(0.6)
    old_duty, old_level = board.pins.duty(pwm), board.pins.level(direction)
    assert old_level == (forward if before > 0 else not forward)
    board.drive(after)
    for _ in range(3):  # the command is taken at one of the next samples
        states = seen(board, pwm, direction, "_ZN5drive6updateEh")
        if states[-1][1] != old_level:
            break
    duties_before = [duty for duty, level in states if level == old_level]
    duties_after = [duty for duty, level in states if level != old_level]
    assert states == [(duty, old_level) for duty in duties_before] + [(duty, not old_level) for duty in duties_after]
    assert set(duties_before) == {old_duty, 0.0}
    us = 16
    assert set(duties_before[-us:]) == set(duties_after[:us]) == {0.0}
    assert duties_after[-1] == pytest.approx(abs(after) / 255, abs=1.01 / 256)
    assert sum(duty == 0 for duty, _ in states) < 20 * us


@pytest.mark.parametrize(("name", "pwm", "direction", "forward"), DRIVERS)
def test_after_a_reset_the_pwm_is_low_and_the_direction_comes_without_an_edge(
    power_up: Open, name: str, pwm: int, direction: int, forward: bool
) -> None:
    board = power_up(name)
    board.started()
    board.drive(-200)
    board.hear(0.6)
    assert board.pins.signed_pwm(pwm, direction, forward_level=forward) == pytest.approx(-200, abs=1)
    board.press_reset()
    assert not board.pins.is_output(pwm)
    board.run_to("_ZN5drive5beginEv", 16_000_000)
    assert not board.pins.is_output(pwm)
    outputs = set()
    for _ in range(2000):
        board.run_cycles(1)
        outputs.add((board.pins.is_output(pwm), board.pins.is_output(direction)))
        assert board.pins.duty(pwm) == 0
        assert not board.pins.level(pwm)
        assert board.pins.level(direction) == forward or not board.pins.is_output(direction)
    assert (True, True) in outputs
    assert (True, False) not in outputs
    probe = board.pins.watch(pwm)
    assert board.started().rows[-1]["pwm"] == "0"
    board.hear(5.0)
    assert not probe.edges().levels.any()
    assert board.pins.is_output(pwm)
    board.drive(255)
    board.hear(0.6)
    assert probe.edges().levels.any()


def test_a_hung_board_lets_go_of_the_motor(power_up: Open) -> None:
    board = power_up("directed")
    board.started()
    board.drive(-200)
    board.hear(1.0)
    board.write("tick_due", board.read("tick_due") + 1_000_000)  # no sample for 1000 s
    board.hear(2.4)
    assert board.resets == 1
    assert board.pins.duty(9) == 0


def test_a_profile_has_both_directions(power_up: Open) -> None:
    board = power_up("directed_low")
    board.started()
    board.send("arm")
    board.send("profile on")
    acted = []
    for _ in range(20):
        board.hear(0.25)
        acted.append(board.pins.signed_pwm(4, 13, forward_level=False))
    assert {101, -51, 0} <= set(acted)  # Timer 0: one count more
    assert [n for i, n in enumerate(acted) if i == 0 or n != acted[i - 1]][-3:] == [101, -51, 0]
