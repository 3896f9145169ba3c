"""The order of a sample's work: an alarm is about this sample's measurement and this sample's model."""

from __future__ import annotations

from itertools import pairwise

from tests.device.board import Board
from tests.device.conftest import Open

THRESHOLD_MK = 200


def mK(row: dict[str, str], column: str) -> int:
    return round(1000 * float(row[column]))


def run(board: Board) -> list[tuple[int, bool]]:
    """How far each sample's model stands above what is measured, thousandths of a kelvin; whether the rule spoke."""
    board.started()
    board.send("rows 1")
    board.hear(1.0)
    board.drive(255)
    rows = board.hear(20.0).rows
    return [(mK(row, "casing_model_degC") - mK(row, "casing_degC"), row["alarms"] == "1") for row in rows]


def test_an_alarm_speaks_at_the_very_sample_at_which_the_model_passes_its_threshold(power_up: Open) -> None:
    above = run(power_up("prompt"))
    assert any(spoke for _, spoke in above)
    assert not all(spoke for _, spoke in above)
    apart = [later[0] - earlier[0] for earlier, later in pairwise(above) if earlier[0] > 0]
    assert min(apart) > 0, "the model must pass a threshold once, and by more than its row is rounded"
    assert [spoke for _, spoke in above] == [below > THRESHOLD_MK for below, _ in above]
