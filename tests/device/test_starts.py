"""What a start knows of the motor: only where it knows the slopes may rules that need them judge at once."""

from __future__ import annotations

import pytest

from tests.device.board import OPEN, Board, warm
from tests.device.conftest import Open

HOTTER_K = 8.0


def hot_brush(board: Board) -> bool:
    """Let the brush's sensor rise over the model as fast as the checks allow; whether the rule has raised its alarm."""
    brush = float(board.hear(1.0).rows[-1]["brush_degC"])
    for step in range(1, 9):
        board.set_celsius("brush", brush + HOTTER_K * step / 8.0)
        board.run_seconds(1.0)
    row = board.hear(4.0).rows[-1]
    assert float(row["brush_degC"]) == brush + HOTTER_K
    return row["alarms"] == "1"


def test_after_a_cold_start_a_rule_judges_at_once(power_up: Open) -> None:
    board = power_up("watched_brush")
    assert board.started().events[-1].endswith("start from measured")
    assert hot_brush(board)


@pytest.mark.parametrize("off_K", [30.0, -10.0])
def test_after_a_start_at_another_temperature_a_rule_waits_for_the_slopes(power_up: Open, off_K: float) -> None:
    """A part that is not at ambient is on its way somewhere, colder ones too: how fast nobody has seen."""
    board = power_up("watched_brush")
    for channel in ("brush", "bearing", "magnet", "casing"):
        board.set_celsius(channel, 30.0 + off_K)
    assert board.started().events[-1].endswith("start from measured")
    assert not hot_brush(board)


@pytest.mark.parametrize(("name", "unread"), [("my1016", "brush"), ("ambient_only", "casing")])
def test_a_part_that_is_not_measured_starts_at_the_ambient_that_is(power_up: Open, name: str, unread: str) -> None:
    """Its chip tells of no thermocouple, or there is none: it is where the room is, not at the file's 30 degC."""
    board = power_up(name)
    for channel in board.chips:
        board.set_celsius(channel, 12.0)
    if unread in board.chips:
        board.chips[unread].set_word(OPEN)
    board.started()
    row = board.hear(20.0).rows[-1]
    assert row["ambient_degC"] == "12.00"
    for part in ("brush", "bearing", "magnet", "casing"):
        assert float(row[f"{part}_model_degC"]) == pytest.approx(12.0, abs=0.1)


def test_after_a_start_from_memory_a_rule_judges_at_once(power_up: Open) -> None:
    board = warm(power_up("watched_brush"))
    board.started()
    board.hear(60.0 + 60 * 0.25 + 5.0)
    board.cut_power(1.0, seed=2)  # nothing is left in RAM
    assert board.started().events[-1].endswith("start from memory")
    assert hot_brush(board)
