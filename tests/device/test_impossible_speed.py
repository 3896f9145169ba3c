"""Pulses that no motor gives: flagged by their speed, and where the interrupt had to switch itself off."""

from __future__ import annotations

import pytest

from tests.device.board import NOISY
from tests.device.conftest import Open

#: The MY1016's 2640 rpm at full scale, with 500 pulses each; the board takes 1.5 times that for possible.
PULSES, NOMINAL_RPM = 500, 2640


@pytest.mark.parametrize(("name", "pin"), [("my1016", 2), ("counted", 47)])
@pytest.mark.parametrize(("times", "noisy"), [(1.0, False), (1.2, False), (2.5, True)])
def test_a_speed_far_above_full_scale_s_is_noise(
    power_up: Open, name: str, pin: int, times: float, noisy: bool
) -> None:
    """Even where every pulse could be counted: 2.5 times full speed leaves the interrupt on."""
    board = power_up(name)
    board.encoder.attach(pin)
    board.started()
    board.send("rows 1")
    board.hear(0.5)
    board.encoder.send(round(4.0 * PULSES * times * NOMINAL_RPM / 60.0), 4.0)
    board.hear(1.0)
    rows = board.hear(2.0).rows
    assert [bool(int(row["flags"]) & NOISY) for row in rows] == [noisy] * len(rows)
    assert [row["speed_rpm"] == "" for row in rows] == [noisy] * len(rows)


def test_a_burst_that_switched_the_interrupt_off_is_noise_however_slow_it_looks(power_up: Open) -> None:
    """200 pulses without a gap in a sample of 0.25 s would be 96 rpm; nobody knows how many were not counted."""
    board = power_up()
    board.encoder.attach(2)
    board.started()
    board.send("rows 1")
    board.hear(1.0)
    board.encoder.send(400, 400 / 400_000)
    rows = board.hear(1.5).rows
    noisy = [row for row in rows if int(row["flags"]) & NOISY]
    assert len(noisy) == 1
    assert noisy[0]["speed_rpm"] == ""
