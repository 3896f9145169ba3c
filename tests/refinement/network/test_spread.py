"""What acts on several parts is found at all of them, each by a number of its own; what acts on one, at that one."""

from __future__ import annotations

import pytest

from gen.refinement.network.anchored import Anchored
from gen.refinement.network.data import make_data
from gen.refinement.network.effects import candidates
from gen.refinement.network.fit import Bench
from gen.refinement.network.judged import judged
from gen.refinement.network.trace import Considered, one_more
from tests.refinement.network.motor import Tree, read, run, tree, wave


def found(name: str, other: Tree, column: str | None = None) -> Considered:
    """The best of one name, where a motor has become another."""
    file = read(tree())
    assert file.model.network is not None
    told = [{} if column is None else {column: wave(10 * seed, 0.0, 6.0)} for seed in (1, 2)]
    runs = [(f"run {seed}", run(read(other), seed, told[seed - 1])) for seed in (1, 2)]
    bench = Bench(make_data(file, runs))
    base = bench.first(Anchored(file.model.network, 255, bench.data.columns))
    offered = [one for one in candidates(base.shape.motor(), bench.data.offered) if one.name == name]
    step = one_more(bench, judged(bench.data, base, bench.left_out(base)), offered, lambda _: None)
    assert step.added is not None
    assert step.added in step.considered
    return step.added


def backwards(*more: float) -> Tree:
    """The motor with more heat at both nodes while it turns backwards."""
    other = tree()
    other["network"]["channels"] = [{"column": "pwm", "range": [-255, 255], "neutral": 0}]
    for heat, each in zip(other["network"]["heats"], more, strict=True):
        heat["factors"] = [{"channel": "pwm", "table": {"at": [-1, 0], "value": [1.0 + each, 1.0]}}]
    return other


def test_both_nodes_that_heat_otherwise_backwards_are_found_together() -> None:
    direction = found("direction", backwards(0.3, 0.6))
    assert direction.effect.component == "motor"
    assert direction.values == pytest.approx((0.3, 0.6), abs=0.06)


def test_one_node_that_does_is_found_alone() -> None:
    direction = found("direction", backwards(0.0, 0.6))
    assert direction.effect.component == "casing"
    assert direction.values == pytest.approx((0.6,), abs=0.06)


def test_a_current_that_heats_two_nodes_heats_both_by_a_resistance_of_each() -> None:
    other = tree()
    other["network"]["channels"] = [{"column": "load_A", "range": [0, 10], "neutral": 0}]
    by_current = {"channel": "load_A", "poly": [1.0, 0.0, 0.0]}
    for node, resistance in (("winding", 0.15), ("casing", 0.3)):
        other["network"]["heats"].append({"node": node, "power_W": {"poly": [resistance]}, "factors": [by_current]})
    load = found("load_heating", other, "load_A")
    assert load.effect.component == "motor"
    assert load.values == pytest.approx((0.15, 0.3, 1.0, 1.0), rel=0.1)
