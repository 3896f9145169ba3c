"""One network from runs of known motors: what it predicts on runs that took no part, and what it says of itself."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.identification.logs.sources import Source, read_sources
from gen.identification.network.data import make_network_data
from gen.identification.network.identify import NetworkFound, identify_network
from gen.identification.network.telling.document import network_text
from gen.identification.network.telling.summary import Summary
from gen.identification.settings import Settings
from gen.model.network_solution import NetworkSolution
from gen.rig import Setup, make_run, sensors
from gen.rig.profiles import cut_off
from gen.runs import Run
from tests.identification.network.plant import EIGHT, ROOM, TWO, Plant, holds

NOISE = 0.15
FLOOR = float(np.hypot(NOISE, 0.25 / np.sqrt(12.0)))
"""What sensors and quantiser leave, K."""
FRESH = holds((180, 40), (0, 20), (90, 35), (240, 30), (130, 25), (0, 30))


def found_of(runs: Sequence[Run], hidden: int = 2, ambient: float | None = None) -> tuple[NetworkFound, Coefficients]:
    data = make_network_data([Source(f"run_{k}.csv", run) for k, run in enumerate(runs)], ambient)
    result = identify_network(data, lambda _: None, hidden)
    _, loaded = network_text(result, Settings("plant"))
    return result, loaded


def off(loaded: Coefficients, plant: Plant, pwm: IntArray, room: FloatArray | None = None) -> float:
    """Root mean square of model minus truth on a run from cold, K, over the parts."""
    around = np.full(pwm.size, ROOM) if room is None else room
    time = 4.0 * np.arange(pwm.size, dtype=np.float64)
    network = loaded.model.network
    assert network is not None
    start = {name: float(around[0]) for name in plant.sensed}
    shown = NetworkSolution(loaded.model).simulate_times(time, pwm, around, None, start)
    true = plant.true(pwm, around)
    return float(np.sqrt(np.mean([(shown[name] - true[:, node]) ** 2 for name, node in plant.sensed.items()])))


def mixed(rng: np.random.Generator, plant: Plant, count: int = 3) -> list[Run]:
    profiles = [
        holds((200, 50), (60, 40), (0, 30), (255, 35), (120, 30)),
        holds((90, 60), (230, 30), (150, 40), (0, 40), (180, 20)),
        holds((255, 45), (0, 25), (110, 45), (70, 30), (210, 40)),
    ]
    return [plant.run(pwm, rng, noise=NOISE) for pwm in profiles[:count]]


def test_readings_on_a_fresh_run_are_below_the_noise_although_five_of_eight_nodes_are_hidden() -> None:
    result, loaded = found_of(mixed(np.random.default_rng(1), EIGHT))
    assert loaded.model.component_names == ("brush", "magnet", "casing")
    assert loaded.model.network is not None
    assert loaded.model.network.hidden
    assert off(loaded, EIGHT, FRESH) < 0.5 * FLOOR
    assert result.judged.score_K < FLOOR


def test_two_processes_give_the_file_that_one_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    texts = []
    for processors in ({0, 1}, {0}):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, all_of=processors: all_of, raising=False)
        result, _ = found_of(mixed(np.random.default_rng(4), TWO), hidden=1)
        texts.append(network_text(result, Settings("plant"))[0])
    assert texts[0] == texts[1]


def test_a_room_that_moves_and_jumps_is_followed_through_the_parts_masses() -> None:
    """At speeds that were run: what lies between them is asked elsewhere."""
    rng = np.random.default_rng(2)
    fresh = holds((200, 40), (0, 20), (80, 35), (255, 30), (120, 25), (0, 30))
    time = 4.0 * np.arange(fresh.size)
    swing = ROOM + 2.5 * np.sin(time / 2500.0) + 4.0 * (time > 5000.0)
    runs = [
        EIGHT.run(pwm, rng, ROOM + 2.5 * np.sin(4.0 * np.arange(pwm.size) / 2000.0 + phase), NOISE)
        for pwm, phase in ((holds((200, 60), (0, 40), (120, 60)), 0.0), (holds((80, 60), (255, 60), (0, 40)), 2.0))
    ]
    _, loaded = found_of(runs)
    assert off(loaded, EIGHT, fresh, swing) < FLOOR


def test_gaps_are_no_harm() -> None:
    rng = np.random.default_rng(3)
    runs = [EIGHT.run(run.pwm, rng, noise=NOISE, gaps=0.6) for run in mixed(rng, EIGHT)]
    for run in runs:
        run.temps["magnet"][500:1400] = np.nan
    _, loaded = found_of(runs, 1)
    assert off(loaded, EIGHT, FRESH) < FLOOR


def test_one_run_is_enough() -> None:
    """Left out are stretches of it."""
    rng = np.random.default_rng(4)
    whole = holds((200, 40), (60, 40), (0, 30), (255, 35), (120, 30), (0, 20), (170, 40), (230, 20), (90, 40))
    result, loaded = found_of([EIGHT.run(whole, rng, noise=NOISE)])
    assert off(loaded, EIGHT, FRESH) < FLOOR
    assert result.judged.by_fold.shape == (4, 3)


def test_runs_that_never_settle_are_used_and_the_time_span_is_said() -> None:
    rng = np.random.default_rng(5)
    runs = [
        EIGHT.run(holds((pwm, 4), (0, 10), (pwm - 40, 6), (0, 10)), rng, noise=NOISE) for pwm in (250, 200, 150, 110)
    ]
    result, loaded = found_of(runs, 1)
    assert off(loaded, EIGHT, holds((220, 5), (0, 10), (130, 5), (0, 10))) < FLOOR
    said = Summary(result)
    longest, slowest = said.span_s
    assert longest == pytest.approx(600.0, abs=30.0)
    assert slowest > 600.0
    assert "up to 10 min" in said.verdict
    assert any("10 min at most" in warning and "extrapolated" in warning for warning in said.warnings())


def test_a_hidden_node_is_taken_where_there_is_one_and_not_where_there_is_none() -> None:
    with_all, _ = found_of(mixed(np.random.default_rng(6), TWO), 1)
    assert with_all.found.structure.hidden == 0
    winding_only = replace(TWO, sensed={"winding": 0})
    without, loaded = found_of(mixed(np.random.default_rng(6), winding_only), 1)
    assert without.found.structure.hidden == 1
    worse, better = (candidate.left_out_K for candidate in without.candidates)
    assert better < 0.2 * worse
    assert off(loaded, winding_only, FRESH) < 0.5 * FLOOR


def test_more_runs_make_it_no_worse() -> None:
    rng = np.random.default_rng(7)
    steps = [EIGHT.run(holds((pwm, 100), (0, 30)), rng, noise=NOISE) for pwm in (70, 160, 250)]
    more = mixed(rng, EIGHT, 2)
    few = off(found_of(steps, 1)[1], EIGHT, FRESH)
    assert off(found_of([*steps, *more], 1)[1], EIGHT, FRESH) < max(1.1 * few, 0.5 * FLOOR)


def test_rest_belongs_to_the_validity_where_it_was_measured() -> None:
    rng = np.random.default_rng(8)
    turning = [TWO.run(holds((pwm, 60)), rng, noise=NOISE) for pwm in (80, 160, 250)]
    result, loaded = found_of(turning, 0)
    assert loaded.model.validity == (80, 250)
    assert any("PWM 0 was not held" in warning for warning in Summary(result).warnings())
    result, loaded = found_of([*turning, TWO.run(holds((200, 60), (0, 60)), rng, noise=NOISE)], 0)
    assert loaded.model.validity == (0, 250)
    assert not any("PWM 0" in warning for warning in Summary(result).warnings())


def test_a_ramp_of_seconds_leaves_the_steps_what_they_are() -> None:
    rng = np.random.default_rng(9)
    ramp = np.linspace(0, 200, 8).astype(np.int64)
    runs = [TWO.run(np.concatenate([ramp, holds((200, 60)), ramp[::-1], holds((0, 50))]), rng, noise=NOISE)]
    runs.append(TWO.run(holds((90, 70), (0, 30)), rng, noise=NOISE))
    _, loaded = found_of(runs, 0)
    assert off(loaded, TWO, holds((200, 30), (90, 40), (0, 30))) < FLOOR


def test_without_a_measured_room_its_level_is_estimated_and_said() -> None:
    """The room of each run is another one, and nobody says so."""
    rng = np.random.default_rng(10)
    levels = (24.4, 25.0, 25.5)
    runs = [
        TWO.run(run.pwm, rng, room, NOISE, measured=False) for run, room in zip(mixed(rng, TWO), levels, strict=True)
    ]
    result, loaded = found_of(runs, 0, ambient=25.0)
    assert loaded.model.ambient_fixed == pytest.approx(25.0)
    assert loaded.model.ambient_channel is None
    assert off(loaded, TWO, FRESH) < FLOOR
    assert any("room was not measured in 3 run(s)" in warning for warning in Summary(result).warnings())


def test_the_declared_error_holds_on_fresh_runs() -> None:
    """Means over a 60th of a run, of model minus truth, against the band of their speed."""
    _, loaded = found_of(mixed(np.random.default_rng(11), EIGHT), 1)
    provenance = loaded.document.provenance
    assert provenance is not None
    time = 4.0 * np.arange(FRESH.size, dtype=np.float64)
    start = dict.fromkeys(EIGHT.sensed, ROOM)
    shown = NetworkSolution(loaded.model).simulate_times(time, FRESH, np.full(FRESH.size, ROOM), None, start)
    true = EIGHT.true(FRESH, np.full(FRESH.size, ROOM))
    inside = total = 0
    for name, node in EIGHT.sensed.items():
        bands = [band for band in provenance.error if band.component == name]
        assert bands[0].pwm == (0, 0)
        assert [band.pwm[0] for band in bands[2:]] == [band.pwm[1] + 1 for band in bands[1:-1]]
        for rows in np.array_split(np.arange(FRESH.size), 60):
            level = int(FRESH[rows[0]])
            band = next(b for b in bands if b.pwm[0] <= level <= b.pwm[1])
            low, high = band.model_minus_measured_K
            inside += low <= float(np.mean(shown[name][rows] - true[rows, node])) <= high
            total += 1
    assert inside >= 0.95 * total


@pytest.mark.parametrize(
    ("pwm", "hint"),
    [(holds((0, 30)), "in which the motor turns"), (holds((100, 1)), "at least 20")],
)
def test_what_cannot_be_used_is_told(pwm: IntArray, hint: str) -> None:
    run = TWO.run(pwm, np.random.default_rng(12))
    with pytest.raises(InputError, match=hint):
        make_network_data([Source("run.csv", run)], None)


def test_a_part_that_does_not_react_is_left_out_and_a_full_scale_too_small_refused() -> None:
    rng = np.random.default_rng(13)
    run = TWO.run(holds((200, 30), (0, 20)), rng)
    run.temps["stand"] = np.full(run.time_s.size, 25.0)
    data = make_network_data([Source("run.csv", run)], None)
    assert data.names == ("winding", "casing")
    assert any("stand is left out" in warning for warning in data.warnings)
    with pytest.raises(InputError, match=r"run\.csv: column pwm: found \|PWM\| 200, over the full scale of 180"):
        make_network_data([Source("run.csv", run)], None, 180)
    for name in run.temps:
        run.temps[name] = np.full(run.time_s.size, 25.0)
    with pytest.raises(InputError, match="nothing can be identified"):
        make_network_data([Source("run.csv", run)], None)


def test_no_part_is_torn_from_the_motor_where_left_out_speeds_do_not_see_it(tmp_path: Path) -> None:
    """Five steps at five speeds of the simulated motor: a left-out speed is missed by a kelvin or two anyway, and a
    casing with nothing but its own heat and its own way out, 0.6 K off in every run, is lost in that."""
    folder = tmp_path / "runs"
    folder.mkdir()
    paths = [folder / f"cold{speed}.csv" for speed in (20, 40, 60, 80, 100)]
    for number, path in enumerate(paths):
        make_run(cut_off(51 * (number + 1), 10_800.0, 3600.0), Setup(sensors=sensors(0), seed=number)).write(path)
    result = identify_network(make_network_data(read_sources(paths), None), lambda _: None)
    covered = result.found.problem.inputs.covered
    residual = result.found.fit.evaluated.residual
    rms = np.sqrt(np.sum(covered * residual**2, axis=0) / covered.sum(axis=0))
    assert np.all(rms < 0.15)
    structure = result.found.structure
    within = {structure.names[node] for path in structure.paths if -1 not in path for node in path}
    assert within == set(structure.names)
