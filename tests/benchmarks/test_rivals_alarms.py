"""The rivals' ways to hear of a fault: what each says of curves that are known."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.rivals.alarms.blocks import BLOCK_S, Blocks, FloatArray, blocks_of
from benchmarks.rivals.alarms.detectors import Detector, ModelRate, detectors, limit, residual, rise_watch
from benchmarks.rivals.alarms.judge import Heard
from benchmarks.rivals.alarms.table import alarm_table, delays_s, false_alarms
from gen.runs import Run

ROOM = 30.0


def warmed(drive: FloatArray, heat_K_s: FloatArray | float = 0.0) -> Blocks:
    """One part of one capacity: dT/dt = 0.03 u - 0.001 (1 + u) (T - room) + heat, and its model without the heat."""
    heat = np.broadcast_to(heat_K_s, drive.shape)
    over = np.zeros((2, len(drive)))
    for block in range(1, len(drive)):
        u = (drive[block - 1] + drive[block]) / 2
        share = BLOCK_S * 0.001 * (1.0 + u) / 2
        added = np.array([heat[block], 0.0]) + 0.03 * u
        over[:, block] = ((1.0 - share) * over[:, block - 1] + BLOCK_S * added) / (1.0 + share)
    ends = np.arange(1.0, len(drive) + 1.0) * BLOCK_S
    return Blocks(ends, drive, np.full(len(drive), ROOM), ROOM + over[0][:, None], ROOM + over[1][:, None])


STAIRS = np.repeat([0.0, 0.4, 1.0, 0.2, 0.7, 0.0], 90)
HEALTHY = warmed(STAIRS)


def test_a_one_capacity_model_of_one_capacity_has_no_healthy_rate() -> None:
    assert np.abs(ModelRate([HEALTHY])(HEALTHY)).max() < 1e-12


def test_its_rate_of_a_fault_is_the_fault_s_heat() -> None:
    heat = np.where(np.arange(len(STAIRS)) >= 200, 0.01, 0.0)
    rate = ModelRate([HEALTHY])(warmed(STAIRS, heat))[:, 0]
    assert np.abs(rate[:200]).max() < 1e-12
    assert rate[300:] == pytest.approx(0.01, rel=2e-3)  # 2000 s later the low-pass has followed


def test_thresholds_are_1_2_times_the_worst_healthy_number() -> None:
    found = {detector.title: detector for detector in detectors([HEALTHY, warmed(STAIRS / 2)])}
    worst = (HEALTHY.measured_degC - ROOM).max()
    assert found["fixed limit"].threshold == pytest.approx([1.2 * worst])
    two_minutes = max(HEALTHY.measured_degC[k, 0] - HEALTHY.measured_degC[k - 6, 0] for k in range(6, len(STAIRS)))
    assert found["temperature-rise watch, 2 min"].threshold == pytest.approx([1.2 * two_minutes])
    assert all(detector.first_s(HEALTHY) is None for detector in found.values())


def test_an_alarm_is_the_end_of_the_first_block_above() -> None:
    hot = warmed(STAIRS, np.where(np.arange(len(STAIRS)) >= 200, 0.02, 0.0))
    above = (hot.measured_degC - hot.model_degC)[:, 0] > 2.0
    assert Detector("", residual, np.array([2.0])).first_s(hot) == (int(np.argmax(above)) + 1) * BLOCK_S
    assert Detector("", limit, np.array([1e3])).first_s(hot) is None
    assert not rise_watch(hot)[:6].any()


def test_blocks_are_means_of_what_was_measured() -> None:
    time = np.arange(0.0, 61.0)
    measured = np.where(time == 25.0, np.nan, time)
    run = Run(time, np.full(61, -255), {"part": measured}, ambient=None)
    blocks = blocks_of(run, {"part": np.zeros(61)})
    assert blocks.end_s.tolist() == [20.0, 40.0, 60.0]
    assert blocks.drive.tolist() == [1.0, 1.0, 1.0]
    assert blocks.measured_degC[:, 0] == pytest.approx([9.5, (29.5 * 20 - 25.0) / 19, 49.5])
    assert blocks.room_degC.tolist() == [30.0, 30.0, 30.0]


def test_an_alarm_before_the_fault_is_false_and_no_delay() -> None:
    found = [
        Heard("bearing 1", 3600.0, 1.0, {"way": 3500.0}),
        Heard("bearing 1", 3600.0, 1.0, {"way": 3700.0}),
        Heard("brush 1", 3600.0, 1.0, {"way": None}),
        Heard("steady", None, 3.0, {"way": 20.0}),
        Heard("steady", None, 4.0, {"way": None}),
    ]
    assert delays_s(found[:3], "way") == [100.0]
    assert false_alarms(found, "way") == 2
    table = alarm_table(found)
    assert [next(iter(column.cells)) for column in table.columns] == ["way", "1 of 3", "100, 100", "200"]
