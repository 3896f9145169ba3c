"""A channel is taken for a flow of air by how it moves, and not by being there."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.tracing.search import NOT_BY_THE_CHANNEL
from gen.refinement.network.tracing.trace import Traced, trace
from tests.refinement.network.motor import HOURS, ROW_S, Tree, read, run, tree

ROWS = int(HOURS * 3600.0 / ROW_S)


def humidity(seed: int) -> FloatArray:
    """Between 38 and 52 %, slowly."""
    time = ROW_S * np.arange(ROWS)
    return np.asarray(45.0 + 7.0 * np.sin(time / (1900.0 + 400.0 * seed) + seed))


def fan(seed: int) -> FloatArray:
    """On and off, for ten minutes to forty."""
    chance, made, at = np.random.default_rng(seed), np.zeros(ROWS), 0
    while at < ROWS:
        length = int(chance.uniform(600.0, 2400.0) / ROW_S)
        made[at : at + length] = 3.0 * (chance.random() < 0.5)
        at += length
    return made


def traced(other: Tree, column: str, values: list[FloatArray]) -> Traced:
    """Trace two runs of a motor that has become another."""
    file = read(tree())
    assert file.model.network is not None
    runs = [(f"run {k}", run(read(other), k, {column: each})) for k, each in enumerate(values, start=1)]
    data = make_data(file, runs)
    return trace(data, Anchored.of(file.model.network, 255, data.columns), lambda _: None)


def test_a_humidity_is_no_flow_although_more_of_it_would_cool() -> None:
    other = tree()
    other["network"]["paths"][1]["conductance_W_per_K"] = {
        "power": {"constant": 0.27, "forced": 0.4, "exponent": 0.8},
        "at_rest": 0.24,
    }
    found = traced(other, "humidity_pct", [humidity(1), humidity(2)])
    judged = [one for step in found.steps for one in step.considered if one.effect.name == "airflow"]
    assert any(NOT_BY_THE_CHANNEL in one.reasons for one in judged)
    assert "airflow" not in found.final.names


def test_a_fan_is_one() -> None:
    other = tree()
    other["network"]["paths"][1]["factors"] = [{"channel": "fan_m_s", "poly": [0.3, 1.0]}]
    other["network"]["channels"] = [{"column": "fan_m_s", "range": [0.0, 3.0], "neutral": 0.0}]
    found = traced(other, "fan_m_s", [fan(1), fan(2)])
    assert found.final.names[0] == "airflow"
