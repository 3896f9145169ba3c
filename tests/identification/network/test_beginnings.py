"""What a search for a network begins with and what it holds against a smaller one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gen.identification.network.fitting.bins import LONGEST_S, SHORTEST_S, binned
from gen.identification.network.fitting.inputs import inputs_of
from gen.identification.network.fitting.scale import scale_of
from gen.identification.network.prune import OBJECTION, _objected
from gen.runs import Run


def test_each_part_alone_is_known_by_how_fast_it_settles_and_how_far_it_rises() -> None:
    """Two parts of one time constant each, warmed at full speed and at half of it, by their closed form."""
    time = 4.0 * np.arange(1350, dtype=np.float64)
    rises, taus = {"fast": 60.0, "slow": 25.0}, {"fast": 300.0, "slow": 1500.0}
    runs = []
    for number, pwm in enumerate((255, 128)):
        settled = {name: 25.0 + rise * (pwm / 255.0) ** 2 for name, rise in rises.items()}
        temps = {name: end + (25.0 - end) * np.exp(-time / taus[name]) for name, end in settled.items()}
        held = np.full(time.size, pwm, dtype=np.int64)
        runs.append(binned(f"r{number}", Run(time, held, temps), tuple(rises), 25.0, 255))
    found = scale_of(inputs_of(runs))
    assert found.rise == pytest.approx(list(rises.values()), rel=0.15)
    assert found.settling == pytest.approx(list(taus.values()), rel=0.3)  # the grid's step is half as much again


@pytest.mark.parametrize("held_s", [47, 61, 333, 1234])
def test_bins_grow_from_each_change_of_pwm_and_none_is_a_sliver(held_s: int) -> None:
    """A reading or two would be as weighty as a bin's mean; and what is fast is over soon after a change."""
    time = np.arange(0.0, 4.0 * held_s + 1.0)
    pwm = np.where(time // held_s % 2 == 0, 200, 0).astype(np.int64)
    found = binned("run", Run(time, pwm, {"part": np.full(time.size, 30.0)}), ("part",), 25.0, 255)
    changes = held_s * np.arange(5.0)
    assert set(changes) <= set(found.edges.tolist())
    assert np.all(found.width >= 0.5 * SHORTEST_S)
    assert np.all(found.width <= 1.5 * LONGEST_S)
    begin = found.edges[:-1] - changes[np.searchsorted(changes, found.edges[:-1], side="right") - 1]
    assert np.all(found.width[begin == 0.0] == SHORTEST_S)
    assert np.all(found.width <= np.maximum(1.5 * SHORTEST_S, 0.5 * begin))


@pytest.mark.parametrize(("more", "objected"), [(0.9, False), (1.1, True)])
@pytest.mark.parametrize("cut", [1, 3])
def test_runs_speak_against_a_cut_by_so_much_for_each_number_that_is_cut(cut: int, more: float, objected: bool) -> None:
    weight = np.array([0.5, 2.0])
    residual = np.sqrt((100.0 + more * OBJECTION * cut) / weight / 2.0)
    found: Any = SimpleNamespace(
        problem=SimpleNamespace(inputs=SimpleNamespace(weight=weight)),
        fit=SimpleNamespace(evaluated=SimpleNamespace(cost=100.0)),
        structure=SimpleNamespace(size=12),
    )
    smaller: Any = SimpleNamespace(
        fit=SimpleNamespace(evaluated=SimpleNamespace(residual=residual)), structure=SimpleNamespace(size=12 - cut)
    )
    assert _objected(found, smaller) is objected


@pytest.mark.parametrize(("rise", "tau"), [(4.0, 12.0), (8.0, 40.0), (0.0, 40.0)])
def test_a_run_begins_where_its_first_readings_are_however_fast_it_warms(rise: float, tau: float) -> None:
    """A light part may have half of its rise after ten seconds: a line through its first minute begins late."""
    time = np.arange(0.0, 600.0, 0.25)
    noise = np.random.default_rng(5).normal(0.0, 0.1, time.size)
    run = Run(time, np.full(time.size, 200), {"part": 22.0 + rise * (1.0 - np.exp(-time / tau)) + noise})
    assert binned("run", run, ("part",), 22.0, 255).begin == pytest.approx([22.0], abs=0.15)
