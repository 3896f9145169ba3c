"""The PWM that the board measures at another's pins: off by little on average, and not only in each reading."""

from __future__ import annotations

import numpy as np

from tests.device.conftest import Open


def test_measured_duties_have_little_error_in_common(power_up: Open) -> None:
    """Readings may be 2 counts off; what all are off by is an error of the temperatures. Rounded down it is 1.7."""
    board = power_up("observed")
    board.started()
    board.send("rows 1")
    off = []
    for duty in np.arange(20.1, 240.0, 9.7):
        board.pins.drive_wave(4, duty / 255, frequency_hz=400.0)
        board.hear(0.6)
        off += [int(row["pwm"]) - duty for row in board.hear(1.6).rows]
    assert len(off) > 100
    assert abs(np.mean(off)) < 1.4
