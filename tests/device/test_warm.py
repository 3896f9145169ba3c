"""What a reset without a loss of power leaves in RAM: model, counters and refused thermocouples go on from there."""

from __future__ import annotations

import pytest

from gen.emulate.wiring.devices import ResetCause
from tests.device.board import AMBIENT, OPEN, TEMPERATURES, Board, warm
from tests.device.conftest import Open

PARTS = ("brush", "bearing", "magnet", "casing")
MODEL_BYTES = 40
"""Of four parts in fixed point, order 2 and 1: what a copy in EEPROM has of them, too."""


def states(board: Board) -> bytes:
    address, size = board.variable("my1016_model")
    return board.memory.peek(address, min(size, MODEL_BYTES))


def driven(power_up: Open, seconds: float = 12.0, name: str = "watched_brush") -> Board:
    """A board whose model has left the measured temperatures behind, and no copy in EEPROM yet."""
    board = warm(power_up(name))
    board.started()
    board.drive(255)
    board.hear(seconds)
    return board


def reset_until_it_starts(board: Board, cause: ResetCause = ResetCause.EXTERNAL) -> None:
    """Up to the start's own sample, and before the next."""
    board.press_reset(cause=cause)
    started = board.variable("now")[0] + 6  # behind the seconds and milliseconds
    board.run_until(lambda: board.memory.peek(started, 1) == b"\0", 1.0, step_s=0.001)
    board.run_until(lambda: board.memory.peek(started, 1) == b"\1", 7.0, step_s=0.001)
    board.run_seconds(0.02)


def how_it_started(board: Board) -> str:
    (event,) = [event for event in board.started().events if "start from" in event]
    return event.rpartition("start from ")[2]


@pytest.mark.parametrize("cause", [ResetCause.EXTERNAL, ResetCause.WATCHDOG, ResetCause(0)])
def test_the_model_goes_on_bit_for_bit_from_the_last_sample(power_up: Open, cause: ResetCause) -> None:
    """Whatever MCUSR says: a boot loader clears it."""
    board = driven(power_up)
    before = states(board)
    reset_until_it_starts(board, cause)
    assert states(board) == before
    (event,) = [event for event in board.hear(0.3).events if "start from" in event]
    assert event.endswith("start from RAM")


def test_a_watchdog_reset_in_mid_run_goes_on(power_up: Open) -> None:
    board = driven(power_up)
    board.write("tick_due", board.read("tick_due") + 3000)  # no sample for 3 s
    resets = board.resets
    before = states(board)
    board.run_until(lambda: board.resets > resets, 5.0, step_s=0.01)
    said = board.started()
    assert said.comments["reset"] == "watchdog"
    assert any(event.endswith("start from RAM") for event in said.events)
    assert states(board) != before  # it has made samples since


@pytest.mark.parametrize("off_K", [2.5, -2.5])
def test_it_does_not_go_on_where_the_motor_has_warmed_or_cooled(power_up: Open, off_K: float) -> None:
    board = driven(power_up)
    for channel in PARTS:
        board.set_celsius(channel, TEMPERATURES[channel] + off_K)
    board.press_reset()
    assert how_it_started(board) == "measured"


def test_a_loss_of_power_leaves_nothing(power_up: Open) -> None:
    board = driven(power_up)
    board.cut_power(0.1, seed=4)
    assert how_it_started(board) == "measured"


@pytest.mark.parametrize("cause", [ResetCause.POWER_ON, ResetCause.BROWN_OUT])
def test_ram_that_outlived_a_loss_of_power_is_not_trusted(power_up: Open, cause: ResetCause) -> None:
    """SRAM may keep most of its bits for a while."""
    board = driven(power_up)
    board.press_reset(cause=cause)
    assert how_it_started(board) == "measured"


def test_one_record_damaged_leaves_the_other_and_both_leave_none(power_up: Open) -> None:
    board = driven(power_up)
    address, size = board.variable("records")
    record = size // 2

    def damage(which: int, place: int) -> None:
        at = address + which * record + place
        board.memory.poke(at, bytes([board.memory.peek(at, 1)[0] ^ 0x10]))

    for place in (0, 5, 8, 30, record // 2, record - 1):
        for which in (0, 1):
            board.press_reset()
            damage(which, place)
            assert how_it_started(board) == "RAM", (which, place)
            board.hear(2.0)
    board.press_reset()
    damage(0, 30)
    damage(1, 31)
    assert how_it_started(board) == "measured"


def test_what_rules_have_counted_goes_on(power_up: Open) -> None:
    """How long PWM has been within their range, how long slopes are still unknown."""
    board = warm(power_up("watched_brush"))
    board.started()
    board.hear(20.0)
    before = board.memory.peek(*board.variable("my1016_alarm_state"))
    assert any(before[:4]), "it waits for the slopes, and has counted on for a while"
    reset_until_it_starts(board)
    assert board.memory.peek(*board.variable("my1016_alarm_state")) == before


def test_a_thermocouple_that_fell_off_is_refused_after_a_reset_too(power_up: Open) -> None:
    board = driven(power_up)
    board.set_celsius("brush", 24.5)
    board.hear(6.0)
    assert board.hear(1.0).rows[-1]["brush_degC"] == ""
    board.press_reset()
    said = board.started()
    assert any(event.endswith("start from RAM") for event in said.events)
    assert said.rows[0]["brush_degC"] == ""
    assert board.hear(20.0).rows[-1]["brush_degC"] == ""
    board.send("accept brush")
    assert board.hear(5.0).rows[-1]["brush_degC"] == "24.50"


def test_an_ambient_that_was_refused_is_not_believed_once_in_between(power_up: Open) -> None:
    board = driven(power_up)
    board.set_celsius("ambient", 45.0)  # somebody has put a lamp beside it
    board.hear(6.0)
    assert int(board.hear(1.0).rows[-1]["flags"]) & AMBIENT
    place = (
        board.variable("now")[0] + 7 + 4 * len(PARTS)
    )  # behind the time, `started` and what was measured of the parts

    def ambient_mC() -> int:
        return int.from_bytes(board.memory.peek(place, 4), "little")

    assert ambient_mC() == 24_500
    reset_until_it_starts(board)
    assert ambient_mC() == 24_500
    said = board.hear(5.0)
    assert any(event.endswith("start from RAM") for event in said.events)
    assert all(int(row["flags"]) & AMBIENT for row in said.rows[-4:])
    assert ambient_mC() == 24_500


def test_what_protects_goes_on_counting(power_up: Open) -> None:
    """A board that is reset every few seconds does not give a blind motor its ten seconds each time.

    From the first reset on it is not driven at all: nothing was seen of the brush since. The ten seconds, of which no
    stretch between two resets has as many, are counted all the same.
    """
    board = power_up("protected")
    board.encoder.attach(2)
    board.started()
    board.chips["brush"].set_word(OPEN)
    driven_s: list[float] = []
    lost: list[bool] = []
    for _ in range(5):
        board.drive(200)
        driven_s.append(0.0)
        events: list[str] = []
        for _ in range(16):
            board.encoder.send(1250, 0.25)
            events += board.hear(0.25).events
            driven_s[-1] += 0.25 * (board.pins.pwm(4, 5) > 0)
        board.press_reset()
        lost.append(any("protection sensor_lost begins" in event for event in events))
        board.started()
    assert 3.5 <= driven_s[0] <= 4.0
    assert driven_s[1:] == [0.0] * 4
    assert not lost[0] and any(lost[1:3])
