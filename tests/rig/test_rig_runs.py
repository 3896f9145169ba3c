"""Run files from the rig: the interface's meaning of each column, reproducibility, and what stays hidden."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import gen.rig
from gen.rig import (
    Encoder,
    Fault,
    Motor,
    MotorConfig,
    Profile,
    SensorConfig,
    SensorFault,
    Setup,
    make_run,
    sensors,
    warm_start,
)
from gen.rig.profiles import counts, cut_off, random_levels, staircase, step
from gen.rig.signals import door, drift, sine, steps, total, value
from gen.runs import read_run

EXACT = {name: SensorConfig(noise_K=0.0, lag_s=0.0) for name in ("brush", "bearing", "magnet", "casing", "ambient")}
SHORT = staircase([120, 0, -200, 255], 60.0)


def test_a_run_is_the_motor_stepped_by_hand() -> None:
    setup = Setup(
        sensors=EXACT, sample_s=0.5, ambient=drift(20.0, 5.0), load_Nm=steps(0.0, [(90.0, 0.2)]), voltage_V=23.5
    )
    made = make_run(SHORT, setup)
    motor = Motor(ambient_degC=20.0)
    for k, t in enumerate(made.run.time_s):
        at = {name: values[k] for name, values in made.truth.temperatures.items() if name != "ambient"}
        assert at == motor.temperatures
        motor.step(
            SHORT.at(t), 0.5, load_Nm=0.2 if t >= 90.0 else 0.0, ambient_degC=20.0 + 5.0 * t / 3600.0, voltage_V=23.5
        )


def test_temperatures_are_those_before_the_rows_pwm_has_acted() -> None:
    run = make_run(staircase([0, 255], 30.0), Setup(sensors=EXACT)).run
    assert run.pwm[29] == 0 and run.pwm[30] == 255
    assert run.extras["speed_rpm"][30] == 0.0 < run.extras["speed_rpm"][31]


def test_the_same_seed_makes_the_same_file_and_another_one_other_noise(tmp_path: Path) -> None:
    profile = random_levels(5, 600.0, hold_s=(60.0, 120.0))
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        make_run(profile, Setup(seed=seed)).write(tmp_path / f"{name}.csv")
    first, again, other = ((tmp_path / f"{name}.csv").read_bytes() for name in "abc")
    assert first == again != other


def test_a_file_reads_back_and_tells_nothing_that_a_log_would_not(tmp_path: Path) -> None:
    setup = Setup(
        motor=MotorConfig(faults=(Fault("bearing", 10.0),)),
        comments={"motor": "MY1016"},
        decoys={"humidity_percent": sine(40.0, 5.0, 600.0)},
    )
    made = make_run(step(200, 120.0), setup)
    made.write(tmp_path / "run.csv")
    made.truth.write(tmp_path / "truth.csv")
    run = read_run(tmp_path / "run.csv")
    assert run.comments == {"motor": "MY1016"}
    assert list(run.temps) == ["brush", "bearing", "magnet", "casing"]
    assert set(run.extras) == {"current_A", "voltage_V", "speed_rpm", "humidity_percent"}
    assert run.ambient is not None
    for name, values in run.temps.items():
        np.testing.assert_array_equal(values, made.run.temps[name])
        assert np.all(values * 4.0 == np.round(values * 4.0))
    truth = read_run_columns(tmp_path / "truth.csv")
    assert {"winding_degC", "air_degC", "load_Nm"} <= truth


def read_run_columns(path: Path) -> set[str]:
    return set(path.read_text(encoding="utf-8").splitlines()[0].split(","))


def test_a_faulty_sensor_leaves_gaps_in_its_own_column_only() -> None:
    suite = dict(EXACT) | {"magnet": SensorConfig(noise_K=0.0, faults=(SensorFault("open", 10.0, 20.0),))}
    run = make_run(step(100, 40.0), Setup(sensors=suite)).run
    np.testing.assert_array_equal(np.isnan(run.temps["magnet"]), (run.time_s >= 10.0) & (run.time_s < 20.0))
    assert not np.isnan(run.temps["brush"]).any()


def test_measured_values_are_near_the_truth_within_the_sensors_tolerance() -> None:
    made = make_run(step(153, 1800.0), Setup(sensors=sensors(3), sample_s=5.0, seed=3))
    for name, measured in made.run.temps.items():
        off = measured - made.truth.temperatures[name]
        assert np.abs(off).max() < 1.1 + 0.125 + 5 * 0.1 + 0.1
        assert off.std() < 0.2


def test_a_warm_start_goes_on_where_the_warm_up_ended() -> None:
    whole = make_run(cut_off(153, 600.0, 300.0), Setup(sensors=EXACT, sample_s=10.0)).truth.temperatures
    warm = warm_start(step(153, 600.0))
    rest = make_run(step(0, 300.0), Setup(sensors=EXACT, sample_s=10.0, start_degC=warm)).truth.temperatures
    for name in ("brush", "casing"):
        np.testing.assert_allclose(rest[name][0], whole[name][60], atol=1e-9)
        # The warm-started rotor is at rest at once, which saves it the friction of coming to rest.
        np.testing.assert_allclose(rest[name], whole[name][60:], atol=0.02)


def test_profiles_hold_their_levels() -> None:
    profile = step(100, 50.0).then(staircase([10, -20], 5.0))
    assert [profile.at(t) for t in (0.0, 49.9, 50.0, 54.9, 55.0, 59.0, 99.0)] == [100, 100, 10, 10, -20, -20, -20]
    assert profile.duration_s == 60.0
    assert [counts(percent) for percent in (0, 20, 50, 100, -100)] == [0, 51, 128, 255, -255]
    for bad in (((0.0,), (1, 2), 5.0), ((1.0,), (1,), 5.0), ((0.0, 9.0), (1, 2), 5.0), ((0.0,), (300,), 5.0)):
        with pytest.raises(ValueError, match="profile"):
            Profile(*bad)


@pytest.mark.parametrize("seed", range(5))
def test_random_profiles_fill_their_time_and_follow_their_seed(seed: int) -> None:
    levels = random_levels(seed, 7200.0)
    assert levels == random_levels(seed, 7200.0) != random_levels(seed + 1, 7200.0)
    assert all(26 <= level <= 255 for level in levels.levels)


def test_signals_move_as_named() -> None:
    assert value(drift(30.0, 2.0), 1800.0) == 31.0
    assert value(sine(30.0, 4.0), 21_600.0) == pytest.approx(34.0)
    assert [value(steps(1.0, [(10.0, 2.0), (20.0, 3.0)]), t) for t in (9.0, 10.0, 25.0)] == [1.0, 2.0, 3.0]
    opened = door(25.0, 10.0, 100.0, 400.0)
    assert value(opened, 100.0) == 25.0
    assert value(opened, 400.0) == pytest.approx(15.0, abs=1.0)
    assert value(opened, 400.001) == pytest.approx(value(opened, 400.0), abs=0.01)
    assert value(opened, 2000.0) == pytest.approx(25.0, abs=0.1)
    assert value(total(30.0, drift(0.0, 1.0)), 3600.0) == 31.0


def test_encoder_counts_every_pulse_once_at_22_083_a_second() -> None:
    motor, encoder = Motor(), Encoder()
    motor.step(255, 5.0)
    turns, seen = [motor.revolutions], 0
    for _ in range(40):
        motor.step(255, 0.25)
        turns.append(motor.revolutions)
        seen += encoder.between(turns[-2], turns[-1])
    assert seen == encoder.between(turns[0], turns[-1])
    assert seen == pytest.approx(10 * 2650 / 60 * 500, abs=1.5)


def test_the_rig_stands_on_its_own() -> None:
    """Its physics must not lean on the model that it is there to judge."""
    allowed = ("gen.rig", "gen.runs", "gen.errors", "gen.files", "gen.arrays")
    files = list(Path(gen.rig.__file__).parent.rglob("*.py"))
    assert files
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            else:
                continue
            for name in names:
                assert not name.startswith("gen") or name == "gen" or name.startswith(allowed), f"{file.name}: {name}"


def test_bad_setups_are_refused() -> None:
    with pytest.raises(ValueError, match="unknown channel 'torque'"):
        Setup(channels=("torque",))
    with pytest.raises(ValueError, match="no node is called 'shaft'"):
        Setup(sensors={"shaft": SensorConfig()})
    with pytest.raises(ValueError, match="sample_s"):
        Setup(sample_s=0.0)
