"""Identification end to end on runs of known plants, which an independent solution made."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.identify_recovery import Trial, trial
from benchmarks.scheduled_plants import AMBIENT, Plant, fresh_profile, measured, random_plant, simulate
from gen.coefficients import Coefficients
from gen.errors import CheckFailed
from gen.identification.logs.data import make_data
from gen.identification.logs.sources import Source
from gen.identification.parts.coefficient_file import coefficient_text, usable
from gen.identification.parts.general import guard
from gen.identification.parts.identify import Identified, identify
from gen.identification.parts.page import report_html
from gen.identification.parts.summary import summary
from gen.identification.settings import Settings
from gen.model import ExactSolution
from gen.rig import Setup, make_run, sensors
from gen.rig.profiles import cut_off
from gen.runs import Run, read_run
from tests.campaign import FULL

COUNTS = np.arange(256)


def plant(order: int = 1, noise: float = 0.1, bias: float = 0.0) -> Plant:
    x = COUNTS / 255.0
    tau = np.stack([(1500.0 - 500.0 * x) / 6.0**k for k in range(order)], axis=1)
    return Plant(tau, 60.0 * x * (1.6 - x), noise, bias)


def found_of(runs: list[Run], most: int = 4) -> tuple[Identified, Coefficients]:
    data = make_data([Source(f"r{i}.csv", run) for i, run in enumerate(runs)], None)
    found = identify(data, lambda _: None, most)
    _, loaded = coefficient_text(data, found, Settings("plant"))
    return found["part"], loaded


def profile(*holds: tuple[int, int]) -> np.ndarray:
    return np.repeat([pwm for pwm, _ in holds], [seconds for _, seconds in holds]).astype(np.int64)


def free_run_error(loaded: Coefficients, of: Plant, pwm: np.ndarray) -> float:
    rise = ExactSolution(loaded.model).simulate_times(np.arange(len(pwm), dtype=np.float64), pwm)["part"]
    return float(np.sqrt(np.mean((AMBIENT + rise - simulate(of, pwm)) ** 2)))


def test_one_staircase_with_cooling_is_enough() -> None:
    """Several speeds in one run, the state carried over from each to the next."""
    of = plant(2)
    rng = np.random.default_rng(1)
    stairs = profile((60, 3600), (120, 3600), (180, 3600), (240, 3600), (0, 3600))
    item, loaded = found_of([measured(of, stairs, rng)])
    assert item.speeds == [60, 120, 180, 240]
    assert item.standstill
    assert item.fit.steady == pytest.approx(of.steady[[60, 120, 180, 240]], abs=0.15)
    fresh = profile((200, 2000), (0, 1500), (90, 3000), (240, 1000))
    assert free_run_error(loaded, of, fresh) < 0.3


def test_a_run_at_one_speed_with_its_cooling_says_where_it_holds() -> None:
    of = plant()
    rng = np.random.default_rng(2)
    pwm = profile((128, 6000), (0, 4000))
    item, loaded = found_of([measured(of, pwm, rng)])
    assert loaded.model.validity == (128, 128)
    assert [band.pwm for band in loaded.document.provenance.error] == [(0, 0), (128, 128)]  # type: ignore[union-attr]
    assert free_run_error(loaded, of, pwm) < 0.1
    assert item.linearity.linear is None


@pytest.mark.parametrize("noise", [0.0, 0.4])
def test_a_warm_start_and_an_ambient_that_moves_through_the_part(noise: float) -> None:
    """The part follows its room with its own time constant; what the room's sensor adds of its own means nothing."""
    of = plant()
    rng = np.random.default_rng(3)
    whole = profile((204, 5000), (102, 7000))
    run = measured(of, whole, rng)
    drift = 4.0 * np.sin(np.arange(len(whole)) / 2500.0)
    inside = np.zeros_like(drift)
    for k, pwm in enumerate(whole[:-1]):
        inside[k + 1] = inside[k] + (drift[k] - inside[k]) / of.tau[pwm, 0]
    later = slice(4000, None)
    room = AMBIENT + drift + rng.normal(0.0, noise, drift.size)
    warm = Run(run.time_s[later], run.pwm[later], {"part": (run.temps["part"] + inside)[later]}, room[later])
    item, loaded = found_of([warm, measured(of, profile((204, 6000)), rng)])
    assert item.fit.steady[item.speeds.index(102)] == pytest.approx(of.steady[102], abs=0.15)
    rate = -float(loaded.model.component("part").poles[0].real.exact(102))
    assert rate * of.tau[102, 0] == pytest.approx(1.0, rel=0.02)
    assert item.problem.records[0].noise_K == pytest.approx(0.1, abs=0.03)
    assert loaded.model.ambient_passes


def test_an_offset_of_the_sensor_is_found_by_cooling_and_not_learnt() -> None:
    of = plant(bias=0.9)
    rng = np.random.default_rng(4)
    item, loaded = found_of([measured(of, profile((153, 6000), (0, 5000)), rng)])
    assert item.fit.offset == pytest.approx(0.9, abs=0.05)
    assert loaded.model.component("part").steady_rise([153])[0] == pytest.approx(of.steady[153], abs=0.15)


def test_a_lagging_part_in_a_room_that_cools_is_not_taken_for_a_sensor_that_is_off() -> None:
    """Each run ends in a falling ambient, which the part follows slowly; but each begins where the ambient is."""
    of = plant()
    rng = np.random.default_rng(7)
    runs = []
    for pwm in (60, 120, 180, 240):
        run = measured(of, profile((pwm, 6000), (0, 3600)), rng)
        assert run.ambient is not None
        room = 1.2 * np.sin(2.0 * np.pi * run.time_s / 14_000.0)
        inside = np.zeros_like(room)
        for i in range(1, len(room)):
            inside[i] = inside[i - 1] + (room[i - 1] - inside[i - 1]) * (run.time_s[i] - run.time_s[i - 1]) / 2000.0
        runs.append(Run(run.time_s, run.pwm, {"part": run.temps["part"] + inside}, run.ambient + room, {}))
    item, loaded = found_of(runs)
    assert item.fit.offset == 0.0
    assert free_run_error(loaded, of, profile((180, 9000), (0, 2000))) < 1.0


def test_criteria_stand_in_the_order_of_the_speeds() -> None:
    """The report lists them without their speeds, and files come in the order of their names."""
    rng = np.random.default_rng(8)
    item, _ = found_of([measured(plant(), profile((pwm, 5000)), rng) for pwm in (120, 240, 60)], most=1)
    assert [list(by_pwm) for by_pwm in item.criteria.values()] == [[60, 120, 240]]


def test_what_no_structure_fits_is_not_taken_for_a_sensor_that_is_off(tmp_path: Path) -> None:
    """The simulated motor's bearing is no K/A(s) without zeros; its sensors are within 1.1 K."""
    runs = []
    for pwm in (51, 102, 153, 204, 255):
        path = tmp_path / f"{pwm}.csv"
        make_run(cut_off(pwm, heat_s=10_800.0, cool_s=7200.0), Setup(sensors=sensors(seed=3), seed=3)).write(path)
        run = read_run(path)
        runs.append(Run(run.time_s, run.pwm, {"part": run.temps["bearing"]}, run.ambient, {}))
    item, loaded = found_of(runs)
    assert abs(item.fit.offset) <= 2.2
    for run in runs:
        assert run.ambient is not None
        highest = np.max(run.temps["part"]) - np.median(run.ambient)
        assert loaded.model.component("part").steady_rise([run.pwm[0]])[0] == pytest.approx(highest, abs=1.5)


def test_one_linear_system_is_recognised() -> None:
    flat = Plant(np.full((256, 1), 1200.0), np.linspace(0.0, 45.0, 256, dtype=np.float64), 0.1, 0.0)
    rng = np.random.default_rng(5)
    item, loaded = found_of([measured(flat, profile((pwm, 7200)), rng) for pwm in (51, 128, 204, 255)])
    assert item.linearity.linear is True
    assert np.max(np.abs(item.linearity.averaged_K)) < 0.3
    assert free_run_error(loaded, flat, profile((90, 3000), (230, 3000))) < 0.15
    varied, _ = found_of([measured(plant(), profile((pwm, 7200)), rng) for pwm in (51, 153, 255)])
    assert varied.linearity.linear is False


def test_what_is_not_physical_is_rejected_with_its_reason() -> None:
    rng = np.random.default_rng(6)
    time = np.arange(0.0, 7200.0, 2.0)
    ringing = 40.0 * (1.0 - np.exp(-time / 900.0) * (np.cos(time / 400.0) + np.sin(time / 400.0) * 400.0 / 900.0))
    run = Run(
        time,
        np.full(len(time), 128),
        {"part": 30.0 + ringing + rng.normal(0.0, 0.05, len(time))},
        np.full(len(time), 30.0),
    )
    reasons = {c.structure.name: " ".join(c.rejected) for c in found_of([run])[0].choice.candidates}
    assert "rings" in reasons["2 (pair)"]
    cooling = Run(run.time_s, run.pwm, {"part": 30.0 - ringing * 0.5}, run.ambient)
    data = make_data([Source("run.csv", cooling)], None)
    with pytest.raises(CheckFailed, match="negative gain at PWM 128"):
        usable(data, identify(data, lambda _: None), Settings("plant"))


def test_guard_refuses_wiggles_and_a_change_of_sign() -> None:
    rng = np.random.default_rng(7)
    item, _ = found_of([measured(plant(), profile((pwm, 7200)), rng) for pwm in (51, 102, 153, 204, 255)], most=1)
    shape, vector = item.model.shape, item.model.vector
    assert guard(shape, vector, item.fit) == ""
    cubic = next(
        o for o in item.general.options if o.shape.gain.name == "log poly3" and o.shape.time.name == "log poly0"
    )
    steep = cubic.vector.copy()
    steep[-4:] = np.polyfit(np.array([51, 76, 102, 153]) / 255.0, np.log([0.3, 0.5, 0.3, 0.25]), 3)
    assert "wiggles" in guard(cubic.shape, steep, item.fit)
    numerator = next(
        o for o in item.general.options if o.shape.gain.name == "per_count poly2" and o.shape.time.name == "log poly0"
    )
    negative = numerator.vector.copy()
    negative[-3:] = [-3.0, 3.0, -0.3]
    assert guard(numerator.shape, negative, item.fit) != ""


def test_the_file_states_its_errors_over_the_whole_validity_range() -> None:
    rng = np.random.default_rng(8)
    of = plant()
    item, loaded = found_of([measured(of, profile((pwm, 7200)), rng) for pwm in (51, 128, 255)], most=1)
    assert loaded.document.provenance is not None
    bands = loaded.document.provenance.error
    covered = [pwm for band in bands for pwm in range(band.pwm[0], band.pwm[1] + 1)]
    assert covered == list(range(51, 256))
    true = of.steady[51:256] - loaded.model.component("part").steady_rise(np.arange(51, 256))
    low = np.concatenate([np.full(b.pwm[1] - b.pwm[0] + 1, b.model_minus_measured_K[0]) for b in bands])
    high = np.concatenate([np.full(b.pwm[1] - b.pwm[0] + 1, b.model_minus_measured_K[1]) for b in bands])
    assert np.mean((-true >= low - 0.1) & (-true <= high + 0.1)) > 0.9
    assert item.general.chosen.left_out is not None


def test_report_and_summary_are_complete_and_without_outside_links() -> None:
    rng = np.random.default_rng(9)
    runs = [measured(plant(2), profile((pwm, 5400), (0, 2400)), rng) for pwm in (51, 153, 255)]
    data = make_data([Source(f"<run>{i}.csv", run) for i, run in enumerate(runs)], None)
    found = identify(data, lambda _: None, 2)
    _, loaded = coefficient_text(data, found, Settings("plant"))
    html = report_html(data, found, loaded)
    assert html.count("<svg") == 5
    assert "http" not in html
    assert "<run>" not in html
    assert "&lt;run&gt;0.csv" in html
    assert "Leave one speed out" in html
    whole = summary(data, found)
    assert set(whole["components"]["part"]["speeds"]) == {"0", "51", "153", "255"}
    assert whole["next_speed"]["pwm"] not in (51, 153, 255)
    for pwm, speed in whole["components"]["part"]["speeds"].items():
        if pwm != "0":  # a transfer function settles at numerator / last coefficient, for each count
            settled = speed["numerator"] / speed["denominator"][-1] * int(pwm)
            assert settled == pytest.approx(speed["steady_rise_K"]["value"])


def test_a_speed_that_did_not_settle_is_warned_of_with_its_own_uncertainty() -> None:
    rng = np.random.default_rng(10)
    runs = [measured(plant(), profile((pwm, seconds)), rng) for pwm, seconds in ((80, 6000), (160, 2400), (255, 1800))]
    data = make_data([Source(f"r{i}.csv", run) for i, run in enumerate(runs)], None)
    whole = summary(data, identify(data, lambda _: None, 1))
    found = re.findall(r"part at PWM (\d+): .* known to ±(\S+) K", "\n".join(whole["warnings"]))
    assert [pwm for pwm, _ in found] == ["160", "255"]
    for pwm, told in found:
        low, high = whole["components"]["part"]["speeds"][pwm]["steady_rise_K"]["interval"]
        assert float(told) == pytest.approx((high - low) / 2.0, rel=0.05)  # two digits of it are told


@pytest.mark.campaign
def test_recovery_campaign() -> None:
    trials: list[Trial] = [trial(seed) for seed in range(200 if FULL else 4)]
    ratio = np.array([t.known_K / t.floor_K for t in trials])
    assert np.median(ratio) < 0.3
    assert np.percentile(ratio, 95) < 1.0
    assert np.mean([t.order == t.found for t in trials]) >= (0.9 if FULL else 0.8)
    hits = [hit for t in trials for of in t.inside.values() for hit in of]
    # Four plants give some 60 intervals; nominal 95 %.
    assert (0.90 if FULL else 0.85) <= np.mean(hits) <= (0.98 if FULL else 1.0)


def test_plants_are_what_they_say(tmp_path: Path) -> None:
    """The campaign's oracle itself: it settles where its schedule says."""
    of = random_plant(np.random.default_rng(11))
    assert simulate(of, np.full(40000, 153))[-1] - AMBIENT == pytest.approx(of.steady[153], rel=1e-3)
    assert fresh_profile(np.random.default_rng(1), known=True).shape == (10800,)
