"""A limit that protects, on the emulated board: it heeds what is plausible, and waits for nothing to be believed."""

from __future__ import annotations

import pytest

from tests.device.board import Board
from tests.device.conftest import Open

LIMIT_degC = 120.0
READING_S = 0.25


def ramp(board: Board, to_degC: float, rate_K_per_s: float) -> float:
    """Let the brush rise from 60 degC; the temperature at which the alarm was raised."""
    celsius = 60.0
    while celsius < to_degC:
        celsius += rate_K_per_s * READING_S
        board.set_celsius("brush", celsius)
        if any(row["alarms"] == "1" for row in board.hear(READING_S).rows):
            return celsius
    raise AssertionError("no alarm")


def limited(power_up: Open, brush_degC: float) -> Board:
    board = power_up("limited")
    for channel in board.chips:
        board.set_celsius(channel, 60.0 if channel != "ambient" else 30.0)
    board.set_celsius("brush", brush_degC)
    board.started()
    return board


@pytest.mark.parametrize("rate_K_per_s", [2.0, 8.0, 20.0])
def test_a_rise_far_beyond_the_physical_rate_trips_the_limit_within_two_readings(
    power_up: Open, rate_K_per_s: float
) -> None:
    """20 K/s is twice what the winding of the simulated motor does when its rotor is locked."""
    at = ramp(limited(power_up, 60.0), 200.0, rate_K_per_s)
    assert LIMIT_degC < at <= LIMIT_degC + 2.0 * rate_K_per_s * READING_S + 0.5


def test_a_part_beyond_its_believed_range_at_the_start_trips_the_limit(power_up: Open) -> None:
    row = limited(power_up, 260.0).hear(1.0).rows[-1]
    assert (row["sensors"][0], row["brush_degC"], row["alarms"]) == ("4", "", "1")


def test_two_readings_of_noise_trip_nothing_and_three_do(power_up: Open) -> None:
    board = limited(power_up, 60.0)
    board.set_celsius("brush", 300.0)
    board.hear(2 * READING_S)
    board.set_celsius("brush", 60.0)
    assert {row["alarms"] for row in board.hear(5.0).rows} == {"0"}
    board.set_celsius("brush", 300.0)
    board.hear(4 * READING_S)
    board.set_celsius("brush", 60.0)
    assert board.hear(2.0).rows[-1]["alarms"] == "1"


def test_a_sensor_that_comes_off_stays_refused(power_up: Open) -> None:
    """From 60 degC to the room within seconds, as a bare thermocouple does."""
    board = limited(power_up, 60.0)
    celsius = 60.0
    for _ in range(40):
        celsius += (32.0 - celsius) * 0.12
        board.set_celsius("brush", celsius)
        board.hear(READING_S)
    board.send("rows 1")
    rows = board.hear(10.0).rows
    assert {row["sensors"][0] for row in rows} == {"5"}
    assert {row["brush_degC"] for row in rows} == {""}
