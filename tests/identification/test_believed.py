"""Readings that no part can have shown, off-line; what was made wild is known."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import gen
from gen.arrays import FloatArray, IntArray
from gen.coefficients.wiring import Thermocouple
from gen.identification.logs import believed as module
from gen.identification.logs.alone import standing_alone
from gen.identification.logs.believed import NOISE_K, RATE_K_PER_S, believed, believed_run, scatter_K
from gen.lowering.sensors import COUNT_K, NOISE_COUNTS
from gen.runs import Run


def warm_up(rng: np.random.Generator, step: float = 0.5) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Two minutes of running and eight of rest: time, |PWM| over full scale, and a part's temperature, degC."""
    at = np.arange(0.0, 600.0, step)
    on = (at >= 5.0) & (at < 125.0)
    rise = np.empty(at.size)
    level = 0.0
    for k, running in enumerate(on):
        rise[k] = level
        level += step * (0.6 * running - level / (60.0 if running else 300.0))
    return at, on.astype(np.float64), 24.0 + rise + rng.normal(0.0, 0.1, at.size)


@pytest.mark.parametrize("seed", range(5))
def test_what_is_wild_while_the_motor_runs_is_found_and_nothing_else_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    at, on, true = warm_up(rng)
    read = np.round(4.0 * true) / 4.0
    running = on > 0.0
    missing = running & (rng.random(at.size) < 0.38)
    wild = running & ~missing & (rng.random(at.size) < 0.5)
    read[wild] -= rng.uniform(20.0, 60.0, np.count_nonzero(wild))
    read[missing] = np.nan
    kept = believed(at, read)
    sound = ~wild & ~missing
    assert not kept[wild].any()
    assert np.mean(kept[sound]) > 0.98


def test_a_part_that_is_read_soundly_loses_nothing() -> None:
    rng = np.random.default_rng(1)
    at, _, true = warm_up(rng, 10.0)
    noisy = true + rng.normal(0.0, 1.5, at.size)
    for values in (true, noisy, np.round(true)):
        assert believed(at, values).all()


def test_a_burst_longer_than_the_window_is_bridged() -> None:
    rng = np.random.default_rng(2)
    at = np.asarray(np.arange(4000) * 0.5, dtype=np.float64)
    true = 40.0 + 10.0 * np.sin(at / 400.0)
    wild = (at > 500.0) & (at < 900.0)
    read = np.where(wild, true + rng.uniform(-60.0, 60.0, at.size), true)
    kept = believed(at, read)
    assert np.mean(kept[~wild]) > 0.99
    far = np.abs(read - true) > 10.0
    assert np.mean(kept[wild & far]) < 0.05


def test_the_limits_are_those_of_the_board() -> None:
    assert Thermocouple.model_fields["max_rate_K_per_s"].default == RATE_K_PER_S
    assert NOISE_COUNTS * COUNT_K == NOISE_K


def test_what_was_taken_out_is_said() -> None:
    at, on, true = warm_up(np.random.default_rng(3))
    read = true.copy()
    read[100] += 30.0
    run = believed_run(Run(at, (255 * on).astype(np.int64), {"coil": read, "case": true}))
    assert run.doubted == (
        f"coil_degC: 1 of {at.size} readings are not believed, up to 30 K off what lies around them: "
        "a part does not change faster than 5 K/s",
    )
    assert np.isnan(run.temps["coil"][100])
    assert run.temps["case"] is true


def test_a_file_may_know_how_fast_a_part_changes() -> None:
    at = np.arange(200.0)
    run = Run(at, np.full(200, 255), {"wire": np.where(at < 100.0, 20.0, 60.0)})
    assert believed_run(run).doubted
    assert believed_run(run, {"wire": 50.0}) is run


def test_a_column_of_which_nothing_is_believed_is_said() -> None:
    at = np.arange(400.0)
    wild = np.repeat(np.random.default_rng(5).uniform(-200.0, 4000.0, at.size // 2), 2)
    run = believed_run(Run(at, np.full(400, 255), {"coil": wild}))
    assert np.isnan(run.temps["coil"]).all()
    assert run.doubted == (
        "coil_degC: none of 400 readings is believed: they scatter by 776 K (standard deviation of a reading about its "
        "neighbours), which is no temperature's",
    )


def test_a_spike_in_each_fiftieth_reading_is_left_out_and_nothing_else() -> None:
    rng = np.random.default_rng(4)
    at = np.asarray(np.arange(100_000) * 0.25, dtype=np.float64)
    read = 50.0 + rng.normal(0.0, 0.2, at.size)
    read[::50] += 40.0
    kept = believed(at, read)
    assert np.count_nonzero(kept) == at.size - at.size // 50


def test_a_network_of_wild_logs_is_that_of_the_sound_ones() -> None:
    """Mean error of what is identified from wild logs, on a sound one: within a kelvin of a rise of over 30 K."""
    runs = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        at, on, true = warm_up(rng)
        if seed < 2:
            running = on > 0.0
            true[running & (rng.random(at.size) < 0.38)] = np.nan
            wild = running & (rng.random(at.size) < 0.5)
            true[wild] -= rng.uniform(20.0, 60.0, np.count_nonzero(wild))
        runs.append(Run(at, (200 * on).astype(np.int64), {"motor": true}, ambient=np.full(at.size, 24.0)))
    found = gen.identify([frame(run) for run in runs[:2]], model="network", max_hidden=1)
    assert any("not believed" in warning for warning in found.warnings)
    shown = gen.simulate(found.model, frame(runs[2]))["motor_degC"].to_numpy(dtype=np.float64)
    assert float(np.sqrt(np.mean((shown - runs[2].temps["motor"]) ** 2))) < 1.0


def frame(run: Run) -> pd.DataFrame:
    """A run as a table."""
    return pd.DataFrame(run.columns()).set_index("time_s")


def test_a_spike_in_a_million_readings_costs_its_surroundings_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at: list[int] = []
    real = module._longest

    def counted(time: FloatArray, value: FloatArray, noise: float, rate: float) -> IntArray:
        looked_at.append(time.size)
        return real(time, value, noise, rate)

    monkeypatch.setattr(module, "_longest", counted)
    at = np.asarray(0.25 * np.arange(1_000_000), dtype=np.float64)
    values = 40.0 + np.random.default_rng(1).normal(0.0, 0.2, at.size)
    values[[500_000, 900_000]] += 50.0
    kept = believed(at, values)
    assert np.flatnonzero(~kept).tolist() == [500_000, 900_000]
    assert sum(looked_at) < 5_000


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("spread_K", [15.0, 60.0, 200.0])
def test_of_a_sensor_that_is_wild_all_the_time_nothing_is_believed(seed: int, spread_K: float) -> None:
    rng = np.random.default_rng(seed)
    at, on, true = warm_up(rng)
    read = true + rng.normal(0.0, spread_K, at.size)
    assert not believed(at, read).any()
    run = believed_run(Run(at, (255 * on).astype(np.int64), {"coil": read, "case": true}))
    assert np.isnan(run.temps["coil"]).all()
    assert np.array_equal(run.temps["case"], true)
    (said,) = run.doubted
    assert said.startswith(f"coil_degC: none of {at.size} readings is believed: they scatter by ")


def test_a_part_that_warms_by_kelvins_from_row_to_row_scatters_no_more_for_it() -> None:
    at = np.asarray(np.arange(60) * 10.0, dtype=np.float64)
    ramp = 20.0 + 3.0 * at + np.random.default_rng(4).normal(0.0, 0.3, at.size)
    assert 0.1 < scatter_K(ramp) < 1.0
    assert believed(at, ramp).all()


def slow_log(rng: np.random.Generator) -> tuple[IntArray, FloatArray]:
    """A row each 30 s, of a heater that is held for 20 minutes at a time: counts, and degC."""
    pwm = np.repeat(np.array([0, 180, 90, 230, 0, 140]), 40)
    level, true = 0.0, np.empty(pwm.size)
    for k, counts in enumerate(pwm):
        true[k] = 22.0 + level
        level += 30.0 * (0.04 * counts / 255.0 - level / 1500.0)
    return pwm, true + rng.normal(0.0, 0.1, pwm.size)


@pytest.mark.parametrize("off_K", [35.0, -20.0, 6.0])
@pytest.mark.parametrize("seed", range(4))
def test_readings_that_stand_alone_in_a_slow_log_are_found_and_nothing_else_is(seed: int, off_K: float) -> None:
    """At 30 s from row to row a part may change by 150 K, for all that the check of jumps knows."""
    rng = np.random.default_rng(seed)
    pwm, read = slow_log(rng)
    spikes = 2 + 7 * rng.choice(pwm.size // 7 - 1, 8, replace=False)
    spikes = spikes[(pwm[spikes - 1] == pwm[spikes]) & (pwm[spikes] == pwm[spikes + 1])]
    read[spikes] += off_K
    run = Run(np.arange(0.0, 30.0 * pwm.size, 30.0), pwm, {"heater": read})
    found = believed_run(run)
    assert np.flatnonzero(~np.isfinite(found.temps["heater"])).tolist() == sorted(spikes.tolist())
    assert f"{spikes.size} of {pwm.size} readings stand alone while PWM was held" in found.doubted[0]
    assert f"up to {abs(off_K):.0f} K off" in found.doubted[0]


@pytest.mark.parametrize("spread_K", [0.0, 0.3, 2.0])
def test_nothing_stands_alone_in_a_sound_log_nor_where_the_input_switches(spread_K: float) -> None:
    """A light part that is warmed in one row and not in the next may go up and down again."""
    rng = np.random.default_rng(5)
    pwm, read = slow_log(rng)
    assert not standing_alone(np.round(read + rng.normal(0.0, spread_K, read.size), 1), pwm).any()
    switched = np.where(rng.random(pwm.size) < 0.1, 200, 0)
    light = 22.0 + 30.0 * (np.roll(switched, 1) > 0) + rng.normal(0.0, 0.1, pwm.size)
    assert not standing_alone(light, switched).any()
