"""Lines of which bytes were lost or which were spoilt before: never obeyed, whatever is left of them."""

from __future__ import annotations

import pytest

from tests.device.board import Board
from tests.device.conftest import Open

BUFFER = 63  # bytes that the core keeps
FAST = 100  # cycles: 63 bytes come within one of the sketch's millisecond naps


def rejected(board: Board, seconds: float) -> int:
    said = board.hear(seconds)
    return sum(int(event.split(": ")[1]) for event in said.events if "rejected lines: " in event)


@pytest.mark.parametrize("phase", range(6))
def test_the_rest_of_a_number_whose_digits_were_lost_is_not_obeyed(power_up: Open, phase: int) -> None:
    """The buffer ends with "22"; the third 2 is lost, and the line's end comes when there is room again."""
    board = power_up()
    board.started()
    board.drive(50)
    board.hear(1.0)
    board.run_seconds(phase * 0.00017)
    board.uart.send(b"\n" * (BUFFER - 2) + b"22" + b"2" * 20, byte_cycles=FAST)
    board.run_seconds(0.05)
    board.uart.send(b"\n")
    assert rejected(board, 2.0) == 1
    assert board.hear(1.5).rows[-1]["pwm"] == "50"


@pytest.mark.parametrize("first", ["1\t", "1234567890123456", "\x01"])
def test_a_line_that_was_spoilt_stays_so_until_its_end(power_up: Open, first: str) -> None:
    board = power_up()
    board.started()
    board.drive(50)
    board.hear(1.0)
    board.uart.send(first.encode())
    board.run_seconds(0.3)
    board.drive(12)
    assert rejected(board, 2.0) == 1
    board.drive(13)  # and no longer
    assert board.hear(2.0).rows[-1]["pwm"] == "13"
