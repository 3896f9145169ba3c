"""When rules are first raised on a whole record, against the definition sample by sample."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.lowering.alarms import LoweredRule, Segment
from gen.lowering.heat import BINS, HeatTerm, LoweredHeat
from gen.reference.alarms import ReferenceAlarms
from gen.reference.first_alarms import first_raised

SAMPLES, PARTS = 160, 2
STEP_mK = 200  # coarse, so that values meet thresholds exactly


@st.composite
def heat(draw: st.DrawFn, component: int, low: int, high: int) -> LoweredHeat:
    """Blocks of four samples, and limits that some of these deviations reach."""
    bins = st.lists(st.integers(1, 20_000), min_size=BINS, max_size=BINS).map(tuple)
    return LoweredHeat(
        block=4,
        low=low,
        high=high,
        terms=(HeatTerm(component, draw(st.sampled_from([256, -256])), draw(bins)),),
        slack=draw(st.integers(1, 2000)),
        unknown=draw(st.integers(0, 2000)),
        change=draw(st.integers(0, 2000)),
        start=draw(st.integers(0, 10**6)),
        fading=draw(bins),
        memory=draw(st.integers(4, 40)),
        forgetting=draw(st.sampled_from([2**16, 100, 20_000])),
        limit=draw(st.integers(1, 20_000)),
    )


@st.composite
def rule(draw: st.DrawFn, number: int) -> LoweredRule:
    quantity = draw(st.sampled_from(["above", "below", "measured", "heat"]))
    trip = STEP_mK * draw(st.integers(0, 7)) + (40_000 if quantity == "measured" else 0)
    clear = trip - STEP_mK * draw(st.integers(0, 4))
    low, high = sorted([draw(st.integers(0, 255)), draw(st.integers(0, 255))])
    segments = [Segment(low, high, trip, clear)]
    if high < 255 and draw(st.booleans()):
        segments.append(Segment(high + 1, 255, trip + STEP_mK, clear + STEP_mK))
    earlier = st.none() | st.integers(0, number - 1) if number else st.none()
    component = draw(st.integers(0, PARTS - 1))
    plain = quantity in ("above", "below")
    is_sum = plain and draw(st.booleans())
    return LoweredRule(
        name=f"rule{number}",
        description="",
        quantity=quantity,
        component=component,
        relative_to=1 - component if plain and draw(st.booleans()) else None,
        segments=tuple(Segment(s.low, s.high, s.trip_mK, s.trip_mK) for s in segments) if is_sum else tuple(segments),
        settle=draw(st.integers(0, 20)),
        start_wait=draw(st.integers(0, 20)),
        persistence=draw(st.integers(0, 10)),
        requires=draw(earlier),
        unless=draw(earlier),
        sum_limit=draw(st.integers(1, 10_000)) if is_sum else None,
        heat=draw(heat(component, low, high)) if quantity == "heat" else None,
        looks_ahead=quantity == "measured" and draw(st.booleans()),
    )


@settings(max_examples=150)
@given(st.data(), st.integers(1, 4), st.integers(0, 2**32), st.booleans())
def test_rules_are_first_raised_when_the_definition_raises_them(
    data: st.DataObject, count: int, seed: int, trusted: bool
) -> None:
    rules = [data.draw(rule(number)) for number in range(count)]
    rng = np.random.default_rng(seed)
    changes = np.sort(rng.integers(0, SAMPLES, 7))  # anywhere in a block
    pwm = np.repeat(rng.integers(-255, 256, 8), np.diff(changes, prepend=0, append=SAMPLES))
    wander = np.cumsum(rng.normal(0.0, 150.0, (PARTS, SAMPLES)), axis=1) + rng.normal(0.0, 300.0, (PARTS, SAMPLES))
    model = np.full((PARTS, SAMPLES), 40_000, dtype=np.int64)
    measured = model + STEP_mK * np.rint(wander / STEP_mK).astype(np.int64)
    valid = rng.integers(0, 4, SAMPLES) | np.where(rng.random(SAMPLES) < 0.8, 3, 0)
    reference = ReferenceAlarms(rules, np.array([trusted]))
    expected: list[int | None] = [None] * count
    for k in range(SAMPLES):
        reference.step(pwm[k : k + 1], measured[:, k : k + 1], model[:, k : k + 1], valid[k : k + 1])
        for number in range(count):
            if int(reference.latched[0]) >> number & 1 and expected[number] is None:
                expected[number] = k
    assert first_raised(rules, pwm, measured, model, valid, trusted=trusted) == expected
