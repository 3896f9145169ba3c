"""The motor's two PWM pins and the built-in profile: what must never happen to a motor, and what was asked for."""

from __future__ import annotations

from itertools import pairwise

import pytest

from tests.device.board import STOPPED, Board
from tests.device.conftest import Open

FORWARD, REVERSE = 4, 5
TICK_CYCLES = 4_800_000  # 0.3 s: a command acts from the next sample on
WATCHED_CYCLES, SLICE = 12_000, 8


@pytest.mark.parametrize(("before", "after"), [(-255, 100), (255, -100), (-64, 64), (200, -255)])
def test_the_two_pins_are_never_on_together(power_up: Open, before: int, after: int) -> None:
    """Not for a microsecond: a half bridge with both switches closed is a short."""
    board = power_up()
    board.started()
    board.drive(before)
    board.hear(1.0)
    board.drive(after)
    board.run_to("analogWrite", TICK_CYCLES)
    for _ in range(WATCHED_CYCLES // SLICE):
        board.run_cycles(SLICE)
        assert min(board.pins.duty(FORWARD), board.pins.duty(REVERSE)) == 0.0
    assert board.pins.pwm(FORWARD, REVERSE) == pytest.approx(after, abs=1)


def changes(board: Board, seconds: float) -> list[tuple[float, int]]:
    rows = board.hear(seconds).rows
    return [(float(new["time_s"]), int(new["pwm"])) for old, new in pairwise(rows) if new["pwm"] != old["pwm"]]


def test_a_profile_that_repeats_starts_again_with_its_first_step(power_up: Open) -> None:
    board = power_up("autostart")
    first = board.started().rows[-1]
    assert int(first["pwm"]) == 100  # by itself
    found = changes(board, 12.0)
    assert {pwm for _, pwm in found} == {100, -50}
    for (begin, pwm), (end, _) in pairwise(found):
        assert end - begin == (1.0 if pwm == 100 else 2.0)


def test_an_alarm_that_stops_the_motor_ends_its_profile(power_up: Open) -> None:
    board = power_up("autostart", test_alarms=True)
    board.started()
    board.write("test_alarms", 0x0010)
    board.hear(1.0)
    rows = board.hear(5.0).rows
    assert {row["pwm"] for row in rows} == {"0"}
    assert all(int(row["flags"]) & STOPPED for row in rows)
    board.send("reset")
    board.hear(1.0)
    assert {row["pwm"] for row in board.hear(5.0).rows} == {"0"}  # it does not go on by itself
