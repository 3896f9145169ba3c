"""The alarm rules, held against what the coefficient file says in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.lowering.alarms import LoweredRule, Segment
from gen.lowering.heat import BINS, FINE_BITS, RATE_BITS, HeatTerm, LoweredHeat
from gen.reference.alarms import ReferenceAlarms

RULE = LoweredRule(
    name="rule",
    description="",
    quantity="above",
    component=0,
    relative_to=None,
    segments=(Segment(77, 178, 5000, 4000),),
    settle=3,
    start_wait=0,
    persistence=2,
    requires=None,
    unless=None,
    sum_limit=None,
)
EAGER = replace(RULE, settle=0, persistence=0)
MODEL = 40_000


class Bench:
    """One lane with one component whose model stays at 40 degC."""

    def __init__(self, *rules: LoweredRule, trusted: bool = True) -> None:
        self.alarms = ReferenceAlarms(rules, np.array([trusted]))

    def step(
        self, deviation_mK: int, pwm: int = 100, *, valid: bool = True, plausible: bool = False
    ) -> tuple[int, int, int]:
        one = np.array([pwm]), np.array([[MODEL + deviation_mK]]), np.array([[MODEL]]), np.array([int(valid)])
        self.alarms.step(*one, np.array([int(plausible)]))
        return int(self.alarms.latched[0]), int(self.alarms.active[0]), int(self.alarms.asleep[0])

    def run(self, deviations: list[int], pwm: int = 100) -> list[int]:
        return [self.step(value, pwm)[1] for value in deviations]


def test_a_condition_must_exceed_its_threshold_and_then_ends_at_the_clear_level() -> None:
    assert Bench(EAGER).run([5000, 5001, 4001, 4000, 4001, 5000, 5001]) == [0, 1, 1, 0, 0, 0, 1]


LIMIT = replace(
    EAGER, quantity="measured", segments=(Segment(0, 255, 120_000, 115_000),), persistence=4, looks_ahead=True
)


def sooner(rule: LoweredRule, measured_mC: list[int], rising_mK: int = 0) -> int | None:
    """The sample at which a limit's alarm is raised."""
    alarms = ReferenceAlarms([rule], np.array([True]))
    for number, value in enumerate(measured_mC):
        one = np.array([100]), np.array([[value]]), np.array([[0]]), np.array([1])
        alarms.step(*one, rising_mK=np.array([[rising_mK]]))
        if alarms.latched[0]:
            return number
    return None


def test_each_kelvin_over_a_limit_that_looks_ahead_shortens_its_persistence() -> None:
    for beyond_K, samples in ((0.25, 5), (0.75, 5), (1.0, 3), (2.0, 2), (3.75, 2), (4.0, 1), (90.0, 1)):
        over = [120_000 + round(1000.0 * beyond_K)] * 6
        assert sooner(LIMIT, over) == samples - 1, beyond_K
        assert sooner(replace(LIMIT, looks_ahead=False), over) == 4


def test_what_rises_counts_as_what_it_will_be_four_readings_later() -> None:
    """2 K in two readings beyond noise: 4 K in the next four."""
    assert sooner(LIMIT, [116_000] * 6, 2000) is None
    assert sooner(LIMIT, [116_250] * 6, 2000) == 4
    assert sooner(LIMIT, [118_000] * 6, 2000) == 1  # 2 K over: three samples of five each
    assert sooner(replace(LIMIT, looks_ahead=False), [120_000] * 6, 60_000) is None


def test_between_clear_and_limit_a_sample_counts_once() -> None:
    assert sooner(LIMIT, [120_250, 116_000, 116_000, 116_000, 116_000]) == 4


def test_a_limit_of_a_temperature_heeds_what_is_plausible_and_rules_on_the_model_do_not() -> None:
    limit = replace(EAGER, quantity="measured", segments=(Segment(0, 255, 120_000, 118_000),))
    bench = Bench(limit, EAGER)
    assert bench.step(85_000, valid=False) == (0, 0, 0)
    assert bench.step(85_000, valid=False, plausible=True) == (0b01, 0b01, 0)
    assert bench.step(0, valid=False, plausible=True) == (0b01, 0, 0)
    assert bench.step(85_000, valid=True) == (0b11, 0b11, 0)


def test_a_rule_settles_then_persists_then_latches() -> None:
    bench = Bench(RULE)
    assert bench.run([9000] * 7) == [
        0,
        0,
        0,
        0,
        0,
        1,
        1,
    ]  # 3 samples of settling; at 0.25 s two samples later it has held
    assert bench.step(0) == (1, 0, 0)  # the condition is over, the alarm stays


def test_a_dip_starts_the_persistence_anew() -> None:
    bench = Bench(replace(RULE, settle=0))
    assert bench.run([9000, 9000, 0, 9000, 9000, 9000]) == [0, 0, 0, 0, 0, 1]


def test_leaving_the_speed_range_puts_the_rule_to_sleep_until_it_has_settled_again() -> None:
    bench = Bench(RULE)
    bench.run([9000] * 6)
    assert bench.step(9000, pwm=179) == (1, 0, 1)
    assert bench.run([9000] * 6) == [0, 0, 0, 0, 0, 1]
    for pwm, asleep in ((77, 0), (178, 0), (-100, 0), (76, 1), (-179, 1), (-32768, 1)):
        assert Bench(EAGER).step(0, pwm)[2] == asleep


def test_the_direction_of_rotation_does_not_matter() -> None:
    bench = Bench(RULE)
    assert [bench.step(9000, pwm)[1] for pwm in (100, -100, 120, -77, 178, 100)] == [0, 0, 0, 0, 0, 1]


def test_missing_samples_leave_a_rule_as_it_is() -> None:
    bench = Bench(replace(RULE, settle=0))
    bench.run([9000, 9000])
    for _ in range(50):
        assert bench.step(-500_000, valid=False) == (0, 0, 0)
    assert bench.step(9000) == (1, 1, 0)
    assert bench.step(-500_000, valid=False) == (1, 1, 0)


def test_an_over_temperature_needs_no_model() -> None:
    rule = replace(EAGER, quantity="measured", segments=(Segment(0, 255, 80_000, 78_000),))
    assert Bench(rule, trusted=False).run([40_000, 40_001, 38_001, 38_000], pwm=0) == [0, 1, 1, 0]


def test_below_mirrors_above() -> None:
    deviations = [0, 5001, -5001, 4500, -4500, -3999, 12_000]
    below = Bench(replace(EAGER, quantity="below")).run(deviations)
    assert below == Bench(EAGER).run([-value for value in deviations])


def test_an_untrusted_start_waits_within_the_speed_range() -> None:
    bench = Bench(replace(EAGER, start_wait=3), trusted=False)
    assert [bench.step(9000, pwm)[2] for pwm in (100, 0, 100, 0, 0, 100, 100)] == [1, 1, 1, 1, 1, 1, 0]
    assert Bench(replace(EAGER, start_wait=3)).step(9000)[1] == 1


def test_a_rule_that_requires_another_wakes_when_that_alarm_is_raised() -> None:
    second = replace(EAGER, name="second", quantity="below", requires=0, segments=(Segment(0, 255, 1000, 1000),))
    bench = Bench(EAGER, second)
    assert bench.step(-2000) == (0, 0, 2)
    assert bench.step(9000) == (1, 1, 0)
    assert bench.step(-2000) == (3, 2, 0)


def test_a_reset_forgets_alarms_and_sums_and_asks_for_persistence_again() -> None:
    bench = Bench(replace(RULE, settle=0), replace(EAGER, name="sum", sum_limit=8000))
    bench.run([9000] * 3)
    assert bench.alarms.latched[0] == 3
    bench.alarms.reset(np.array([True]))
    assert bench.step(9000) == (0, 0, 0)
    assert bench.run([9000, 9000]) == [2, 3]  # the sum is full after two samples, the persistence over after three


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(-20_000, 20_000), min_size=1, max_size=60), st.integers(1, 50_000))
def test_a_sum_is_the_textbook_cusum(deviations: list[int], limit: int) -> None:
    rule = replace(EAGER, sum_limit=limit, segments=(Segment(0, 255, 2000, 2000),))
    bench = Bench(rule)
    total, expected = 0, []
    for value in deviations:
        total = min(limit, max(0, total + value - 2000))
        expected.append(int(total >= limit))
    assert bench.run(deviations) == expected


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_lanes_do_not_touch_each_other(data: st.DataObject) -> None:
    rules = (
        RULE,
        replace(EAGER, name="sum", sum_limit=7000, segments=(Segment(0, 99, 500, 500), Segment(100, 255, 900, 900))),
    )
    steps = data.draw(
        st.lists(
            st.tuples(*[st.tuples(st.integers(-12_000, 12_000), st.integers(-255, 255), st.booleans())] * 3),
            max_size=40,
        )
    )
    together = ReferenceAlarms(rules, np.array([True, False, True]))
    alone = [Bench(*rules, trusted=trusted) for trusted in (True, False, True)]
    for step in steps:
        measured = np.array([[MODEL + lane[0] for lane in step]])
        together.step(
            np.array([lane[1] for lane in step]),
            measured,
            np.full((1, 3), MODEL),
            np.array([int(lane[2]) for lane in step]),
        )
        for bench, (deviation, pwm, valid) in zip(alone, step, strict=True):
            bench.step(deviation, pwm, valid=valid)
        assert together.record().tolist() == [bench.alarms.record()[0].item() for bench in alone]


def test_a_rule_with_an_excluding_alarm_sleeps_once_that_is_raised() -> None:
    first = replace(EAGER, quantity="below")
    second = replace(EAGER, name="second", unless=0)
    bench = Bench(first, second)
    assert [bench.step(value)[0] for value in (0, 9000, -9000, 9000)] == [0, 2, 3, 3]
    assert bench.step(9000)[2] == 2
    bench.alarms.reset(np.array([True]))
    assert bench.step(9000)[0] == 2


HEARD = LoweredHeat(
    block=2,
    low=0,
    high=255,
    terms=(HeatTerm(0, 256, (1,) * BINS),),
    slack=100,
    unknown=0,
    change=0,
    start=1000 << FINE_BITS,
    fading=(1 << (RATE_BITS - 1),) * BINS,  # half of it in a block: 1000 is below 50 after five
    memory=40,
    forgetting=1 << RATE_BITS,
    limit=1 << 20,
)


@pytest.mark.parametrize(
    ("hot_from", "latched"),
    [(3, 2), (9, 2), (10, 2 + 4), (11, 2 + 4), (30, 2 + 4)],
    ids=["right after the start", "just before it is settled", "as it is", "after it", "long after"],
)
def test_a_sum_that_heard_nothing_says_no_only_if_it_was_settled_when_the_required_alarm_came(
    hot_from: int, latched: int
) -> None:
    """It is settled from the tenth sample on, after five blocks; what it learns of later is a faulty motor."""
    silent = replace(EAGER, name="silent", quantity="heat", heat=HEARD)
    hot = replace(EAGER, name="hot")
    other = replace(EAGER, name="other", requires=1, unless=0)
    bench = Bench(silent, hot, other, trusted=False)
    found = [bench.step(9000 if sample >= hot_from else 0)[0] for sample in range(60)]
    assert found[-1] == latched
    bench.alarms.reset(np.array([True]))
    assert bench.step(0)[0] == 0
    assert bench.step(9000)[0] == 2 + 4, "by now it is settled"


def test_a_cold_start_is_settled() -> None:
    silent = replace(EAGER, name="silent", quantity="heat", heat=HEARD)
    rules = silent, replace(EAGER, name="hot"), replace(EAGER, name="other", requires=1, unless=0)
    for trusted, latched in ((True, 2 + 4), (False, 2)):
        bench = Bench(*rules, trusted=trusted)
        bench.step(0)
        assert bench.step(9000)[0] == latched


def test_without_a_required_alarm_it_says_no_whenever_it_is_settled() -> None:
    silent = replace(EAGER, name="silent", quantity="heat", heat=HEARD)
    bench = Bench(silent, replace(EAGER, name="other", unless=0), trusted=False)
    found = [bench.step(9000)[0] for _ in range(12)]
    assert found == [0] * 9 + [2] * 3


def test_a_relative_rule_sees_only_what_the_other_part_does_not_share() -> None:
    rule = replace(EAGER, relative_to=1)
    alarms = ReferenceAlarms([rule], np.array([True]))

    def active(own_mK: int, other_mK: int, valid: int = 3) -> int:
        model = np.array([[40_000], [50_000]])
        alarms.step(np.array([100]), model + np.array([[own_mK], [other_mK]]), model, np.array([valid]))
        return int(alarms.active[0])

    assert active(9000, 9000) == 0
    assert active(5000, -1) == 1
    assert active(9000, 9000, valid=1) == 1  # without the other's sample it stays as it is
    assert active(9000, 5000) == 0
