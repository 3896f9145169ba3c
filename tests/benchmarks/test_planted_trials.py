"""Trials with what is planted: it can be seen, identification knows nothing of it, files and names are as asked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gen
from benchmarks.plants.cases import Bench, Case, bench, write_case
from benchmarks.plants.course import course
from benchmarks.plants.planted import losses, outside, paths, sensing
from benchmarks.plants.planted.change import Change
from benchmarks.plants.planted.draw import LIBRARY, NotVisible, planted
from benchmarks.plants.planted.kinds import FAULTS, KINDS, OUTSIDE
from benchmarks.plants.planted.later import FIT_NAMES, TEST_NAMES, channels, floor, follow, log
from benchmarks.plants.planted.trial import Setting, Trial, setting, trials, write_identification, write_trial
from benchmarks.plants.planted.visible import LEAST_PEAK_K, LEAST_RMS_K, MOST_PEAK_K, sight
from benchmarks.plants.profiles import DataKind
from benchmarks.plants.rooms import RoomKind
from gen.arrays import FloatArray
from gen.model.effects import catalogue_only, registry


def test_nothing_planted_is_the_motor_as_it_was() -> None:
    stand = bench(5)
    found = follow(stand, (), "later_2", 10.0)
    plain = course(stand.plant, found.profile, found.room, 10.0)
    np.testing.assert_allclose(found.run.temperature, plain.temperature, atol=1e-9)
    np.testing.assert_array_equal(found.seen, found.run.temperature[:, list(stand.plant.sensed)])


def test_later_runs_last_four_hours_with_stops_and_reversals() -> None:
    levels = []
    for name in (*FIT_NAMES[:6], *TEST_NAMES):
        profile = follow(bench(3), (), name, 60.0).profile
        assert profile.duration == 4 * 3600.0
        assert all(240.0 <= seconds <= 2400.0 for _, seconds in profile.holds[:-1])
        levels += [pwm for pwm, _ in profile.holds]
    assert {np.sign(pwm) for pwm in levels} == {-1, 0, 1}


SEES = {"initial_state": 5, "ceiling": 2}
"""Benches that see what few do."""
DRAWN = [(SEES.get(name, (1, 2, 4)[number % 3]), name) for number, name in enumerate(KINDS)]


@pytest.mark.parametrize(("seed", "name"), DRAWN)
def test_what_is_planted_can_be_seen_and_is_no_other_motor(seed: int, name: str) -> None:
    made = planted(bench(seed), name, KINDS[name])
    assert LEAST_PEAK_K <= made.sight.peak_K <= MOST_PEAK_K
    assert min(made.sight.fit_K, made.sight.test_K) >= LEAST_RMS_K


@pytest.mark.parametrize(("seed", "name"), DRAWN[::8])
def test_what_is_planted_is_the_same_each_time(seed: int, name: str) -> None:
    made = planted(bench(seed), name, KINDS[name])
    assert planted(bench(seed), name, KINDS[name]) == made
    assert sight(bench(seed), made.change) == made.sight


def test_there_are_sixteen_effects_and_the_library_knows_them_all() -> None:
    with catalogue_only():  # no effect that another test made known
        assert set(LIBRARY) == set(registry())
    assert len(LIBRARY) == 16
    assert len(OUTSIDE) >= 6
    assert not set(LIBRARY) & set(OUTSIDE)
    assert len(KINDS) == len(LIBRARY) + len(OUTSIDE) + len(FAULTS)


def test_what_cannot_be_seen_is_not_planted(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(NotVisible, match="initial_state"):
        planted(bench(0), "initial_state", KINDS["initial_state"])  # its nodes without a sensor forget at once


@pytest.mark.parametrize("names", [(), ("hidden_node",), ("ambient", "drift")])
def test_identification_runs_know_nothing_of_what_is_planted_later(names: tuple[str, ...], tmp_path: Path) -> None:
    made = setting(2, names)
    assert made.bench.seed == 2
    plain, own = tmp_path / "plain", tmp_path / "own"
    plain.mkdir()
    own.mkdir()
    case = write_case(Case(2, DataKind.MIXED, RoomKind.HELD), plain)
    found = write_identification(made, own)
    assert [path.name for path in found] == [path.name for path in case.fit]
    for path, other in zip(found, case.fit, strict=True):
        if "ambient" in names:
            frame, whole = gen.read_run(path), gen.read_run(other)
            assert "ambient_degC" not in frame
            assert frame.equals(whole.drop(columns="ambient_degC"))
        else:
            assert path.read_bytes() == other.read_bytes()


def logged(stand: Bench, changes: Sequence[Change], name: str = "later_1") -> dict[str, FloatArray]:
    return {key: np.asarray(values, dtype=np.float64) for key, values in log(stand, changes, name).columns.items()}


CHANNELS: list[tuple[str, Change]] = [
    ("airflow_mps", paths.Airflow((0,), 0.01, 0.05)),
    ("current_A", losses.LoadHeating(0.5)),
    ("voltage_V", losses.SupplyVoltage(0.1)),
]


@pytest.mark.parametrize(("channel", "change"), CHANNELS)
def test_a_channel_is_logged_for_what_needs_it_and_tells_nothing_by_being_there(channel: str, change: Change) -> None:
    benches = [bench(seed) for seed in range(20)]
    assert all(channel in channels(stand, (change,)) for stand in benches)
    assert 3 <= sum(channel in channels(stand, ()) for stand in benches) < 20
    assert all(set(stand.channels) <= set(channels(stand, ())) for stand in benches)
    stand = bench(4)
    varying = logged(stand, (change,))[channel]
    steps = np.abs(np.diff(np.convolve(varying, np.full(30, 1 / 30), "valid")))
    assert np.max(steps) > 5.0 * np.median(steps)


def test_who_logs_no_current_logs_none() -> None:
    with_it = next(stand for stand in map(bench, range(20)) if "current_A" in stand.channels)
    change = outside.LoadCycle(0.3, 2000.0)
    assert "current_A" not in logged(with_it, (change,))
    assert set(with_it.channels) - {"current_A"} <= set(logged(with_it, (change,)))


def test_the_floor_is_noise_alone_whatever_is_planted() -> None:
    stand = bench(2)
    node = stand.plant.sensed[0]
    found = {
        name: floor(stand, [log(stand, changes, run) for run in TEST_NAMES])
        for name, changes in {
            "nothing": (),
            "offset": (sensing.SensorOffset(node, 5.0),),
            "lag": (sensing.SensorLag(node, 500.0),),
            "load": (losses.LoadHeating(0.5),),
        }.items()
    }
    for value in found.values():
        assert value == pytest.approx(found["nothing"], rel=0.05)
    assert 0.05 < found["nothing"] < 0.7


def test_a_trials_files_are_read_and_are_the_same_with_two_fit_runs_or_six(tmp_path: Path) -> None:
    two, six = tmp_path / "two", tmp_path / "six"
    two.mkdir()
    six.mkdir()
    trial = Trial(1, ("airflow", "sensor_offset"), 2)
    small, large = write_trial(trial, two), write_trial(replace(trial, fit_runs=6), six)
    assert [path.stem for path in small.fit] == list(FIT_NAMES[:2])
    assert [path.stem for path in large.fit] == list(FIT_NAMES[:6])
    for path in (*small.fit, *small.test):
        assert path.read_bytes() == (six / path.name).read_bytes()
    assert small.floor_K == large.floor_K
    stand = small.setting.bench
    for path in small.fit:
        frame = gen.read_run(path)
        sensed = {f"{stand.plant.names[node]}_degC" for node in stand.plant.sensed}
        assert {*sensed, "ambient_degC", "airflow_mps", *stand.channels} <= set(frame.columns)


def test_trials_have_names() -> None:
    trial = Trial(3, ("airflow", "drift"), 6)
    assert Trial.parse(str(trial)) == trial
    assert Trial.parse("3:nothing:2") == Trial(3, (), 2)
    for wrong in ("3:wind:2", "3:airflow:21", "3:airflow"):
        with pytest.raises(ValueError, match=r".*"):
            Trial.parse(wrong)
    made = trials([1, 2], [("drift",), ()], [2, 6])
    assert [str(one) for one in made[:4]] == ["1:drift:2", "1:drift:6", "1:nothing:2", "1:nothing:6"]


def test_where_one_bench_sees_nothing_another_stands_in(monkeypatch: pytest.MonkeyPatch) -> None:
    from benchmarks.plants.planted import trial as module

    def only_far(stand: Bench, name: str, drafting: Callable[..., object]) -> object:
        if stand.seed < 2000:
            raise NotVisible(name)
        return object()

    monkeypatch.setattr(module, "planted", only_far)
    module.setting.cache_clear()
    found: Setting = setting(7, ("drift",))
    assert found.bench.seed == 2007
    module.setting.cache_clear()
