"""The random plants: physics against independent solutions, limits, files through gen's own reader."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import gen
from benchmarks.plants import cases
from benchmarks.plants.cases import Case, Measured, bench, fresh_runs, matrix, measure, profile_chance, write_case
from benchmarks.plants.course import course
from benchmarks.plants.draw import COOLEST_K, FASTEST_S, HOTTEST_K, LEVELS, ROOM, SLOWEST_S, random_plant
from benchmarks.plants.laws import Form, Law
from benchmarks.plants.losses import Losses
from benchmarks.plants.plant import Link, Plant, Source, Surface, copper
from benchmarks.plants.profiles import DataKind, Profile, fitted, fresh
from benchmarks.plants.rooms import Room, RoomKind
from benchmarks.plants.sensors import Sensor
from gen.arrays import FloatArray

SEEDS = range(40)
LOSSES = Losses(
    droop=0.1,
    coulomb=0.2,
    breakaway=0.4,
    stribeck=0.1,
    viscous=0.3,
    air=0.2,
    hysteresis=0.1,
    eddy=0.1,
    iron_exponent=1.8,
    load=0.3,
    resistance=0.5,
    ripple=0.2,
    ripple_exponent=1.5,
    drop=0.1,
)
LINEAR = Plant(
    names=("rotor", "casing", "mount"),
    capacity=(80.0, 300.0, 900.0),
    links=(Link(0, 1, Law(0.7)), Link(1, 2, Law(1.3, 0.5, Form.LINEAR))),
    surfaces=(Surface(1, Law(0.25, 2.0, Form.POWER, 0.8)), Surface(2, Law(0.4))),
    sources=(Source(0, "friction", 9.0), Source(0, "copper", 3.0), Source(1, "iron", 5.0)),
    losses=LOSSES,
    sensed=(0, 1, 2),
)


def by_hand(pwm: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The linear plant's equations written anew: C dT/dt = A T + b + g T_room."""
    duty = abs(pwm) / 255
    w = duty * (1 - 0.1 * duty) / 0.9
    inner, outer = 1.3 * (1 + 0.5 * w), 0.25 * (1 + 2 * w**0.8)
    a = np.array([[-0.7, 0.7, 0], [0.7, -0.7 - inner - outer, inner], [0, inner, -inner - 0.4]])
    torque = 0.2 + 0.2 * np.exp(-((w / 0.1) ** 1.5)) + 0.3 * w
    current = 0.3 + torque + 0.2 * w**2 + 0.1 + 0.1 * w**0.8
    friction, joule = torque * w, 0.5 * current**2 + 0.2 * (4 * duty * (1 - duty)) ** 1.5
    heat = np.array([9 * friction + 3 * joule, 5 * (0.1 * w + 0.1 * w**1.8), 0]) * (pwm != 0)
    return a, heat, np.array([0, outer, 0.4])


@pytest.mark.parametrize("pwm", [0, 51, -130, 255])
def test_a_linear_plant_settles_where_its_linear_equations_do(pwm: int) -> None:
    a, heat, outlet = by_hand(pwm)
    expected = np.linalg.solve(a, -(heat + 21.0 * outlet))
    np.testing.assert_allclose(LINEAR.steady(pwm, 21.0), expected, atol=1e-8)


def test_a_linear_plant_follows_the_matrix_exponential_from_hold_to_hold() -> None:
    profile = Profile("run", ((200, 1200.0), (0, 600.0), (-90, 1800.0)))
    found = course(LINEAR, profile, Room(21.0), 2.0)
    capacity = np.array(LINEAR.capacity)
    state, rows = np.full(3, 21.0), [np.full(3, 21.0)]
    for pwm, seconds in profile.holds:
        a, heat, outlet = by_hand(pwm)
        step, steady = expm(2.0 * a / capacity[:, None]), np.linalg.solve(a, -(heat + 21.0 * outlet))
        for _ in range(int(seconds / 2.0)):
            state = steady + step @ (state - steady)
            rows.append(state)
    np.testing.assert_allclose(found.temperature, rows, atol=2e-3)  # a hundredth of a sensor's step
    assert found.time[-1] == 3600.0
    change = found.time[1:][found.pwm[1:] != found.pwm[:-1]]
    assert change.tolist() == [1200.0, 1800.0]


def test_a_plant_with_what_depends_on_temperature_follows_its_equation_written_by_hand() -> None:
    node = Surface(0, Law(0.2, 1.5, Form.SATURATING, 0.3), natural=0.15, radiating=0.02)
    plant = replace(LINEAR, names=("part",), capacity=(120.0,), links=(), surfaces=(node,), sensed=(0,))
    plant = replace(plant, sources=(copper(0, 6.0),))
    room = Room(23.0, swing=5.0, period=3000.0, phase=0.4, jumps=((-4000.0, 1.0), (700.0, 4.0), (1500.0, -4.0)))
    found = course(plant, Profile("run", ((180, 2400.0),)), room, 1.0)

    duty = 180 / 255
    w = duty * (1 - 0.1 * duty) / 0.9
    torque = 0.2 + 0.2 * np.exp(-((w / 0.1) ** 1.5)) + 0.3 * w
    current = 0.3 + torque + 0.2 * w**2 + 0.1 + 0.1 * w**0.8
    joule = 6.0 * (0.5 * current**2 + 0.2 * (4 * duty * (1 - duty)) ** 1.5)

    def rate(time: float, temperature: FloatArray) -> FloatArray:
        outside = 24.0 + 2.5 * np.sin(2 * np.pi * time / 3000.0 + 0.4) + 4.0 * (700.0 <= time < 1500.0)
        over = temperature - outside
        forced = 0.2 * (1 + 1.5 * w / (w + 0.3) * 1.3) * over
        calm = 0.15 / (1 + 4 * w) * np.sign(over) * np.abs(over) ** 1.25
        warm = 5.670374419e-8 * 0.02 * ((temperature + 273.15) ** 4 - (outside + 273.15) ** 4)
        return np.asarray((joule * (1 + 0.0039 * (temperature - 25.0)) - forced - calm - warm) / 120.0)

    solved = solve_ivp(rate, (0, 2400), found.temperature[0], "RK45", found.time, max_step=0.5, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.temperature[:, 0], solved.y[0], atol=5e-3)
    # before the run it stood at rest in that room: it lags the swing, and does not begin at what the room has now
    assert 0.05 < abs(found.temperature[0, 0] - found.ambient[0]) < 5.0


@pytest.mark.parametrize("seed", [0, 3, 9])
def test_what_a_random_plant_stores_is_what_arises_in_it_less_what_it_gives_to_the_room(seed: int) -> None:
    plant = random_plant(seed)
    room = Room(22.0, swing=5.0, period=5000.0, jumps=((1000.0, 4.0),))
    profile = Profile("run", ((255, 1000.0), (0, 500.0), (80, 1500.0)))
    run = course(plant, profile, room, 1.0)
    stored = np.array(plant.capacity) @ (run.temperature[-1] - run.temperature[0])
    balance, turned = 0.0, 0.0
    edges = [0, *np.cumsum([int(seconds) for _, seconds in profile.holds]).tolist()]
    for (pwm, _), (first, last) in zip(profile.holds, pairwise(edges), strict=True):
        running = plant.at(pwm)
        rows = slice(first, last + 1)
        # at the jump itself (1000 s, an edge) the row has the room after it; what ends there has the one before
        ambient = run.ambient[rows] - 4.0 * (run.time[rows] == 1000.0) * (last == 1000)
        heat = [running.heat(t).sum() for t in run.temperature[rows]]
        lost = [running.lost(t, a).sum() for t, a in zip(run.temperature[rows], ambient, strict=True)]
        balance += float(np.trapezoid(np.subtract(heat, lost)))
        turned += float(np.trapezoid(heat))
    assert balance == pytest.approx(stored, abs=2e-4 * turned)


@pytest.mark.parametrize("seed", [1, 4, 6])
def test_a_random_plant_settles_at_what_it_calls_steady(seed: int) -> None:
    plant = random_plant(seed)
    run = course(plant, Profile("run", ((140, 40 * 3600.0),)), Room(24.0), 3600.0)
    np.testing.assert_allclose(run.temperature[-1], plant.steady(140, 24.0), atol=2e-2)


@pytest.mark.parametrize("form", Form)
def test_a_law_rises_from_rest_to_its_gain(form: Form) -> None:
    law = Law(0.4, 2.0, form, 0.6)
    values = [law(speed) for speed in np.linspace(0.0, 1.0, 101)]
    assert values[0] == pytest.approx(0.4)
    assert values[-1] == pytest.approx(0.4 if form is Form.CONSTANT else 1.2)
    assert all(after >= before for before, after in pairwise(values))


def test_no_heat_is_a_sum_of_a_w_b_w2_and_c_w_of_1_less_w() -> None:
    duty = np.arange(30, 256) / 255
    basis = np.stack([duty, duty**2, duty * (1 - duty)], axis=1)
    for seed in SEEDS:
        losses = random_plant(seed).losses
        for kind in ("friction", "windage", "copper", "brush"):
            heat = np.array([getattr(losses, kind)(float(d)) for d in duty])
            assert np.all(heat > 0.0)
            rest = heat - basis @ np.linalg.lstsq(basis, heat, rcond=None)[0]
            assert np.max(np.abs(rest)) > 2e-3 * np.max(heat), (seed, kind)


def reached(plant: Plant) -> set[int]:
    """Nodes from which heat finds a way to the room."""
    found = {surface.node for surface in plant.surfaces}
    for _ in range(plant.size):
        for link in plant.links:
            if {link.first, link.second} & found:
                found |= {link.first, link.second}
    return found


def test_random_plants_are_small_motors_of_every_kind() -> None:
    plants = [random_plant(seed) for seed in SEEDS]
    for plant in plants:
        assert 3 <= plant.size <= 10
        assert 3 <= len(plant.sensed) <= 5
        assert reached(plant) == set(range(plant.size))
        assert len(plant.surfaces) < plant.size
        peaks = np.max([plant.steady(pwm, ROOM) - ROOM for pwm in LEVELS], axis=0)[list(plant.sensed)]
        assert np.all((peaks >= COOLEST_K) & (peaks <= HOTTEST_K * 1.001))
        for pwm in (0, 255):
            fastest, slowest = plant.slowest(pwm)
            assert fastest >= FASTEST_S
            assert slowest <= SLOWEST_S * 1.000001
    assert {plant.size for plant in plants} == set(range(3, 11))
    assert {link.law.form for plant in plants for link in plant.links} == set(Form)
    surfaces = [surface for plant in plants for surface in plant.surfaces]
    assert {surface.law.form for surface in surfaces} == set(Form)
    assert 0 < sum(surface.natural > 0.0 for surface in surfaces) < len(surfaces)
    assert 0 < sum(surface.radiating > 0.0 for surface in surfaces) < len(surfaces)
    grows = [any(source.per_K > 0.0 for source in plant.sources) for plant in plants]
    assert any(grows)
    assert not all(grows)
    assert any(len(plant.links) >= plant.size for plant in plants)  # a circle of paths
    assert any(len(plant.sensed) < plant.size for plant in plants)


def test_the_same_seed_gives_the_same_plant_and_another_another() -> None:
    assert random_plant(5) == random_plant(5)
    assert random_plant(5) != random_plant(6)


def test_a_sensor_lags_is_biased_noisy_coarse_and_sometimes_silent() -> None:
    rng = np.random.default_rng(1)
    time = np.arange(0.0, 36000.0, 2.0)
    ramp = 20.0 + 0.001 * time
    read = Sensor(noise=0.2, bias=0.3, lag=12.0, gaps=0.5).read(rng, ramp, 2.0)
    assert np.isfinite(read[0])
    assert 0 < np.isnan(read).sum() < time.size / 4
    known = np.isfinite(read)
    assert np.all(read[known] % 0.25 == 0.0)
    late = known & (time > 200.0)
    assert np.mean((read - ramp)[late]) == pytest.approx(0.3 - 0.001 * 12.0, abs=0.01)
    assert np.std((read - ramp)[late]) == pytest.approx(np.hypot(0.2, 0.25 / np.sqrt(12.0)), abs=0.01)
    answer = Sensor(noise=0.0, bias=0.0, lag=10.0, gaps=0.0).read(rng, np.repeat([0.0, 64.0], [1, 600]), 1.0)
    assert answer[10] == pytest.approx(64.0 * (1.0 - np.exp(-1.0)), abs=0.125)  # 63 % after one time constant


HOURS = {
    DataKind.STEPS: [3.0] * 5,
    DataKind.MIXED: [3.0] * 5 + [4.0] * 2,
    DataKind.LONG: [10.0],
}


@pytest.mark.parametrize("kind", HOURS)
def test_the_data_are_as_long_as_they_are_said_to_be(kind: DataKind) -> None:
    runs = fitted(kind, profile_chance(bench(2)))
    assert [run.duration / 3600.0 for run in runs] == HOURS[kind]
    for run in runs:
        held = [seconds / 60.0 for _, seconds in run.holds]
        assert run.name.startswith("step_") or all(10.0 <= minutes <= 44.0 for minutes in held[:-1])


def test_ten_runs_of_which_none_settles() -> None:
    runs = fitted(DataKind.UNSETTLED, profile_chance(bench(2)))
    assert len(runs) == 10
    for run in runs:
        assert len(run.holds) >= 6
        for (pwm, seconds), (rest, resting) in zip(run.holds[::2], run.holds[1::2], strict=True):
            assert 51 <= pwm <= 255
            assert 120.0 <= seconds <= 900.0
            assert (rest, resting) == (0, 600.0)


def test_the_test_runs_are_two_of_which_one_stops_and_reverses() -> None:
    for seed in range(10):
        turning, stopping = fresh(profile_chance(bench(seed)))
        assert turning.duration == stopping.duration == 4 * 3600.0
        assert all(pwm >= 51 for pwm, _ in turning.holds)
        levels = [pwm for pwm, _ in stopping.holds]
        assert levels[0] != 0
        assert all(first or second for first, second in pairwise(levels))
    levels = [pwm for seed in range(10) for pwm, _ in fresh(profile_chance(bench(seed)))[1].holds]
    assert any(pwm == 0 for pwm in levels)
    assert any(pwm < 0 for pwm in levels)
    assert any(pwm > 0 for pwm in levels)


def test_the_matrix_has_every_case_once() -> None:
    cells = matrix(range(100), DataKind, RoomKind)
    assert len(cells) == len(set(cells)) == 100 * 4 * 3
    assert {(cell.data, cell.room) for cell in cells[:12]} == {(d, r) for d in DataKind for r in RoomKind}
    assert all(Case.parse(str(cell)) == cell for cell in cells[:12])
    assert str(cells[0]) == "0:steps:held"


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def written(tmp_path: Path) -> Callable[[Case], dict[str, bytes]]:
    def write(case: Case) -> dict[str, bytes]:
        folder = tmp_path / str(case).replace(":", "-")
        folder.mkdir(exist_ok=True)
        write_case(case, folder)
        return contents(folder)

    return write


def test_files_depend_on_seed_and_room_alone(written: Callable[[Case], dict[str, bytes]]) -> None:
    steps = written(Case(3, DataKind.STEPS, RoomKind.MOVING))
    bench.cache_clear()
    assert written(Case(3, DataKind.STEPS, RoomKind.MOVING)) == steps
    mixed = written(Case(3, DataKind.MIXED, RoomKind.MOVING))
    assert {name: mixed[name] for name in steps} == steps  # what comes on top changes nothing of what was there
    assert sorted(set(mixed) - set(steps)) == ["mixed_1.csv", "mixed_2.csv"]
    held = written(Case(3, DataKind.STEPS, RoomKind.HELD))
    assert sorted(held) == sorted(steps)
    assert not any(held[name] == steps[name] for name in steps)
    other = written(Case(4, DataKind.STEPS, RoomKind.MOVING))
    assert not any(other[name] == steps[name] for name in steps)


@pytest.mark.parametrize("room", RoomKind)
def test_gen_reads_the_files_and_finds_what_was_measured(room: RoomKind, tmp_path: Path) -> None:
    case = Case(1, DataKind.UNSETTLED, room)
    files = write_case(case, tmp_path)
    assert len(files.fit) == 10
    assert [path.stem for path in files.test] == ["test_turning", "test_stopping"]
    stand, errors = files.bench, []
    for path, measured in zip(files.test, fresh_runs(stand, room), strict=True):
        frame = gen.read_run(path)
        assert ("ambient_degC" in frame) == (room is not RoomKind.UNMEASURED)
        assert set(stand.channels) <= set(frame.columns)
        assert set(np.unique(np.diff(frame.index))) <= {stand.row_s, 2 * stand.row_s, 3 * stand.row_s}
        np.testing.assert_array_equal(frame["pwm"], measured.run.pwm)
        for node in stand.plant.sensed:
            column = frame[f"{stand.plant.names[node]}_degC"].to_numpy()
            assert np.isfinite(column[0])
            errors.append(column - measured.run.temperature[:, node])
        hidden = {name for node, name in enumerate(stand.plant.names) if node not in stand.plant.sensed}
        assert not {f"{name}_degC" for name in hidden} & set(frame.columns)
    every = np.concatenate(errors)
    assert files.floor_K == pytest.approx(np.sqrt(np.nanmean(every**2)), rel=1e-12)
    assert 0.05 < files.floor_K < 0.7


def test_only_who_starts_warm_in_a_room_that_is_not_measured_notes_its_temperature() -> None:
    stand = bench(0)
    runs = fitted(DataKind.UNSETTLED, profile_chance(stand))
    assert any(run.before for run in runs)
    assert not all(run.before for run in runs)
    for profile in runs:
        for room in RoomKind:
            measured = measure(stand, profile, room)
            if profile.before and room is RoomKind.UNMEASURED:
                assert float(measured.notes["ambient_degC"]) == pytest.approx(measured.run.ambient[0], abs=0.5)
            else:
                assert measured.notes == {}


def test_a_logger_that_loses_rows_loses_no_change_of_pwm() -> None:
    losing = next(bench(seed) for seed in SEEDS if bench(seed).lost > 0.0)
    profile = Profile("run", tuple((60 + 10 * (i % 15), 8.0) for i in range(450)))
    run = measure(replace(losing, lost=0.3), profile, RoomKind.HELD).run
    assert run.time.size < 0.9 * (3600.0 / losing.row_s)
    changes = run.time[1:][run.pwm[1:] != run.pwm[:-1]]
    assert changes.tolist() == [8.0 * i for i in range(1, 450)]


def spread(run: Measured) -> float:
    return float(np.ptp(run.run.ambient))


def test_the_room_is_held_moves_or_drifts() -> None:
    stand = bench(7)
    profile = Profile("run", ((120, 8 * 3600.0),))
    held, moving, unmeasured = (measure(stand, profile, kind) for kind in RoomKind)
    assert spread(held) == 0.0
    assert spread(moving) > 5.0
    jumps = np.abs(np.diff(moving.run.ambient))
    assert jumps.max() == pytest.approx(4.0, abs=0.05)
    assert 0.0 < spread(unmeasured) <= 1.0
    assert "ambient_degC" in held.columns
    assert "ambient_degC" not in unmeasured.columns
    assert np.nanmax(np.abs(held.columns["ambient_degC"] - stand.usual)) < 2.5


def test_decoys_vary_but_say_nothing_that_pwm_does_not() -> None:
    for seed in range(6):
        stand = bench(seed)
        assert 2 <= len(stand.channels) <= 4
        run = measure(stand, Profile("run", ((200, 3600.0), (90, 3600.0))), RoomKind.MOVING)
        for name in stand.channels:
            values = run.columns[name]
            assert np.std(values) > 0.0
            if name in ("current_A", "speed_rpm"):  # at one PWM only noise: nothing of the temperature, nor of the room
                half = values[run.run.pwm == 200][: int(3600 / stand.row_s)]
                first, second = np.array_split(half, 2)
                assert abs(first.mean() - second.mean()) < 6.0 * np.std(half) / np.sqrt(first.size / 2)


def test_the_plants_share_no_line_with_what_they_judge() -> None:
    for path in Path(cases.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            assert not [name for name in names if name.split(".")[0] in ("gen", "tests", "control")], path
