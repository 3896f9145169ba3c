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


def limited(power_up: Open, brush_degC: float, variant: str = "limited", casing_degC: float = 60.0) -> Board:
    board = power_up(variant)
    for channel in board.chips:
        board.set_celsius(channel, 60.0 if channel != "ambient" else 30.0)
    board.set_celsius("brush", brush_degC)
    board.set_celsius("casing", casing_degC)
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


@pytest.mark.parametrize("rate_K_per_s", [1.0, 2.0, 4.0, 8.0, 16.0])
def test_a_limit_that_looks_ahead_is_passed_by_little_however_fast_the_rise(
    power_up: Open, rate_K_per_s: float
) -> None:
    """One that does not is passed by what comes in its persistence, a second and the reading that begins it."""
    board = limited(power_up, 100.0, "foresighted", casing_degC=100.0)
    board.send("rows 1")
    celsius = 100.0
    raised: dict[str, float] = {}
    while len(raised) < 2:
        celsius += rate_K_per_s * READING_S
        for channel in ("brush", "casing"):
            board.set_celsius(channel, celsius)
        for row in board.hear(READING_S).rows:
            for bit, name in ((1, "limit"), (2, "patient")):
                if int(row["alarms"]) & bit:
                    raised.setdefault(name, celsius)
    assert LIMIT_degC - rate_K_per_s <= raised["limit"] <= LIMIT_degC + 4.0
    assert raised["patient"] >= LIMIT_degC + 4.5 * rate_K_per_s * READING_S
    assert raised["limit"] < raised["patient"]


def test_a_rotor_that_locks_just_below_the_limit_is_stopped_within_five_kelvins(power_up: Open) -> None:
    board = limited(power_up, 118.0, "foresighted")
    board.drive(100)
    board.hear(1.0)
    celsius = 118.0
    while round(board.pins.pwm(4, 5)):
        celsius += 5.0 * READING_S
        assert celsius < 125.0
        board.set_celsius("brush", celsius)
        board.hear(READING_S)


def test_a_reading_that_is_off_by_five_kelvins_just_below_the_limit_stops_nothing(power_up: Open) -> None:
    board = limited(power_up, 114.0, "foresighted")
    for celsius in (119.0, 114.0, 119.5, 114.0, 109.0, 114.0):
        board.set_celsius("brush", celsius)
        board.hear(READING_S)
        board.set_celsius("brush", 114.0)
        assert {row["alarms"] for row in board.hear(1.0).rows} <= {"0"}
