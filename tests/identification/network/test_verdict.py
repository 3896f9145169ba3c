"""What `gen identify` calls good: the same network, as if data left out had been missed by so much."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.arrays import IntArray
from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.network.identify import NetworkFound, identify_network
from gen.identification.network.telling.declared import error_bands
from gen.identification.network.telling.document import turned_range
from gen.identification.network.telling.summary import Summary
from gen.identification.network.telling.text import text
from tests.identification.network.plant import TWO, holds

MIXED = (holds((200, 120), (0, 120)), holds((120, 120), (200, 120)), holds((250, 120), (120, 120)))
STEPS = tuple(holds((pwm, 120), (0, 120)) for pwm in (80, 160, 250))
TURNING = tuple(holds((pwm, 120), (other, 120)) for pwm, other in ((80, 160), (160, 250), (250, 80)))


def found_from(profiles: tuple[IntArray, ...], noise: float = 0.05) -> NetworkFound:
    rng = np.random.default_rng(1)
    sources = [Source(f"run_{k}.csv", TWO.run(pwm, rng, noise=noise)) for k, pwm in enumerate(profiles)]
    return identify_network(make_network_data(sources, None), lambda _: None, 0)


@pytest.fixture(scope="module")
def mixed() -> NetworkFound:
    return found_from(MIXED)


def missing(found: NetworkFound, casing_K: float) -> Summary:
    """The same, had each fold missed the casing by so much."""
    by_fold = found.judged.by_fold.copy()
    by_fold[:, found.data.names.index("casing")] = casing_K**2
    return Summary(replace(found, judged=replace(found.judged, by_fold=by_fold)))


def test_what_is_predicted_to_about_the_noise_is_good(mixed: NetworkFound) -> None:
    said = Summary(mixed)
    assert said.verdict.startswith("Good: runs that took no part in the fit are predicted")
    assert not any("the network misses it" in warning for warning in said.warnings())
    assert 0.02 < said.noise_K[0] < 0.2


def test_kelvins_where_the_sensor_shows_tenths_are_fair_and_said_with_their_share(mixed: NetworkFound) -> None:
    said = missing(mixed, 2.4)
    assert said.verdict.startswith("Fair: on data that took no part in the fit it misses casing by 2.4 K (")
    assert "% of what it moves by" in said.verdict
    assert "times its sensor's scatter" in said.verdict
    assert any(warning.startswith("casing: on data that took no part in the fit") for warning in said.warnings())


def test_more_than_limits_bear_is_not_good(mixed: NetworkFound) -> None:
    assert missing(mixed, 6.0).verdict.startswith("Not good yet: on data that took no part in the fit it misses casing")


def test_where_each_run_has_its_own_speed_the_measured_speeds_are_good_and_others_are_told() -> None:
    """What is left out of such runs is a whole speed; the network knows it in the end."""
    verdict = missing(found_from(STEPS), 2.4).verdict
    assert verdict.startswith("Good at the measured speeds. Speeds that were left out it misses: casing by 2.4 K (")


def test_what_was_not_measured_stays_said_beside_the_grade() -> None:
    found = found_from(TURNING)
    assert Summary(found).verdict.startswith("Good while the motor turns; cooling at rest was not measured.")
    assert missing(found, 2.4).verdict.startswith("Fair while the motor turns; cooling at rest was not measured. On ")


@pytest.mark.parametrize(
    ("profiles", "speeds"),
    [
        ((holds((200, 120), (0, 120)), holds((100, 120), (0, 120))), [100, 200]),
        ((holds((60, 5), (120, 5), (200, 120), (0, 120)),), [200]),
        ((holds((200, 120), (-203, 120), (0, 60)),), [200]),
        ((holds((80, 120), (160, 120), (250, 120), (0, 60)),), []),
    ],
)
def test_a_motor_that_was_held_at_two_speeds_is_known_at_these_alone(
    profiles: tuple[IntArray, ...], speeds: list[int]
) -> None:
    said = Summary(found_from(profiles))
    assert said.only_speeds == pytest.approx(speeds, abs=2)
    named = f"PWM {' and '.join(map(str, said.only_speeds))}"
    assert said.verdict.startswith(f"Good at {named} ") == bool(speeds)
    assert any(f"it was held at {named}: how it warms at other speeds" in w for w in said.warnings()) == bool(speeds)


def test_of_a_heater_one_level_tells_the_others() -> None:
    rng = np.random.default_rng(1)
    run = TWO.run(holds((200, 120), (0, 120)), rng, noise=0.05)
    data = make_network_data([Source("run.csv", run)], None, machine="heater")
    assert Summary(identify_network(data, lambda _: None, 0)).only_speeds == []


def test_what_only_the_file_s_starts_and_room_miss_is_not_called_left_out(mixed: NetworkFound) -> None:
    """Each run may be followed well from a start of its own, and be missed by who has the file alone."""
    off = mixed.found.fit.evaluated.residual + np.where(mixed.found.problem.inputs.covered > 0.0, 7.0, 0.0)
    made = replace(mixed)
    made.__dict__["residual"] = off
    said = Summary(made)
    assert said.verdict.startswith(
        "Not good yet: in the runs themselves, with the starts and the room that the file has"
    )
    assert not any("took no part" in warning for warning in said.warnings())


def test_of_one_run_it_is_said_that_stretches_of_it_tell_of_no_other_and_more_is_declared() -> None:
    profile = holds((200, 60), (0, 60), (120, 60), (250, 60), (0, 60))
    one, two = found_from((profile,)), found_from((profile, profile[::-1].copy()))
    assert "tretches" in Summary(one).verdict
    assert sum("all of it is one run" in warning for warning in Summary(one).warnings()) == 1
    assert not any("all of it is one run" in warning for warning in Summary(two).warnings())
    bands = error_bands(one, Summary(one).spread, turned_range(one))
    assert all("another run than the one that there is" in band.note for band in bands)
    moved = Summary(one).moved_K
    for band in bands:
        low, high = band.model_minus_measured_K
        least = 2.0 * np.hypot(0.2, 0.01 * 0.9 * moved[one.data.names.index(band.component)])
        assert -low > least
        assert high > least


def test_of_one_run_it_is_said_how_well_its_second_half_was_foretold() -> None:
    """A fan that is switched on half-way, of which no stretch that takes part in the fit lets the others know."""
    run = TWO.run(
        holds((200, 60), (120, 60), (0, 60), (200, 60), (120, 60), (0, 60)), np.random.default_rng(1), noise=0.05
    )
    late = run.time_s >= 0.5 * run.time_s[-1]
    gone = {
        name: np.where(late, values - 0.1 * (values - run.temps[name][0]), values) for name, values in run.temps.items()
    }
    told = [
        Summary(identify_network(make_network_data([Source("run.csv", one)], None), lambda _: None, 0))
        for one in (run, replace(run, temps=gone))
    ]
    assert all(
        "the second half of the run from its first alone to" in one.verdict for one in told if "Good" in one.verdict
    )
    same, other = (one.later_K for one in told)
    assert same is not None
    assert other is not None
    assert np.all(same < 0.5)
    assert np.all(other > 1.0)
    assert Summary(found_from(MIXED)).later_K is None


def test_what_the_runs_leave_open_on_other_profiles_is_said() -> None:
    """Half an hour at one speed says little of an hour at others; three hours at several say enough."""
    short = Summary(found_from((holds((60, 5), (255, 20), (0, 20)),)))
    most = max(
        abs(end)
        for band in error_bands(short.result, short.spread, turned_range(short.result))
        for end in band.model_minus_measured_K
    )
    assert most > 5.0
    assert any(f"the file declares errors of up to {most:.0f} K (" in warning for warning in short.warnings())


def test_a_fan_that_was_logged_and_not_used_is_said_with_what_tells_whether_it_cools() -> None:
    run = TWO.run(holds((200, 60), (0, 60)), np.random.default_rng(1), noise=0.05)
    on = (run.time_s % 600.0 < 300.0).astype(np.float64)
    run = replace(run, extras={**run.extras, "Fan": on, "fanfare": on, "cooling_pump": 0.0 * on})
    found = identify_network(make_network_data([Source("run.csv", run)], None), lambda _: None, 0)
    assert "not used: Fan; whether that cools the motor, gen refine with these runs tells" in text(Summary(found))
