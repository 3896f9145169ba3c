"""The emitted sketch's serial line: what it obeys, what it refuses, and what a flood does."""

from __future__ import annotations

import random

import numpy as np
import pytest

from tests.device.board import DROPPED, LATE, warm
from tests.device.conftest import Open

NO_COMMANDS = [
    "256",
    "-256",
    "1 2",
    "12x",
    "--3",
    "1-",
    "+5",
    "0x10",
    "99999999999999999999",
    "rows 0",
    "rows",
    "resets",
    "12\0",
    "1\t2",
    "-",
]


@pytest.mark.parametrize("line", NO_COMMANDS)
def test_a_line_that_is_no_command_changes_nothing(power_up: Open, line: str) -> None:
    board = power_up()
    board.started()
    board.drive(50)
    board.hear(1.0)
    board.send(line)
    said = board.hear(2.0)
    assert any("rejected lines: 1" in event for event in said.events)
    assert {row["pwm"] for row in said.rows} == {"50"}


def test_status_and_rows_on_request(power_up: Open) -> None:
    board = power_up()
    board.started()
    board.send("?")
    said = board.hear(1.0)
    assert any("pwm 0" in event for event in said.events)
    assert any("late 0 dropped 0" in event for event in said.events)
    board.send("rows 1")
    board.hear(1.0)
    assert len(board.hear(5.0).rows) == 20
    board.send("rows 8")
    board.hear(2.5)
    assert len(board.hear(20.0).rows) == 10


def test_a_flood_on_the_serial_line_changes_nothing(power_up: Open) -> None:
    board = warm(power_up())
    board.started()
    board.drive(40)
    board.hear(1.0)
    letters = bytes(random.Random(3).choices(b"abcdefgh0123456789-\n?!\0\xff", k=60_000))
    lines = [line for line in letters.split(b"\n") if not line.lstrip(b"-").isdigit() and line != b"?"]
    # with no gap between the bytes, and far faster than the line: most are lost
    for byte_cycles in (1389, 160):
        board.uart.send(b"\n".join(lines)[:20_000] + b"\n", byte_cycles=byte_cycles)
        said = board.hear(20_000 * byte_cycles / 16e6 + 2.0)
        assert not any(int(row["flags"]) & LATE for row in said.rows)
        assert {row["sensors"] for row in said.rows} == {"00000"}
    assert board.resets == 0
    board.drive(7)
    assert board.hear(1.0).rows[-1]["pwm"] == "7"


@pytest.mark.parametrize("line", ["?", "reset", "rows 4", "nonsense", "1000"])
def test_rows_come_before_answers(power_up: Open, line: str) -> None:
    board = warm(power_up())
    board.started()
    board.hear(1.0)
    board.uart.send((line + "\n").encode() * 3000, byte_cycles=1389)  # at the line's own speed
    said = board.hear(3000 * (len(line) + 1) * 1389 / 16e6)
    times = [float(row["time_s"]) for row in said.rows]
    assert np.diff(times).max(initial=0.0) <= 1.0
    assert not any(int(row["flags"]) & (LATE | DROPPED) for row in said.rows)
    assert board.resets == 0


def test_a_number_that_lost_a_digit_is_not_obeyed(power_up: Open) -> None:
    board = power_up()
    board.started()
    numbers = ("2" * 3 + "\n") * 4000
    board.uart.send(numbers.encode(), byte_cycles=100)  # the buffer overflows: digits are missing here and there
    said = board.hear(2.0)
    assert {row["pwm"] for row in said.rows} <= {"0", "222"}
