"""A network as the board computes it: its terms, its ranges, its error's bound."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients, load
from gen.errors import CheckFailed, InputError
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.network.defect import error_bound
from gen.lowering.network.factors import lower_factor
from gen.lowering.network.fixed import FixedFormat, heat_programs, roundings
from gen.lowering.network.lower import lower_network
from gen.lowering.network.ranges import matrix_row, reachable
from gen.lowering.network.series import FIRST
from gen.lowering.network.terms import Terms, terms_of
from gen.model.network_parts import Channel, Factor
from gen.model.network_solution import NetworkSolution, Steps
from gen.reference.board import reference_of
from gen.reference.network import ReferenceNetwork
from tests.networks import Tree, loaded, network_tree

ARITHMETICS: tuple[Arithmetic, ...] = ("fixed", "float")
CASES = [(3, 4, False), (4, 6, True), (5, 10, True), (6, 7, False), (8, 1, True)]


@pytest.mark.parametrize(("seed", "nodes", "plain"), CASES)
def test_the_terms_are_the_networks_matrices(seed: int, nodes: int, plain: bool) -> None:
    """Written by another module from the same file: h (M T + a ambient + f) at every |PWM|."""
    model = loaded(network_tree(seed, nodes, plain=plain)).model
    assert model.network is not None
    solution = NetworkSolution(model)
    terms = terms_of(model)
    told = {"fan_percent": 100.0, "current_A": -7.0}
    exact = solution.with_sensors(*model.network.matrices(np.arange(256), {} if plain else told))
    corner = {k: float(factor(told[factor.channel])) for k, factor in enumerate(terms.factors)}
    for state in range(len(terms.states)):
        row, rest = matrix_row(terms, state, {k: corner[k] for k in terms.corners(state)[0]}, 17.0)
        assert row / model.sample_time == pytest.approx(exact[0][:, state], rel=1e-12, abs=1e-18)
        assert rest / model.sample_time == pytest.approx(exact[1][:, state] * 17.0 + exact[2][:, state], rel=1e-12)


class Plant:
    """The exact solution of one lane after another, and what the reference makes of the same."""

    def __init__(self, coefficients: Coefficients, arithmetic: Arithmetic, lanes: int, seed: int) -> None:
        self.program = lower(coefficients, arithmetic, "table")
        self.model = coefficients.model
        self.random = np.random.default_rng(seed)
        self.lanes = lanes
        self.solution = NetworkSolution(self.model)
        low, high = self.model.domain_temperature
        self.told = self.draw()
        names = self.model.component_names
        first = {name: self.random.integers(round(low * 1000), round(high * 1000) + 1, lanes) for name in names}
        starts = {name: (value - self.told[0]).tolist() for name, value in first.items()}
        board = reference_of(self.program, starts, self.told)
        assert isinstance(board, ReferenceNetwork)
        self.board = board
        self.states = self.solution.start({n: v / 1000.0 for n, v in first.items()}, self.told[0] / 1000.0)
        self.steps: dict[tuple[int, ...], Steps] = {}

    def draw(self) -> IntArray:
        """Values of all channels, in thousandths: ends as often as what lies between."""
        drawn = []
        for channel in self.program.channels:
            inner = self.random.integers(channel.low, channel.high + 1, self.lanes)
            end = self.random.choice([channel.low, channel.high], self.lanes)
            drawn.append(np.where(self.random.random(self.lanes) < 0.5, end, inner))
        return np.array(drawn, dtype=np.int64)

    def advance(self, pwm: IntArray) -> None:
        """One sample of both."""
        columns = {c.column: self.told[k] / 1000.0 for k, c in enumerate(self.program.channels)}
        others = {name: columns[name] for name in list(columns)[1:]}
        steps = self.solution.steps(np.abs(pwm), np.full(self.lanes, self.model.sample_time), others)
        change = np.einsum("lij,lj->li", steps.increment, self.states) + steps.heat
        self.states = self.states + change + steps.ambient * (self.told[0] / 1000.0)[:, None]
        self.board.set_channels(self.told)
        self.board.step(pwm)

    @property
    def error(self) -> FloatArray:
        """Of each component's reading, K, shape (components, lanes)."""
        shown = np.array(list(self.solution.shown(self.states, self.told[0] / 1000.0).values()))
        return np.asarray(np.abs(self.board.readings - shown))


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize(("seed", "nodes", "plain"), CASES)
def test_no_error_exceeds_the_bound_and_no_temperature_its_range(
    seed: int, nodes: int, plain: bool, arithmetic: Arithmetic
) -> None:
    coefficients = loaded(network_tree(seed, nodes, plain=plain))
    plant = Plant(coefficients, arithmetic, 24, seed)
    network = plant.program.network
    assert network is not None
    bounds = np.array([part.proof.bound_K for part in network.components()])[:, None]
    holds = plant.random.choice([1, 2, 7, 60, 900], plant.lanes)
    pwm = np.zeros(plant.lanes, dtype=np.int64)
    assert np.all(plant.error <= bounds)
    for sample in range(1500):
        fresh = sample % holds == 0
        pwm = np.where(fresh, plant.random.choice([0, 255, 1, 128, -255], plant.lanes), pwm)
        plant.told = np.where(fresh, plant.draw(), plant.told)
        plant.advance(pwm)
        assert np.all(plant.error <= bounds)
        assert np.all(plant.states >= network.proof.low)
        assert np.all(plant.states <= network.proof.high)
    assert np.all(plant.board.saturations == 0)


def test_readings_of_sensors_that_drift_stay_within_their_bounds_until_they_stand() -> None:
    """Of drifts that are over within the test, and one that hardly begins; the last words are the ends'."""
    tree = network_tree(4, 6)
    sensed = [node for node in tree["network"]["nodes"] if "sensor" in node]
    drifts = [(12.5, 0.05), (-33.0, 0.05), (250.0, 48.0)]
    for node, (drift, hours) in zip(sensed, drifts, strict=False):
        node["sensor"] = {"drift_K": drift, "drift_h": hours}
    plant = Plant(loaded(tree), "fixed", 40, 3)
    network = plant.program.network
    assert network is not None
    parts = network.components()
    bounds = np.array([part.proof.bound_K for part in parts])[:, None]
    ends = np.array([part.proof.range_degC for part in parts])
    for sample in range(9000):
        if sample % 500 == 0:
            plant.told = plant.draw()
            assert np.all(plant.error <= bounds)
            assert np.all(ends[:, :1] <= plant.board.readings)
            assert np.all(plant.board.readings <= ends[:, 1:])
        plant.advance(plant.random.choice([0, 255, -60], plant.lanes))
    drifted = plant.board.temperatures[list(network.drifts)]
    assert drifted[:2] == pytest.approx(np.array([[12.5], [-33.0]]) * np.ones(plant.lanes), rel=1e-5)


GAINS: list[Tree] = [
    {"gain_error": -0.85},
    {"gain_error": 1.9, "offset_K": -3.0},
    {"gain_error": -0.3, "gain_about": "zero_degC", "lag_s": 9},
    {"gain_error": 0.4, "gain_about": "zero_degC"},
    {"gain_error": 1e-7},
    {},
]


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("turn", range(3))
def test_readings_whose_gains_are_wrong_stay_within_their_bounds(turn: int, arithmetic: Arithmetic) -> None:
    """From every start of the domain on, in rooms that jump; and a bound without the gain is none."""
    tree = network_tree(5, 6)
    sensed = [node for node in tree["network"]["nodes"] if "sensor" in node]
    for k, node in enumerate(sensed):
        node["sensor"] = GAINS[(k + 2 * turn) % len(GAINS)]
    plant = Plant(loaded(tree), arithmetic, 400, turn)
    network = plant.program.network
    assert network is not None
    parts = network.components()
    bounds = np.array([part.proof.bound_K for part in parts])[:, None]
    ends = np.array([part.proof.range_degC for part in parts])
    most = np.zeros(len(parts))
    for sample in range(120):
        most = np.maximum(most, plant.error.max(axis=1))
        assert np.all(plant.error <= bounds)
        shown = plant.board.readings
        assert np.all(ends[:, :1] <= shown)
        assert np.all(shown <= ends[:, 1:])
        assert np.all(plant.states >= network.proof.low)
        assert np.all(plant.states <= network.proof.high)
        if sample % 7 == 0:
            plant.told = plant.draw()
        plant.advance(plant.random.choice([0, 255, -60], plant.lanes))
    assert np.all(most > 0.4 * 2.0**-network.fraction_bits)


@pytest.mark.parametrize("about", ["ambient", "zero_degC"])
def test_what_a_large_gain_shows_fits_its_word(about: str) -> None:
    """A reading up to three times as far from its base as the node is: words as fine as without would overflow."""
    tree = network_tree(8, 1, plain=True)
    without = lower(loaded(tree), "fixed", "table").network
    tree["network"]["nodes"][0]["sensor"] = {"gain_error": 2.0, "gain_about": about}
    network = lower(loaded(tree), "fixed", "table").network
    assert network is not None
    assert without is not None
    low, high = network.components()[0].proof.range_degC
    furthest = max(high - network.channels[0].low / 1000.0, network.channels[0].high / 1000.0 - low, high, -low)
    assert furthest * 2.0**network.fraction_bits < 2.0**31 < furthest * 2.0**without.fraction_bits


def test_a_start_is_read_back_through_every_gain() -> None:
    tree = network_tree(5, 6, plain=True)
    sensed = [node for node in tree["network"]["nodes"] if "sensor" in node]
    for k, node in enumerate(sensed):
        node["sensor"] = GAINS[k % len(GAINS)]
    program = lower(loaded(tree), "fixed", "table")
    chance = np.random.default_rng(8)
    rooms = chance.integers(0, 45_001, (1, 3000))
    asked = {node["name"]: chance.integers(-10_000, 120_001, 3000) - rooms[0] for node in sensed}
    board = reference_of(program, {name: rise.tolist() for name, rise in asked.items()}, rooms)
    assert np.array_equal(board.rises_mK, np.array(list(asked.values())))


def test_the_range_is_no_wider_than_what_is_reached() -> None:
    """The upper end is reached where the worst is held: full PWM, the warmest room, channels at their worst."""
    tree = network_tree(4, 6, plain=True)
    tree["domain"] |= {"temperature_degC": [0, 50], "ambient_degC": [0, 45]}
    for heat in tree["network"]["heats"]:
        heat["power_W"] = {"poly": [heat["power_W"]["poly"][0] * 6, 0, 0]}
    for path in tree["network"]["paths"]:
        path["conductance_W_per_K"] = {"poly": [0.3]}
    model = loaded(tree).model
    assert model.network is not None
    ranges = reachable(model, terms_of(model))
    assert ranges is not None
    m, a, f = model.network.matrices(np.array([255]))
    steady = np.linalg.solve(-m[0], a[0] * 45.0 + f[0])
    assert steady.max() > 60.0
    worst = np.maximum(steady, 50.0)
    assert np.all(ranges.high >= worst)
    assert ranges.high.max() == pytest.approx(worst.max(), abs=0.5)


def test_one_nodes_bound_is_the_closed_form() -> None:
    tree = network_tree(8, 1, plain=True)
    tree["network"]["nodes"] = [{"name": "only", "capacity_J_per_K": 100.0, "sensor": {}}]
    tree["network"]["paths"] = [{"between": ["only", "ambient"], "conductance_W_per_K": {"poly": [0.5]}}]
    tree["network"]["heats"] = [{"node": "only", "power_W": {"poly": [0.1, 0]}}]
    model = loaded(tree).model
    terms: Terms = terms_of(model)
    rate, defect = 0.25 * 0.5 / 100.0, 1e-9
    found = error_bound(terms, np.full((256, 1), defect))
    assert found is not None
    assert found[0] == pytest.approx(defect / (rate * math.exp(-rate)), rel=1e-4)
    # and that is not below the exact accumulation of the same defect in every sample
    assert found[0] >= defect / -math.expm1(-rate)


@pytest.mark.parametrize(
    "factor",
    [
        Factor("c", polynomial=(1.0, 0.0, 0.0)),
        Factor("c", polynomial=(-0.001, 0.02, 0.5)),
        Factor("c", polynomial=(0.002, -0.01, 0.03, 1.0)),
        Factor("c", at=(-5.0, 0.0, 0.003, 8.0), value=(4.0, 0.25, 3.0, 0.0)),
        Factor("c", at=(0.0, 10.0), value=(0.0, 1e-3)),
        Factor("c", polynomial=(7.0,)),
    ],
)
def test_a_factors_word_is_as_near_as_it_says(factor: Factor) -> None:
    channel = Channel("c", -5.0, 10.0, 0.0)
    largest = float(np.max(factor(np.linspace(-5, 10, 1001))))
    program = lower_factor(factor, (channel,), largest, 0)
    told = np.arange(-5000, 10001)
    words = program.word(told)
    exact = np.maximum(factor(told / 1000.0), 0.0)
    assert np.all(np.abs(words * 2.0**-program.bits - exact) <= program.error)
    assert program.error < 2e-7 * max(largest, 1e-3)
    assert words.min() >= 0
    assert words.max() < 2**31


def test_a_bound_above_the_limit_is_no_build() -> None:
    tree = network_tree(4, 6, plain=True)
    tree["accuracy"] = {"fixed_limit_K": 1e-9}
    with pytest.raises(
        CheckFailed, match=r"node n\d: the guaranteed error bound of .* exceeds \$.accuracy.fixed_limit_K"
    ):
        lower(loaded(tree), "fixed", "table")


def test_a_schedule_on_board_is_refused() -> None:
    with pytest.raises(InputError, match="a network is built with tables alone"):
        lower(loaded(network_tree(4, 6, plain=True)), "fixed", "onboard")


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_heat_that_runs_away_at_some_channel_is_no_build_or_no_file(arithmetic: Arithmetic) -> None:
    tree: Tree = network_tree(3, 4)
    tree["network"]["heats"][-1]["per_K"] = 0.1
    tree["network"]["heats"][-1]["power_W"] = {"poly": [40.0, 0.0]}
    with pytest.raises((CheckFailed, InputError), match=r"runs away|settles"):
        lower_network(loaded(tree), arithmetic)


def test_the_issues_goal_for_six_nodes() -> None:
    """1e-5 K without, 1e-4 K with channels that scale a path."""
    plain = [lower_network(loaded(network_tree(seed, 6, plain=True)), "fixed") for seed in range(20, 26)]
    assert max(part.proof.bound_K for made in plain for part in made.components()) <= 1e-5
    told = [lower_network(loaded(network_tree(seed, 6)), "fixed") for seed in range(20, 26)]
    assert max(part.proof.bound_K for made in told for part in made.components()) <= 1e-4


def test_the_example_is_lowered_in_both_arithmetics() -> None:
    coefficients = load("examples/network/coeffs.json")
    for arithmetic in ARITHMETICS:
        assert [part.name for part in lower(coefficients, arithmetic, "table").parts] == list(
            coefficients.model.component_names
        )


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_slow_network_takes_few_orders_of_the_series(arithmetic: Arithmetic) -> None:
    """Its fastest rate is 1/150 1/s, so that the fourth order of a quarter second is below 1e-12 of the whole."""
    network = lower(load("examples/two_nodes/coeffs.json"), arithmetic, "table").network
    assert network is not None
    assert network.orders <= 3


@pytest.mark.parametrize("shift", [0, 4, 8, 12, 16, 20])
def test_a_heat_errs_by_half_a_unit_of_the_word_that_it_has(shift: int) -> None:
    """It is rounded to nearest; where 32 bits are too few it is coarser: the unit is what one more of it means."""
    model = loaded(network_tree(3, 5, plain=True)).model
    terms = terms_of(model)
    ranges = reachable(model, terms)
    assert ranges is not None
    shape = FixedFormat(20, (shift,) * len(terms.states))
    cold = replace(terms, heats=())
    errors = [roundings(each, ranges, shape, (), (FIRST,), ()).first.max(axis=0) for each in (terms, cold)]
    assert terms.heats
    for target in range(len(terms.states)):
        half = 0.0
        for program in heat_programs(terms, target, shape, ()):
            row = int(program.words.argmax())
            assert program.words[row] > 10_000
            half += 0.5 * float(program.heat.heat[row]) / int(program.words[row])
        assert errors[0][target] - errors[1][target] == pytest.approx(half, rel=1e-3)
