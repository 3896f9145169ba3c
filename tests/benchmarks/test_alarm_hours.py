"""The oracle's delay where it is known on paper, and lives that are the same each time."""

from __future__ import annotations

import numpy as np

from benchmarks.alarm_hours.judged import pieces
from benchmarks.alarm_hours.lives import FAULT_S, LOADS_NM, RUN_S, Life, healthy_lives, load_lives, other_lives
from benchmarks.alarm_hours.oracle import LATEST_S, RATES_H, Delays, oracle_delays, oracle_table
from gen.arrays import FloatArray
from gen.rig import SensorConfig, Setup, make_run
from gen.rig.profiles import step
from gen.rig.signals import value

ROW_S = 10.0
SETUP = Setup(sensors={"casing": SensorConfig(noise_K=0.3)}, sample_s=ROW_S)
LIFE = Life("bearing 1", step(100, 8000.0), SETUP, FAULT_S)
VARIANCE = 0.3**2 + 0.25**2 / 12.0
SHIFT_K = 0.3


def delays_rows(rise_K: float, seed: int) -> FloatArray:
    """In rows, where a sensor reads so much more from the fault on and the oracle expects `SHIFT_K`."""
    begun = ROW_S * np.arange(801) > FAULT_S
    noise = np.random.default_rng(seed).normal(0.0, np.sqrt(VARIANCE), begun.size)
    read = {"casing": np.where(begun, rise_K, 0.0) + noise}
    return oracle_delays(LIFE, SETUP, {"casing": np.where(begun, SHIFT_K, 0.0)}, read) / ROW_S


def test_the_oracle_hears_a_step_after_the_logarithm_of_the_rate_over_the_divergence() -> None:
    """Each factor of e in the rate takes 1 / (shift^2 / 2 variance) readings (Pollak 1985, theorem 3)."""
    found = np.mean([delays_rows(SHIFT_K, seed) for seed in range(150)], axis=0)
    divergence = SHIFT_K**2 / (2.0 * VARIANCE)
    slope = np.polyfit(np.log(RATES_H), found, 1)[0]
    assert 0.8 < slope * divergence < 1.05  # less than one by those that noise lets hear at once
    assert np.all(found < np.log(np.array(RATES_H) * 3600.0 / ROW_S) / divergence + 2.0)


def test_noise_alone_is_hardly_ever_heard() -> None:
    heard = [delays_rows(0.0, 1000 + seed)[2] * ROW_S <= LATEST_S for seed in range(50)]
    assert sum(heard) <= 1  # fifty hours at one false alarm in a thousand


def test_a_table_counts_what_is_not_heard() -> None:
    near, far = np.full(4, 40.0), np.full(4, np.inf)
    table = oracle_table([Delays("bearing 1", near, near / 2.0), Delays("bearing 1", far, near)])
    assert list(table.columns[2].cells) == ["2 of 2"] * 4
    assert list(table.columns[4].cells) == ["1 of 2"] * 4


def test_loads_come_and_go_and_are_the_same_each_time() -> None:
    lives, again = (list(load_lives(3, 2)) for _ in range(2))
    assert len(lives) == len(LOADS_NM) * 3 * 2
    times = np.arange(0.0, 10_800.0, 60.0)
    for one, other in zip(lives, again, strict=True):
        loads = [value(one.setup.load_Nm, t) for t in times]
        assert loads == [value(other.setup.load_Nm, t) for t in times]
        assert 0.0 <= max(loads) <= float(one.kind.split()[-2])
    assert sum(life.fault_s is None for life in lives) == len(LOADS_NM) * 2


def test_a_reset_hides_from_the_board_what_was_before() -> None:
    """Each piece begins with its own first reading, and no row is in both or in none."""
    run = make_run(step(100, 60.0), Setup(seed=1)).run
    before, after = pieces(run, 20.0)
    assert before.time_s[-1] < 20.0 <= after.time_s[0]
    for name, values in run.columns().items():
        np.testing.assert_array_equal(np.concatenate([before.columns()[name], after.columns()[name]]), values)
    assert pieces(run, None) == [run]


def test_lives_with_a_reset_have_one_in_the_middle() -> None:
    lives = list(healthy_lives(60.0, 5, ("resets at one speed", "steady")))
    assert {life.reset_s is not None for life in lives if life.kind == "steady"} == {False}
    times = [life.reset_s for life in lives if life.kind != "steady"]
    assert len(times) == 10
    assert all(time is not None and 1800.0 <= time <= RUN_S - 1800.0 for time in times)
    struck = [life for life in other_lives(5, 2) if life.reset_s is not None]
    assert [life.kind for life in struck] == ["bearing half an hour after a reset", "brush half an hour after a reset"]
    assert all(life.fault_s is not None and life.reset_s is not None for life in struck)
