"""What motors share before any was fitted, and what is the same effect at motors with candidates of their own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gen.errors import CheckFailed
from gen.fleet.statistics.shared_effects import key_of, variants
from gen.fleet.tasks.common import begun, structure_json, structure_of
from gen.identification.network.fitting.priors import OFFSET_K
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.structure import full


def candidate(name: str, component: str, begins: float, by: str = "") -> Any:  # noqa: ANN401
    return SimpleNamespace(name=name, component=component, acts_by={"channel": by} if by else {}, begins=begins)


def test_candidates_that_begin_elsewhere_are_one_effect() -> None:
    every = [
        candidate("hidden_node", "brush", 1.0),
        candidate("sensor_gain", "brush", 2.0),
        candidate("hidden_node", "casing", 3.0),
        candidate("hidden_node", "brush", 4.0),
        candidate("hidden_node", "brush", 5.0, by="fan_mps"),
    ]
    assert variants(every, key_of(every[0])) == [every[0], every[3]]
    with pytest.raises(CheckFailed, match="cannot act on this motor"):
        variants(every[1:3], key_of(every[0]))


def test_a_fleet_begins_with_offsets_as_wide_as_one_motors() -> None:
    structure = full(("casing", "brush"), 1)
    vector = np.linspace(1.0, 2.0, structure.size)
    common = begun(structure, vector, Scale(np.ones(2), np.ones(2)), np.ones(2))
    offsets = np.zeros(structure.size, dtype=bool)
    offsets[structure.offsets] = True
    assert np.allclose(np.sqrt(common.pool.variance[offsets]), OFFSET_K)
    assert np.all(common.pool.mean[offsets] == 0.0)
    assert np.array_equal(common.pool.mean[~offsets], vector[~offsets])


def test_how_warm_runs_begin_says_nothing_of_a_motor() -> None:
    structure = full(("casing", "brush"), 1, apart=0.1)
    common = begun(structure, np.ones(structure.size), Scale(np.ones(2), np.ones(2)), np.ones(2))
    assert structure.factors.size == 1
    assert np.all(common.fixed[structure.factors])
    assert np.all(common.pool.mean[structure.factors] == 0.0)
    assert structure_of(structure_json(structure)) == structure
