"""How long the line may be silent before the motor stops, to the sample, on the emulated Mega."""

from __future__ import annotations

import pytest

from tests.device.conftest import Open
from tests.device.test_protection import pwm, running, turning

TIMEOUT_S = 20  # $.wiring.command_timeout_s of this variant
SAMPLE_S = 0.25


@pytest.mark.parametrize("fifth", range(0, 5, 2))
def test_the_motor_runs_on_for_all_of_the_time_that_the_line_may_be_silent(power_up: Open, fifth: int) -> None:
    """Wherever within a sample the last command comes: not stopped before, and two samples later at most."""
    board = running(power_up)
    board.hear(0.05 * fifth)
    board.send("?")
    turning(board, TIMEOUT_S - 1)
    board.encoder.send(5000, 2.0)
    board.hear(0.98)
    assert pwm(board) == 200
    events = board.hear(2.0 * SAMPLE_S + 0.06).events
    assert any("protection command_timeout begins" in event for event in events)
    assert pwm(board) == 0
