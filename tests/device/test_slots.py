"""What the LED shows, slot by slot of 32 ms."""

from __future__ import annotations

import numpy as np
import pytest

from tests.device.board import OPEN, Board
from tests.device.conftest import Open

LED, BUTTON = 13, 22
SLOT_S = 0.032
BLINK, DARK, PAUSE = 8, 8, 48
"""Slots of an alarm's blink, after it, and after its number."""


def slots(board: Board, seconds: float) -> list[tuple[bool, int]]:
    """Whether it was lit, and for how many slots, from the first edge to the last."""
    probe = board.pins.watch(LED)
    board.run_seconds(seconds)
    edges = probe.edges()
    length = np.diff(edges.seconds) / SLOT_S
    whole = np.rint(length).astype(int)
    assert length == pytest.approx(whole, abs=0.2)  # a slot that falls into a sample begins some milliseconds late
    return [(bool(on), int(count)) for on, count in zip(edges.levels, whole, strict=False)]


def shown(*numbers: int) -> list[tuple[bool, int]]:
    """These rules' numbers, 1 and up, each with its pause."""
    return [
        part
        for count in numbers
        for part in [(True, BLINK), (False, DARK)] * (count - 1) + [(True, BLINK), (False, DARK + PAUSE)]
    ]


def from_a_pause(seen: list[tuple[bool, int]]) -> list[tuple[bool, int]]:
    """From the first number that is seen from its beginning."""
    first = next(i for i, (on, count) in enumerate(seen) if not on and count > PAUSE)
    return seen[first + 1 :]


@pytest.mark.parametrize("rules", [(3,), (1, 4), (2, 3, 16)])
def test_alarms_blink_their_numbers_in_these_slots(power_up: Open, rules: tuple[int, ...]) -> None:
    """Sixteen rules there may be: after the last comes the first."""
    board = power_up(test_alarms=True)
    board.started()
    board.write("test_alarms", sum(1 << (rule - 1) for rule in rules))
    board.hear(2.0)
    period = SLOT_S * sum(count for _, count in shown(*rules))
    seen = from_a_pause(slots(board, 4.0 + 3.0 * period))
    whole = [shown(*rules[i:], *rules[:i]) for i in range(len(rules))]
    cut = len(whole[0])
    assert seen[:cut] in whole
    assert seen[cut : 2 * cut] == seen[:cut]


def test_a_healthy_flash_has_two_slots_of_sixty_four(power_up: Open) -> None:
    board = power_up()
    board.started()
    board.hear(3.0)
    seen = slots(board, 9.0)
    assert len(seen) >= 7
    assert set(seen) == {(True, 2), (False, 62)}


def test_a_faulty_sensor_flickers_two_slots_on_and_two_off(power_up: Open) -> None:
    board = power_up()
    board.started()
    board.chips["casing"].set_word(OPEN)
    board.hear(1.0)
    assert set(slots(board, 3.0)) == {(True, 2), (False, 2)}


@pytest.mark.parametrize(("held_s", "acts"), [(0.030, False), (0.066, True), (0.12, True)])
def test_a_press_is_two_readings_after_two_without(power_up: Open, held_s: float, acts: bool) -> None:
    """Whatever its phase: one that lasts two slots is always seen, one shorter than a slot never."""
    board = power_up(test_alarms=True)
    board.started()
    board.hear(1.0)
    obeyed = []
    for phase in range(6):
        board.write("test_alarms", 0b10)
        board.run_seconds(0.2 + 0.0055 * phase)
        board.pins.drive(BUTTON, False)
        board.run_seconds(held_s)
        board.pins.drive(BUTTON, None)
        board.run_seconds(0.2)
        obeyed.append(board.read("test_alarms") == 0)
    assert obeyed == [acts] * 6
