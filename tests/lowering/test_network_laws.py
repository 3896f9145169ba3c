"""Laws as the board evaluates them, and what is proven of a network that has some."""

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, parse
from gen.errors import CheckFailed
from gen.lowering.kinds import Arithmetic
from gen.lowering.network import fixed, lower
from gen.lowering.network.defect import bending
from gen.lowering.network.laws import limited, lower_law
from gen.lowering.network.lower import lower_network
from gen.lowering.network.ranges import reachable, speeds
from gen.lowering.network.terms import PathLaw, Terms, terms_of
from gen.model.laws import Convection
from gen.model.network_solution import NetworkSolution
from gen.reference.network import ReferenceNetwork
from tests.drawn_networks import with_laws

SEEDS = range(6)


def read(tree: dict[str, Any]) -> Coefficients:
    return parse(json.dumps(tree).encode())


@pytest.mark.parametrize("seed", SEEDS)
def test_words_are_as_near_to_their_law_as_is_said(seed: int) -> None:
    model = read(with_laws(seed, 4)).model
    terms = terms_of(model)
    ranges = reachable(model, terms)
    assert ranges is not None
    terms, random = limited(terms, ranges), np.random.default_rng(seed)
    for bits in (20, 23):
        for own in terms.laws:
            program = lower_law(own, ranges, bits)
            words = [_words(random, ranges, place, bits) for place in (own.first, own.second)]
            driving, slope = program.evaluate(*words)
            one, other = (word * 2.0**-bits for word in words)
            assert np.abs(driving * 2.0**-bits - own.law.driving(one, other) / own.scale).max() <= program.error
            assert np.abs(slope * 2.0**-30 - own.law.slope(one, other) / own.scale).max() <= program.slope_error
            assert np.abs(driving).max() < 2**31
            assert 0 <= slope.min() <= slope.max() < 2**31
            found, (least, most) = own.law.slope(one, other) / own.scale, own.slopes
            assert least - 1e-7 <= found.min()  # a word may be rounded out of its range
            assert found.max() <= most + 1e-7


@pytest.mark.parametrize("conductance", [0.5, 0.02, 3e-5])
def test_the_slope_of_a_flat_law_fills_its_word(conductance: float) -> None:
    """However flat a law is, its slope has 30 of its 31 bits: a coarser one would count in the bound."""
    tree = with_laws(1, 4)
    for path in tree["network"]["paths"]:
        if "convection" in path:
            path["convection"]["poly"] = [conductance]
    model = read(tree).model
    terms = terms_of(model)
    ranges = reachable(model, terms)
    assert ranges is not None
    flat = [own for own in limited(terms, ranges).laws if isinstance(own.law, Convection)]
    assert flat
    for own in flat:
        assert 1.0 <= own.slopes[1] < 2.0
        assert own.slopes[1] * own.scale == pytest.approx(conductance)


def _words(random: np.random.Generator, ranges: Any, place: int | None, bits: int) -> Any:  # noqa: ANN401
    low, high = ranges.ambient if place is None else ranges.of(place)
    share = random.uniform(size=4000)
    share[:1000] = np.round(share[:1000])
    return np.rint((low + share * (high - low)) * 2.0**bits).astype(np.int64)


@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_leaves_its_range(seed: int) -> None:
    """At the ends of what is reachable heat flows back, whatever |PWM| and the channels: by the exact equations."""
    model = read(with_laws(seed, 4)).model
    ranges = reachable(model, terms_of(model))
    assert ranges is not None
    solution, pwm = NetworkSolution(model), np.arange(256)
    assert model.network is not None
    for share in (0.0, 0.3, 1.0):
        told = {c.column: c.low + share * (c.high - c.low) for c in model.network.channels}
        exact = ranges.low + ranges.margin, ranges.high - ranges.margin
        sides = ((exact[1], ranges.ambient[1], 1.0), (exact[0], ranges.ambient[0], -1.0))
        for ends, room, sign in sides:
            flow = solution.flow(pwm, {name: np.full(256, value) for name, value in told.items()})
            rate = flow(np.tile([*ends, room], (256, 1)))[:, :-1]
            assert (sign * rate).max() <= 1e-8


@pytest.mark.parametrize(
    ("seed", "arithmetic"), [(seed, arithmetic) for seed in SEEDS for arithmetic in ("fixed", "float")]
)
def test_a_sample_adds_no_more_to_the_error_than_is_proven(seed: int, arithmetic: Arithmetic) -> None:
    """From random states of the board, corners among them, against the exact solution of one sample."""
    coefficients, lanes = read(with_laws(seed, 4)), 3000
    model = coefficients.model
    program = lower_network(coefficients, arithmetic)
    random = np.random.default_rng(seed)
    low_bits = fixed.LOW_BITS if arithmetic == "fixed" else 8
    unit = 2.0 ** -(program.fraction_bits + low_bits)
    share = random.uniform(size=(len(program.states), lanes))
    share[:, : lanes // 2] = np.round(share[:, : lanes // 2])
    low, high = program.proof.low[:, None] + 0.02, program.proof.high[:, None] - 0.02
    words = np.rint((low + share * (high - low)) / unit).astype(np.int64)
    told = np.array([random.integers(c.low, c.high + 1, lanes) for c in program.channels])
    pwm = random.integers(0, 256, lanes)
    board = ReferenceNetwork(program, (0, 255), (0, 255), {r.name: [0] * lanes for r in program.readings}, told)
    board._state = words.copy()
    board.step(pwm)
    columns = {c.column: told[k] / 1000.0 for k, c in enumerate(program.channels) if k}
    step = np.full(lanes, model.sample_time)
    states = np.asarray((words * unit).T, dtype=np.float64)
    exact = NetworkSolution(model).advance(states, pwm, step, told[0] / 1000.0, columns)
    away = np.abs((board._state * unit).T - exact).max(axis=0)
    assert np.all(away <= program.proof.defect + 1e-9 * 0.1)
    assert (away / program.proof.defect).max() > 0.01


def test_what_bends_counts_with_the_square_of_how_fast_temperatures_change() -> None:
    model = read(with_laws(1, 4)).model
    terms = terms_of(model)
    ranges = reachable(model, terms)
    assert ranges is not None
    terms = limited(terms, ranges)
    first = speeds(terms, ranges)
    assert np.allclose(bending(terms, first), 4.0 * bending(terms, first / 2.0))
    assert np.all(bending(terms, first) >= 0.0)


def test_differences_at_which_heat_falls_are_refused_with_their_path() -> None:
    """What the file's domain does not reach may be reached all the same: a node that is heated."""
    tree = copy.deepcopy(with_laws(0, 2))
    tree["domain"]["temperature_degC"], tree["domain"]["ambient_degC"] = [20, 40], [20, 30]
    tree["network"]["nodes"][0]["sensor"] = {}
    tree["network"]["paths"] = [
        {
            "between": ["part0", "ambient"],
            "conductance_W_per_K": {"poly": [0.2]},
            "convection": {"poly": [-0.012, 1.0]},
        },
        {"between": ["part1", "part0"], "conductance_W_per_K": {"poly": [0.5]}},
    ]
    tree["network"]["heats"] = [{"node": "part0", "power_W": {"poly": [0.0155, 0]}}]
    tree["network"]["channels"] = []
    with pytest.raises(CheckFailed, match=r"paths\[0\].convection: differences of up to .* K can be reached"):
        lower_network(read(tree), "fixed")


def test_what_bends_too_much_to_be_proven_is_refused() -> None:
    """Seed 2 is within 0.1 K; with a twentieth of its heat capacities it is not."""
    tree = with_laws(2, 4)
    assert lower_network(read(tree), "float").proof.error.max() < 0.1
    for node in tree["network"]["nodes"]:
        node["capacity_J_per_K"] *= 0.05
    with pytest.raises(CheckFailed, match=r"errors up to 0\.1 K can be proven, and it would be"):
        lower_network(read(tree), "float")


def test_heat_that_finds_no_way_out_has_no_range(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lower, "reachable", lambda *_: None)
    with pytest.raises(CheckFailed, match="no range of temperatures can be proven"):
        lower_network(read(with_laws(0, 2)), "fixed")


def test_terms_of_both_ends_share_one_law() -> None:
    terms: Terms = terms_of(read(with_laws(2, 5)).model)
    assert [law.index for law in terms.laws] == list(range(len(terms.laws)))
    for law in terms.laws:
        own = [term for term in terms.terms if term.law is law]
        assert {term.target for term in own} == {law.first, *([] if law.second is None else [law.second])}
        assert isinstance(own[0].law, PathLaw)
