"""What the LED shows, and the button."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.device.board import OPEN, Board
from tests.device.conftest import Open

LED, BUTTON = 13, 22


def lit(board: Board, seconds: float) -> list[tuple[float, float]]:
    """Begin and end of each time alight, in s."""
    probe = board.pins.watch(LED)
    board.run_seconds(seconds)
    edges = probe.edges()
    assert edges.levels[:-1].tolist() != edges.levels[1:].tolist()
    return [(float(a), float(b)) for (a, on), (b, _) in pairwise(zip(edges.seconds, edges.levels, strict=True)) if on]


def groups(times: list[tuple[float, float]]) -> list[int]:
    """Blinks in each whole group; groups stand over a second apart."""
    gaps = [later[0] - earlier[1] for earlier, later in pairwise(times)]
    ends = [0, *(i + 1 for i, gap in enumerate(gaps) if gap > 1.0), len(times)]
    return [b - a for a, b in pairwise(ends)][1:-1]


def test_a_healthy_board_flashes_every_two_seconds(power_up: Open) -> None:
    board = power_up()
    board.started()
    times = lit(board, 12.0)
    assert len(times) in (5, 6)
    assert np.diff([a for a, _ in times]) == pytest.approx(2.05, abs=0.1)
    assert [b - a for a, b in times] == pytest.approx([0.064] * len(times), abs=0.03)


def test_a_sensor_that_is_not_believed_flickers(power_up: Open) -> None:
    board = power_up()
    board.started()
    board.chips["casing"].set_word(OPEN)
    board.hear(1.0)
    times = lit(board, 4.0)
    assert len(times) > 4 * 5
    board.set_celsius("casing", 30.0)
    board.hear(3.0)
    assert len(lit(board, 6.0)) < 5


def test_an_alarm_s_first_number_is_right_already(power_up: Open) -> None:
    """Whoever looks when it comes on must not read another rule's number."""
    board = power_up(test_alarms=True)
    board.started()
    probe = board.pins.watch(LED)
    board.write("test_alarms", 1 << 3)
    board.run_seconds(6.0)
    edges = probe.edges()
    lengths = [b - a for (a, on), (b, _) in pairwise(zip(edges.seconds, edges.levels, strict=True)) if on]
    on = [float(t) for t, level in zip(edges.seconds, edges.levels, strict=True) if level]
    blinks = [t for t, length in zip(on, lengths, strict=False) if length > 0.16]
    first = [t for t in blinks if t - blinks[0] < 4 * 0.6]
    assert len(first) == 4
    assert len(blinks) == 4 or blinks[4] - blinks[3] > 1.0


@pytest.mark.parametrize("rule", [0, 2, 5])
def test_an_alarm_blinks_its_number(power_up: Open, rule: int) -> None:
    board = power_up(test_alarms=True)
    board.started()
    board.write("test_alarms", 1 << rule)
    board.hear(2.0)
    counted = groups(lit(board, 30.0))
    assert len(counted) >= 3
    assert set(counted) == {rule + 1}


def test_several_alarms_take_turns_and_a_faulty_sensor_flickers_between(power_up: Open) -> None:
    board = power_up(test_alarms=True)
    board.started()
    board.write("test_alarms", 0b1001)
    board.hear(2.0)
    counted = groups(lit(board, 40.0))
    assert set(pairwise(counted)) == {(1, 4), (4, 1)}
    board.chips["casing"].set_word(OPEN)
    board.hear(2.0)
    lengths = [b - a for a, b in lit(board, 20.0)]
    assert {round(length, 1) for length in lengths} == {0.1, 0.3}  # flicker 0.064 s, blinks 0.256 s


def test_the_button_resets_alarms_once_it_has_stopped_bouncing(power_up: Open) -> None:
    board = power_up(test_alarms=True)
    board.started()
    board.write("test_alarms", 0b10)
    board.hear(1.0)
    for level in (False, True, False, True) * 3:  # a touch of 12 ms
        board.pins.drive(BUTTON, level)
        board.run_seconds(0.001)
    board.pins.drive(BUTTON, None)
    board.hear(1.0)
    assert board.read("test_alarms") == 0b10
    board.pins.drive(BUTTON, False)
    said = board.hear(0.5)
    assert board.read("test_alarms") == 0
    assert any("alarms reset by the button" in event for event in said.events)
    board.write("test_alarms", 0b10)
    board.hear(1.0)
    assert board.read("test_alarms") == 0b10  # held down, it acts once


def test_touches_shorter_than_a_press_reset_nothing_whenever_they_come(power_up: Open) -> None:
    board = power_up(test_alarms=True)
    board.started()
    board.write("test_alarms", 0b10)
    board.hear(1.0)
    for _ in range(16):  # the button is read every 32 ms: some of these meet a reading
        board.pins.drive(BUTTON, False)
        board.run_seconds(0.012)
        board.pins.drive(BUTTON, None)
        board.run_seconds(0.093)
    assert board.read("test_alarms") == 0b10


def test_a_button_that_is_held_through_a_reset_acknowledges_nothing(power_up: Open) -> None:
    """Stuck, or pressed by mistake while the power comes back: nobody has seen the alarm yet."""
    board = power_up("often_copied", test_alarms=True)
    board.started()
    board.write("test_alarms", 0b10)
    board.hear(5.0)  # kept in EEPROM
    board.pins.drive(BUTTON, False)
    board.press_reset()
    board.started()
    board.hear(1.0)
    assert board.read("test_alarms") == 0b10
