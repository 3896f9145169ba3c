"""A file that reads a moving room and holds nothing else that was found."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from gen.coefficients import parse
from gen.refinement.network.ambient import MovingAmbient
from gen.refinement.network.effects import PathChange, candidates
from gen.refinement.network.effects.radiation import Radiation
from gen.refinement.network.effects.schedule_error import ScheduleError
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench, Fitted
from gen.refinement.network.kept import Kept, could_be_a_change
from gen.refinement.network.tracing.judged import Judged, judged
from gen.refinement.network.tracing.search import Considered, Step
from gen.refinement.network.tracing.trace import Traced
from gen.refinement.network.tracing.warm_start import WarmStart
from gen.refinement.network.written import offered_anew, written
from tests.refinement.network.motor import read, run, tree, wave

SUPPLY_V = (19.0, 27.0)


def as_said(traced: Traced) -> WarmStart:
    """Hidden nodes start where the file says."""
    return WarmStart(traced.final, {}, traced.final, 1.0)


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
    made = written(coefficients, raw, traced, [], room, as_said(traced))
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
    held = written(coefficients, raw, traced, [], None, as_said(traced))
    assert held.text == raw
    assert not held.refitted
    said = offered_anew(traced, declared=False)
    assert f"to {null.score_K:.2g} K instead of {file.score_K:.2g} K: the motor is another" in said
    assert "another" not in offered_anew(traced, declared=True)
    accepted = written(coefficients, raw, traced, [], None, as_said(traced), accept_change=True)
    assert accepted.refitted
    assert accepted.text != raw
    assert offered_anew(replace(traced, null=replace(null, noise_K=null.score_K)), declared=False) == ""


@pytest.fixture(scope="module")
def supplied() -> tuple[Bench, Judged]:
    """Two runs of the motor as the file has it, while a supply moves: fitted, and judged."""
    coefficients = read(tree())
    network = coefficients.model.network
    assert network is not None
    logged = [(f"run {seed}", run(coefficients, seed, {"supply_V": wave(40 + seed, *SUPPLY_V)})) for seed in (1, 2)]
    bench = Bench(make_data(coefficients, logged))
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    return bench, judged(bench.data, base, bench.left_out(base))


@pytest.mark.parametrize(
    ("per_K", "range_V"), [(0.010, (18.2, 27.8)), (0.013, SUPPLY_V), (0.015, (20.6, 25.4)), (0.020, None)]
)
def test_a_channel_is_held_to_less_where_all_of_it_would_heat_the_motor_without_end(
    supplied: tuple[Bench, Judged], per_K: float, range_V: tuple[float, float] | None
) -> None:
    """A file's board is proven for every voltage of the range, for ever: more than there was, if that can be built."""
    bench, null = supplied
    base = null.fitted
    every = candidates(base.shape.motor(), bench.data.offered)
    by_name = {effect.name: effect for effect in reversed(every)}
    supply, loss = by_name["supply_voltage"], by_name["temperature_dependent_loss"]
    problem, vector = bench.begin(base.shape.with_effects(supply, loss), base)
    numbers = ((1.0, 1.0, 23.0), (per_K,))
    for place, effect, values in zip(problem.structure.places, (supply, loss), numbers, strict=True):
        vector[place.columns] = [number.fitted(value) for number, value in zip(effect.numbers, values, strict=True)]
    final = replace(null, fitted=Fitted(problem, replace(base.fit, vector=vector)))
    traced = Traced(bench.data, null, null, (Step(null, (), Considered(supply, final, 0.0, ()), ()),), final, ())
    raw = json.dumps(tree())
    made = written(parse(raw.encode()), raw, traced, [supply, loss], None, as_said(traced))
    if range_V is None:
        assert made.text == raw
        assert "none that can be built ($.network: runs away" in made.refused
        return
    (channel,) = json.loads(made.text)["network"]["channels"]
    assert channel["range"] == pytest.approx(range_V)
    less = range_V[1] < SUPPLY_V[1]
    assert made.refused.startswith("supply_V: the file holds it to 20.6 .. 25.4, where the runs had 19 .. 27") == less
    assert ("no board could be built ($.network: runs away" in made.refused) == less
    assert bool(made.refused) == less


def test_of_what_is_written_it_is_said_that_a_changed_motor_looks_the_same(supplied: tuple[Bench, Judged]) -> None:
    _, null = supplied
    motor = null.fitted.shape.motor()
    radiation, path = Radiation(motor, 0), PathChange(motor, [0], "winding")
    one, other = (Considered(effect, null, 0.001, ()) for effect in (radiation, path))
    for alike, change, effects, said in (
        ((other,), "", (radiation,), True),
        ((), "", (radiation,), False),
        ((other,), "", (), False),
        ((other,), "has changed", (radiation,), False),
    ):
        found = Kept((change,), (True,), effects, None, alone=False)
        told = could_be_a_change([Step(null, (one,), one, alike), Step(null, (), None, ())], found)
        assert [line.startswith("winding: radiation is written") for line in told] == [True] * said
