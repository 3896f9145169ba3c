"""Sums of missing heat, held against the exact answer of a body to a heat that its model lacks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from gen.arrays import FloatArray, IntArray
from gen.lowering.heat import BINS, HeatTerm, LoweredHeat, PER_mK
from gen.reference.heat import ReferenceHeat, fields, truncated
from gen.reference.heat_blocks import blocks_of, sums_after

BLOCK, STEP_S, TAU_S = 80, 0.25, 1800.0
BLOCK_S = BLOCK * STEP_S
LOST = round(2**16 * -np.expm1(-BLOCK_S / TAU_S))
K = 1000 * PER_mK


def rule(**other: object) -> LoweredHeat:
    plain = LoweredHeat(
        block=BLOCK,
        low=10,
        high=255,
        terms=(HeatTerm(0, 256, (LOST,) * BINS),),
        slack=round(0.7e-3 * K * BLOCK_S),
        unknown=0,
        change=0,
        start=0,
        fading=(round(2**16 * -np.expm1(-BLOCK_S / 300.0)),) * BINS,
        memory=90,
        forgetting=2**16,
        limit=round(0.2 * K),
    )
    return replace(plain, **other)  # type: ignore[arg-type]


def warmed(heat_K_s: float, begins_s: float, lasts_s: float) -> IntArray:
    """What a body of first order is above its model, exactly, in thousandths of a kelvin."""
    time = np.arange(1, round(lasts_s / STEP_S) + 1) * STEP_S
    since = np.maximum(time - begins_s, 0.0)
    risen: IntArray = np.rint(1000.0 * heat_K_s * TAU_S * -np.expm1(-since / TAU_S)).astype(np.int64)
    return risen


def sums(made: LoweredHeat, deviation: IntArray, pwm: IntArray | None = None, *, trusted: bool = True) -> FloatArray:
    level = np.full(deviation.size, 100) if pwm is None else pwm
    record = blocks_of(BLOCK, [0], level, deviation[None], np.ones(deviation.size, dtype=np.int64))
    found: FloatArray = sums_after([made], [record], np.array([trusted]))[0, 0] / K
    return found


@pytest.mark.parametrize("heat_mK_s", [1.5, 3.0, 10.0])
def test_a_heat_is_heard_when_its_energy_less_the_slack_reaches_the_threshold(heat_mK_s: float) -> None:
    begins = 3600.0
    found = sums(rule(), warmed(1e-3 * heat_mK_s, begins, 7200.0))
    assert found[: int(begins / BLOCK_S)].max() == 0.0
    heard_s = (int(np.argmax(found >= 0.2)) + 1) * BLOCK_S - begins
    # What begins becomes usual with 1800 s meanwhile, and a block's mean is half a block old.
    counted = brentq(lambda t: 1e-3 * heat_mK_s * 1800.0 * -np.expm1(-t / 1800.0) - 0.7e-3 * t - 0.2, 0.0, 600.0)
    assert counted <= heard_s <= counted + 1.6 * BLOCK_S


def test_heat_below_the_slack_is_never_heard() -> None:
    assert sums(rule(), warmed(0.6e-3, 3600.0, 20_000.0)).max() < 0.01


def test_what_lasts_becomes_usual_and_a_change_on_top_is_heard_as_before() -> None:
    old = warmed(2e-3, 0.0, 20_000.0)
    alone, on_top = sums(rule(), old), sums(rule(), old + warmed(3e-3, 12_000.0, 20_000.0))
    before = int(12_000.0 / BLOCK_S)
    assert alone[before - 1] == 0.0
    assert np.argmax(on_top[before:] >= 0.2) * BLOCK_S <= 160.0


def test_heat_that_comes_back_is_no_change_if_it_is_remembered() -> None:
    """A draught of an hour ends: the heat is what it was before."""
    slow = replace(rule(), forgetting=round(2**16 * -np.expm1(-BLOCK_S / 14_400.0)))
    draught = warmed(-3e-3, 5400.0, 16_000.0) + warmed(3e-3, 9000.0, 16_000.0)
    assert sums(rule(), draught).max() > 0.2
    assert sums(slow, draught).max() < 0.02
    # A fault after it is heard as soon as without a draught, and one within it by what it adds beyond the old heat.
    ended = int(11_000.0 / BLOCK_S)
    fault = warmed(4e-3, 11_000.0, 16_000.0)
    late = [int(np.argmax(sums(slow, some + fault)[ended:] >= 0.2)) for some in (draught, 0 * draught)]
    assert abs(late[0] - late[1]) <= 1
    assert sums(slow, draught + warmed(6e-3, 7000.0, 16_000.0)).max() > 0.2


def test_what_is_remembered_fades_with_its_time_constant() -> None:
    """Heat that was there for long, gone for one time constant, and back: what has faded counts as new."""
    remembered = replace(rule(slack=1, limit=2**26), forgetting=round(2**16 * -np.expm1(-BLOCK_S / 3600.0)))
    heat, gone, back = 4e-3, 14_400.0, 18_000.0
    deviation = warmed(heat, 0.0, 20_000.0) - warmed(heat, gone, 20_000.0) + warmed(heat, back, 20_000.0)
    found = sums(remembered, deviation)
    first = found[int(back / BLOCK_S) + 2 : int(back / BLOCK_S) + 6]
    # The same in floats, block by block, but for a block's mean, which is half a block old: usual falls with 1800 s,
    # and what was usual before follows it with 3600 s.
    usual = before = heat
    counted = []
    for block in range(1, int((back - gone) / BLOCK_S) + 7):
        counted.append(((heat if block > (back - gone) / BLOCK_S else 0.0) - before) * BLOCK_S)
        usual += ((heat if block > (back - gone) / BLOCK_S else 0.0) - usual) * BLOCK_S / 1800.0
        before = max(usual, before - (before - usual) * -np.expm1(-BLOCK_S / 3600.0))
    np.testing.assert_allclose(np.diff(first), counted[-4:-1], rtol=0.04)


def test_little_learnt_is_not_remembered() -> None:
    """What a noisy first quarter of an hour took for usual is not held for hours."""
    noise = np.rint(np.random.default_rng(3).normal(0.0, 100.0, 80_000)).astype(np.int64)
    slow = replace(rule(), forgetting=1)
    fault = noise + warmed(3e-3, 10_800.0, 20_000.0)
    heard = [int(np.argmax(sums(one, fault) >= 0.2)) for one in (rule(), slow)]
    assert heard[1] - heard[0] <= 6


def test_offsets_of_sensors_within_the_tolerance_are_no_heat_after_a_start() -> None:
    offset = warmed(1.1e-3, 0.0, 10_800.0)  # the model decays from a start that read 2 K too much
    slack = round(0.1e-3 * K * BLOCK_S)
    assert sums(rule(slack=slack), offset).max() > 0.1
    assert sums(rule(slack=slack, unknown=round(1.2e-3 * K * BLOCK_S)), offset).max() < 0.01


def test_what_a_change_of_pwm_makes_uncertain_is_not_counted_until_it_has_faded() -> None:
    pwm = np.where(np.arange(40_000) < 16_000, 60, 200)
    time = np.maximum(np.arange(40_000) * STEP_S - 4000.0, 0.0)
    transient = np.rint(1000.0 * 2.0 * -np.expm1(-time / 200.0)).astype(np.int64)  # 2 K that the model has later
    plain, unsettled = rule(), rule(change=round(12e-3 / 140 * K * BLOCK_S * 256))
    assert sums(plain, transient, pwm).max() > 0.3
    assert sums(unsettled, transient, pwm).max() < 0.1  # half of the threshold
    fault = warmed(4e-3, 6000.0, 10_000.0)
    assert sums(unsettled, transient + fault, pwm)[-1] > 0.2


def test_heat_that_came_while_a_part_was_not_measured_is_heard_afterwards() -> None:
    deviation = warmed(4e-3, 3600.0, 5400.0)
    valid = np.ones(deviation.size, dtype=np.int64)
    valid[int(3600 / STEP_S) : int(4200 / STEP_S)] = 0
    record = blocks_of(BLOCK, [0], np.full(deviation.size, 100), deviation[None], valid)
    found = sums_after([rule()], [record], np.array([True]))[0, 0] / K
    gap = slice(int(3600 / BLOCK_S), int(4200 / BLOCK_S))
    assert found[gap].max() == 0.0
    assert found[gap.stop] == 0.4  # 2 K less the slack, held to twice the threshold


def test_outside_its_speeds_a_rule_neither_counts_nor_forgets() -> None:
    deviation = warmed(4e-3, 3600.0, 5400.0)
    pwm = np.where(np.arange(deviation.size) * STEP_S < 3680.0, 100, 5)
    found = sums(rule(), deviation, pwm)
    at = int(3680 / BLOCK_S)
    assert found[at - 1] > 0.1
    assert (found[at:] == found[at - 1]).all()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.booleans())
def test_blocks_at_once_give_the_words_of_sample_by_sample(seed: int, trusted: bool) -> None:
    rng = np.random.default_rng(seed)
    fade = tuple(int(value) for value in rng.integers(1, 2**16, BINS))
    made = [
        rule(
            block=4, terms=(HeatTerm(1, -256, fade),), unknown=900, change=5000, start=10**6, fading=fade, limit=50_000
        ),
        None,
        rule(block=4, terms=(HeatTerm(0, 100, fade), HeatTerm(1, 300, fade)), slack=1, memory=5, limit=2**26),
    ]
    pwm = np.repeat(rng.integers(-300, 301, 30), 4)
    deviation = rng.integers(-(10**6), 10**6, (2, 120)) // int(rng.choice([1, 1000, 10**5]))
    valid = rng.integers(0, 4, 120) | np.where(rng.random(120) < 0.7, 3, 0)
    reference = ReferenceHeat(made, np.array([trusted]))
    expected = []
    for k in range(120):
        reference.step(pwm[k : k + 1], deviation[:, k : k + 1], valid[k : k + 1])
        if k % 4 == 3:
            expected.append(reference.sums[:, 0].copy())
    found = sums_after(made, [blocks_of(4, [0, 1], pwm, deviation, valid)], np.array([trusted]))
    assert np.array_equal(found[:, 0, :].T, np.array(expected))
    words = np.zeros(1, dtype=np.dtype(fields(made)))
    reference.keep(words)  # no word is wider than the board's
    again = ReferenceHeat(made, np.array([trusted]))
    again.advance(words)
    kept = np.zeros_like(words)
    again.keep(kept)
    assert kept == words


def test_division_is_towards_zero_as_in_cpp() -> None:
    assert truncated(np.array([-7, 7, -1, 0]), np.array([2, 2, 3, 5])).tolist() == [-3, 3, 0, 0]
