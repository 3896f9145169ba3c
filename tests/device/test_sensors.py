"""The sensor checks: what they promise, and that the board's C++ and the reference agree word for word."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.lowering.sensors import (
    CONFIRMATIONS,
    FASTER,
    NOISE_COUNTS,
    PLAUSIBLE_SAMPLES,
    reading_samples,
    sensor_limits,
)
from gen.reference.sensors import SensorCheck, SensorCode
from tests.device.sensor_harness import ACCEPT, FORGET, KEEP, LIMITS, MODEL_SET, RESTORE, Cpp, Step, by_reference, word
from tests.examples import example


@pytest.fixture(scope="module")
def cpp(tmp_path_factory: pytest.TempPathFactory) -> Cpp:
    return Cpp(tmp_path_factory.mktemp("sensors"))


def random_steps(seed: int, count: int) -> list[Step]:
    """Words that wander, stand still, jump and break, so that every code comes up often."""
    generator = np.random.default_rng(seed)
    level, model = 200, 50_000
    steps: list[Step] = []
    while len(steps) < count:
        kind = generator.integers(0, 40)
        length = int(generator.integers(1, 25))
        if kind == 0:
            other = int(generator.integers(1, 5)) if generator.random() < 0.2 else 0
            calls = [FORGET, MODEL_SET, ACCEPT, ACCEPT, KEEP, RESTORE]
            steps.append((int(generator.choice(calls)), other, False, 0))
        elif kind == 1:  # as fast as a locked motor, or nearly
            rate = int(generator.integers(4, 30))
            for _ in range(length % 12):
                level = int(np.clip(level + rate + generator.integers(-2, 3), 0, 1200))
                steps.append((0, word(level), True, model))
        elif kind < 10:
            steps += [
                (0, int(w), True, model) for w in generator.choice([0, 1, 4, 0xFFFF, 0x8000, 2, 0x7FFF], length % 4)
            ]
        elif kind < 14:
            steps += [(0, word(level), False, model)] * (length % 6)
        elif kind < 24:
            for _ in range(length):
                model += int(generator.integers(-400, 400)) * int(generator.integers(0, 8))
                steps.append((0, word(level), True, model))
        elif kind < 28:
            level = int(np.clip(level + generator.integers(-60, 60), 0, 1200))
        else:
            for _ in range(length):
                level = int(np.clip(level + generator.integers(-5, 6), 0, 1200))
                steps.append((0, word(level + int(generator.integers(-3, 4)) & 0xFFF), True, model))
    return [(int(generator.integers(0, 5)) if step[0] == 0 and seed % 2 else step[0], *step[1:]) for step in steps]


@pytest.mark.parametrize("seed", range(6))
def test_the_boards_checks_equal_the_reference(cpp: Cpp, seed: int) -> None:
    steps = random_steps(seed, 20_000)
    found = cpp.run(steps)
    assert found == by_reference(cpp.limits, steps)
    assert {code for code, *_ in found} == set(range(9))
    assert {(code, plausible) for code, _, plausible, *_ in found} >= {
        (4, 0),
        (4, 1),
        (5, 0),
        (5, 1),
        (8, 0),
        (8, 1),
        (0, 1),
    }


def test_the_emulated_boards_checks_equal_the_reference(cpp: Cpp) -> None:
    steps = random_steps(7, 10_000)
    found, cycles = cpp.run_on_board(steps)
    assert found == by_reference(cpp.limits, steps)
    print(f"\na check takes at most {cycles} cycles")
    assert cycles < 2000


words = st.one_of(st.integers(0, 0xFFFF), st.integers(180, 220).map(word))


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 4), words, st.booleans(), st.integers(-(2**31), 2**31 - 1)), max_size=80))
def test_the_boards_checks_equal_the_reference_on_anything(cpp: Cpp, steps: list[Step]) -> None:
    steps = [(*step[:3], max(min(step[3], 10**9), -(10**9))) for step in steps]
    assert cpp.run(steps) == by_reference(cpp.limits, steps)


def codes(check: SensorCheck, counts: Sequence[int], model_mC: int = 0) -> list[int]:
    return [int(check.check(word(item), True, model_mC)) for item in counts]


def believed(at: int) -> SensorCheck:
    check = SensorCheck(LIMITS)
    assert codes(check, [at] * CONFIRMATIONS) == [8] * (CONFIRMATIONS - 1) + [0]
    return check


@given(st.lists(st.integers(1, 0xFFFF), min_size=1, max_size=60), st.integers(100, 900))
def test_no_sample_is_believed_that_physics_could_not_reach(given_words: list[int], start: int) -> None:
    """Whatever comes: between two believed samples the rate is kept, and each agrees with the three before it.

    Or all four belong to one rise that a failing part could make, and that does not stop.
    """
    check = believed(start)
    last, since = start, 0
    run: list[int] = [start] * CONFIRMATIONS
    for given_word in given_words:
        since += 1
        code = check.check(given_word, True, 0)
        run.append(given_word >> 3)
        if code is SensorCode.OK:
            counts = given_word >> 3
            steps = [after - before for before, after in pairwise(run[-CONFIRMATIONS:])]
            if max(map(abs, [counts - last, *steps])) > NOISE_COUNTS + LIMITS.step:
                assert last in run[-CONFIRMATIONS:]
                assert 2 * max(steps) <= sum(steps) + NOISE_COUNTS
                assert max(map(abs, steps)) <= NOISE_COUNTS + FASTER * LIMITS.step
            else:
                assert abs(counts - last) <= NOISE_COUNTS + LIMITS.step * since
            assert not given_word & 0x8006
            assert LIMITS.lowest <= counts <= LIMITS.highest
            last, since = counts, 0
        assert check.temperature_mC == last * 250


@given(st.integers(0, 4095), st.integers(1, CONFIRMATIONS - 1))
def test_a_spike_is_never_believed(level: int, length: int) -> None:
    """Shorter than the confirmation, whatever its height."""
    check = believed(400)
    found = codes(check, [level] * length + [400] * 8)
    if abs(level - 400) > NOISE_COUNTS + LIMITS.step:
        assert 0 not in found[:length]
    assert check.temperature_mC == 100_000
    assert found[-1] == 0


@pytest.mark.parametrize("by", [10, 20, 80, -80])
def test_a_jump_that_stays_is_not_believed_until_somebody_has_looked(by: int) -> None:
    limits = replace(LIMITS, stuck_samples=0)
    check = SensorCheck(limits)
    codes(check, [400] * CONFIRMATIONS)
    hours = codes(check, [400 + by + k % 2 for k in range(3 * 3600 * 4)])
    assert set(hours) == {5}
    assert check.temperature_mC == 100_000
    check.accept()
    assert codes(check, [400 + by] * CONFIRMATIONS) == [8] * (CONFIRMATIONS - 1) + [0]


@pytest.mark.parametrize("moved_K", [0.0, 25.0, -25.0])
def test_a_sensor_that_comes_back_is_believed_where_the_model_went_meanwhile(moved_K: float) -> None:
    limits = replace(LIMITS, stuck_samples=0)
    check = SensorCheck(limits)
    codes(check, [400] * CONFIRMATIONS)
    model = [round(1000 * moved_K * min(k, 2000) / 2000) for k in range(2400)]
    away = [check.check(word(480 + k % 3), True, item) for k, item in enumerate(model)]
    # A jump of 20 K with a model that goes up by 25 K meets it on its way: for so long it cannot be told.
    met = [k for k, code in enumerate(away) if code == SensorCode.OK]
    assert met == [] or moved_K == 25.0
    check = SensorCheck(limits)
    codes(check, [400] * CONFIRMATIONS)
    for item in model:
        check.check(word(600), True, item)
    back = 400 + round(4 * moved_K)
    assert [int(check.check(word(back), True, model[-1])) for _ in range(6)][-2:] == [0, 0]


@pytest.mark.parametrize("rate_K_per_s", [6.0, 8.0, 12.0, 20.0])
def test_a_locked_motors_rise_is_believed_on_its_way_and_plausible_all_along(rate_K_per_s: float) -> None:
    """With the scatter that users of the chip report; the model, which knows of no lock, stays where it is."""
    noise = np.random.default_rng(3)
    counts = [240 + round(rate_K_per_s * k + noise.normal(0.0, 0.8)) for k in range(36)]
    check = believed(240)
    found = [(int(check.check(word(item), True, 60_000)), check.plausible, check.plausible_mC) for item in counts]
    assert all(plausible and value == 250 * item for (_, plausible, value), item in zip(found, counts, strict=True))
    refused = [len(list(same)) for jump, same in groupby(found, key=lambda item: item[0] == 5) if jump]
    assert max(refused, default=0) < CONFIRMATIONS
    assert {code for code, *_ in found[-5:]} == {0}


@pytest.mark.parametrize("rate_K_per_s", [8.0, 12.0, 20.0])
def test_a_sensor_that_comes_off_is_not_believed_and_says_no_harm(rate_K_per_s: float) -> None:
    """It cools towards the room at its own rate, faster than a motor ever does."""
    check = believed(400)
    found = codes(check, [round(max(128, 400 - rate_K_per_s * 1.5 * k)) for k in range(1, 400)])
    assert set(found[:20]) == {5} or found[0] == 0
    assert check.temperature_mC >= 95_000
    check.accept()
    assert codes(check, [128] * CONFIRMATIONS)[-1] == 0


def test_above_the_range_a_sample_is_not_believed_but_plausible_from_the_third_on() -> None:
    """A brush at 260 degC at the start, where nothing above 250 degC is believed, has to stop the motor."""
    check = SensorCheck(LIMITS)
    found = [(int(check.check(word(1040), True, 0)), check.plausible) for _ in range(6)]
    assert found == [(4, False), (4, False), (4, True), (4, True), (4, True), (4, True)]
    assert check.plausible_mC == 260_000


@given(st.integers(0, 4095), st.integers(1, PLAUSIBLE_SAMPLES - 1))
def test_a_short_spike_is_not_plausible(level: int, length: int) -> None:
    check = believed(400)
    for given_word in [level] * length:
        check.check(word(given_word), True, 0)
        if abs(level - 400) > NOISE_COUNTS + FASTER * LIMITS.step:
            assert not check.plausible


def test_what_says_nothing_is_not_plausible() -> None:
    check = believed(400)
    for given_word, finished in ((0x0004, True), (0, True), (0xFFFF, True), (word(400), False)):
        check.check(given_word, finished, 0)
        assert not check.plausible
    check = believed(400)
    frozen = [int(check.check(word(400), True, 1000 * k)) for k in range(20)]
    assert frozen[-1] == 6
    assert not check.plausible


def test_after_an_open_wire_the_level_may_be_another() -> None:
    """Nobody has seen a jump: what the part did meanwhile is bound by its rate alone."""
    check = believed(400)
    for _ in range(40):
        assert check.check(0x0004 | word(400), True, 0) is SensorCode.OPEN
    assert codes(check, [480] * 6) == [8, 8, 8, 0, 0, 0]


def test_noise_is_believed_and_a_ramp_at_the_rate_too() -> None:
    check = believed(400)
    assert set(codes(check, [400, 404, 400, 396, 400, 398] * 5)) == {0}
    assert set(codes(check, range(400, 900, LIMITS.step))) == {0}


def test_a_settled_motor_is_not_stuck() -> None:
    """An hour at the same count, with a model that stands still, or nearly."""
    limits = sensor_limits(example("my1016"))[0]
    check = SensorCheck(limits)
    hour = [int(check.check(word(240), True, 60_000 + i // 6)) for i in range(14_400)]
    assert set(hour[CONFIRMATIONS:]) == {0}


def test_a_frozen_sensor_is_stuck_once_the_model_has_moved_and_recovers() -> None:
    limits = sensor_limits(example("my1016"))[0]
    check = SensorCheck(limits)
    # After a step of PWM the model moves by 0.01 K a sample: by more than 3 K after 75 s.
    found = [int(check.check(word(240), True, 60_000 + 10 * i)) for i in range(2400)]
    first = found.index(6)
    assert first == 75 / 0.25 + 1
    assert set(found[first:]) == {6}
    recovered = codes(check, [290, 291, 290, 291, 290, 290])
    assert recovered[-1] == 0
    assert 0 not in recovered[: CONFIRMATIONS - 1]


def test_unfinished_conversions_are_not_used_and_break_no_confidence() -> None:
    check = believed(400)
    assert check.check(word(402), False, 0) is SensorCode.EARLY
    assert check.temperature_mC == 100_000
    assert codes(check, [402]) == [0]


def test_limits_come_from_the_file_or_the_domain() -> None:
    tree = json.loads(json.dumps(example("my1016").document.model_dump(mode="json", exclude_none=True)))
    assert tree["wiring"]["thermocouples"][0]["max_rate_K_per_s"] == 5.0
    brush, *_, ambient = sensor_limits(example("my1016"))
    assert (brush.lowest, brush.highest) == (0, 250 * 4)  # the domain ends at 150 degC; the chip knows no negative ones
    assert (ambient.lowest, ambient.highest) == (0, 60 * 4)
    assert (brush.step, brush.stuck_samples, brush.stuck_mK) == (5, 120, 3000)
    assert ambient.stuck_samples == 0
    assert [reading_samples(t) for t in (0.05, 0.1, 0.22, 0.25, 3.0)] == [5, 3, 2, 1, 1]


def rises(counts: list[int]) -> list[int]:
    check = SensorCheck(LIMITS)
    found = []
    for item in counts:
        check.check(word(item), True, 60_000)
        found.append(check.rising_mK)
    return found


def test_a_rise_is_told_from_its_fourth_reading_on_less_the_noise_of_a_kelvin() -> None:
    """8 K/s are 8 counts a reading, 16 over two: 4 K, of which 1 K may be noise."""
    assert rises([240, 248, 256, 264, 272]) == [0, 0, 0, 3000, 3000]
    assert rises([240] * 4 + [248, 256, 264]) == [0] * 5 + [1000, 3000]


@pytest.mark.parametrize("off", [-20, -8, 8, 20])
def test_one_reading_that_is_off_makes_no_rise(off: int) -> None:
    assert set(rises([240] * 6 + [240 + off] + [240] * 6)) == {0}


def test_what_falls_or_says_nothing_does_not_rise() -> None:
    assert set(rises([400, 392, 384, 376, 368])) == {0}
    check = SensorCheck(LIMITS)
    for item in (word(240), word(248), word(256), word(264), 4):  # the last one: open
        check.check(item, True, 60_000)
    assert check.rising_mK == 0
    for item in (272, 280, 288):
        check.check(word(item), True, 60_000)
        assert check.rising_mK == 0, "the four readings are no longer one after another"
