"""What `gen identify` calls good: the same network, as if data left out had been missed by so much."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.network.identify import NetworkFound, identify_network
from gen.identification.network.telling.summary import Summary
from tests.identification.network.plant import TWO, holds

MIXED = (holds((200, 120), (0, 120)), holds((120, 120), (200, 120)), holds((250, 120), (120, 120)))
STEPS = tuple(holds((pwm, 120), (0, 120)) for pwm in (80, 160, 250))
TURNING = tuple(holds((pwm, 120), (other, 120)) for pwm, other in ((80, 160), (160, 250), (250, 80)))


def found_from(profiles: tuple[NDArray[np.int64], ...], noise: float = 0.05) -> NetworkFound:
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
    assert not any("misses data" in warning for warning in said.warnings())
    assert 0.02 < said.noise_K[0] < 0.2


def test_kelvins_where_the_sensor_shows_tenths_are_fair_and_said_with_their_share(mixed: NetworkFound) -> None:
    said = missing(mixed, 2.4)
    assert said.verdict.startswith("Fair: on data that took no part in the fit it misses casing by 2.4 K (")
    assert "% of what it moves by" in said.verdict
    assert "times its sensor's scatter" in said.verdict
    assert any(warning.startswith("casing: the network misses data") for warning in said.warnings())


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
    profiles: tuple[NDArray[np.int64], ...], speeds: list[int]
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
