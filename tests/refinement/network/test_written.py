"""A file that reads a moving room and holds nothing else that was found."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from gen.coefficients import parse
from gen.refinement.network.ambient import MovingAmbient
from gen.refinement.network.effects.schedule_error import ScheduleError
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.tracing.judged import judged
from gen.refinement.network.tracing.search import Considered, Step
from gen.refinement.network.tracing.trace import Traced
from gen.refinement.network.written import offered_anew, written
from tests.refinement.network.motor import read, run, tree


@pytest.mark.parametrize("helps", [True, False])
def test_beside_wear_the_room_is_read_only_where_the_file_as_it_is_gains_by_it(helps: bool) -> None:
    fixed = tree()
    fixed["ambient"] = {"fixed_degC": 24}
    raw = json.dumps(fixed)
    coefficients = parse(raw.encode())
    network = coefficients.model.network
    assert network is not None
    data = make_data(coefficients, [(f"run {seed}", run(read(tree()), seed)) for seed in (1, 2)])
    bench = Bench(data)
    shape = Anchored.of(network, 255, data.columns)
    wear = ScheduleError(shape.motor(), [0], "winding")
    base, found = bench.first(shape), bench.first(shape.with_effects(wear))
    null = judged(data, base, bench.left_out(base))
    final = judged(data, found, bench.left_out(found))
    step = Step(null, (), Considered(wear, final, 0.0, ()), ())
    traced = Traced(data, judged(data, base, bench.as_it_is(shape)), null, (step,), final, ())
    room = MovingAmbient("ambient_degC", 2.0, 0.2, 0.0, helps)
    made = written(coefficients, raw, traced, [], room, {})
    assert not made.refitted
    if helps:
        assert parse(made.text.encode()).model.ambient_channel == "ambient_degC"
        assert made.refused == ""
    else:
        assert made.text == raw
        assert made.refused.startswith("ambient: found")


def test_numbers_that_leave_more_than_noise_are_offered_and_written_only_on_demand() -> None:
    """Every path of the motor carries a tenth more than the file says: no effect of the library, and no wear either."""
    raw = json.dumps(tree())
    coefficients = parse(raw.encode())
    network = coefficients.model.network
    assert network is not None
    other = tree()
    other["network"]["paths"][0]["conductance_W_per_K"] = {"poly": [0.55]}
    other["network"]["paths"][1]["conductance_W_per_K"]["power"] = {"constant": 0.22, "forced": 0.33, "exponent": 0.8}
    data = make_data(coefficients, [(f"run {seed}", run(read(other), seed)) for seed in (1, 2)])
    bench = Bench(data)
    shape = Anchored.of(network, 255, data.columns)
    base = bench.first(shape)
    null, file = judged(data, base, bench.left_out(base)), judged(data, base, bench.as_it_is(shape))
    # As if sensors were so good that the rest is no noise.
    traced = Traced(data, file, replace(null, noise_K=null.score_K / 3.0), (), null, ())
    held = written(coefficients, raw, traced, [], None, {})
    assert held.text == raw
    assert not held.refitted
    said = offered_anew(traced)
    assert f"to {null.score_K:.2g} K instead of {file.score_K:.2g} K" in said
    accepted = written(coefficients, raw, traced, [], None, {}, accept_change=True)
    assert accepted.refitted
    assert accepted.text != raw
    assert offered_anew(replace(traced, null=replace(null, noise_K=null.score_K))) == ""
