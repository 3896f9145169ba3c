"""Missing heat beside a board's rows: computed from them, and out of the memory of an emulated board."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, load, parse
from gen.coefficients.alarms import MissingHeat
from gen.live.heat import HeatFromRows, Row
from gen.live.known import known_of
from gen.live.view import View
from gen.lowering.heat import lower_heat
from gen.reference.heat import watched
from gen.reference.heat_blocks import blocks_of, sums_after
from gen.reference.sampled import sampled
from gen.reference.simulate import simulate_run
from gen.runs import Run
from tests.live.serving import wait_until
from tests.live.test_sources import EXAMPLE, FAULT, column, emulated

RULES = ["heat", "brush_fault", "bearing_fault"]


@pytest.fixture(scope="module")
def example() -> Coefficients:
    return load(EXAMPLE)


def rows_of(run: Run, model: dict[str, Any]) -> list[Row]:
    columns = {**run.columns(), **{f"{name}_model_degC": model[f"{name}_degC"] for name in run.temps}}
    return [
        {name: None if np.isnan(values[k]) else float(values[k]) for name, values in columns.items()}
        for k in range(run.time_s.size)
    ]


def a_run(example: Coefficients, every_s: Sequence[float], begin_degC: float) -> tuple[Run, dict[str, Any]]:
    """A motor that gets warmer than its model, with a sensor that is lost for a while and changes of PWM."""
    generator = np.random.default_rng(3)
    time_s = np.concatenate([[0.0], np.cumsum(generator.choice(every_s, 3000))])
    names = example.model.component_names
    pwm = np.array([100, 180, 180, 60])[(time_s / 400.0).astype(int) % 4]
    ambient = np.full(time_s.size, 30.0)
    first = Run(time_s, pwm, {name: np.full(time_s.size, begin_degC) for name in names}, ambient)
    model = {key: np.round(values, 3) for key, values in simulate_run(example, first, "exact", "auto", "run").items()}
    faulty = {name: (-1.0 if name == "brush" else 1.0) * 0.02 * np.maximum(time_s - 300.0, 0.0) for name in names}
    temps = {name: np.round(4.0 * (model[f"{name}_degC"] + faulty[name])) / 4.0 for name in names}
    temps["magnet"][(time_s > 500.0) & (time_s < 560.0)] = np.nan
    return Run(time_s, pwm, temps, ambient), model


def expected(example: Coefficients, run: Run, model: dict[str, Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Sums after each block, % of the threshold, by the code that finds thresholds: whole records at once."""
    rules = [rule for rule in example.document.alarms if isinstance(rule, MissingHeat)]
    lowered = [lower_heat(example.document, example.model, rule) for rule in rules]
    given = sampled(example.model, run, {name: model[f"{name}_degC"] for name in run.temps})
    blocks = blocks_of(lowered[0].block, watched(lowered), given.pwm, given.measured_mC - given.model_mC, given.valid)
    sums = sums_after(lowered, [blocks], np.array([given.trusted]))
    return np.array([100.0 * sums[k, 0] / lowered[k].limit for k in range(len(rules))])


@pytest.mark.parametrize("begin_degC", [30.0, 45.0])
def test_rows_of_every_sample_give_the_board_s_sums(example: Coefficients, begin_degC: float) -> None:
    run, model = a_run(example, [0.25], begin_degC)
    heat = HeatFromRows(example)
    found = [heat.take(row) for row in rows_of(run, model)]
    assert [rule.name for rule in heat.rules] == RULES
    sums = expected(example, run, model)
    assert np.array(found, dtype=float).T[:, 80::80].tolist() == sums.tolist()
    assert np.all(sums.max(axis=1) > 100.0)
    assert len(set(sums[0])) > 5


def test_rows_now_and_then_are_held_until_the_next_one(example: Coefficients) -> None:
    run, model = a_run(example, [0.25, 0.5, 1.0, 2.75], 30.0)
    complete = {name: np.where(np.isnan(values), 40.0, values) for name, values in run.temps.items()}
    run = Run(run.time_s, run.pwm, complete, run.ambient)  # of what is missing both think otherwise
    heat = HeatFromRows(example)
    found = np.array([heat.take(row) for row in rows_of(run, model)], dtype=float).T
    sums = expected(example, run, model)
    blocks = np.searchsorted(run.time_s, 20.0 * np.arange(1, sums.shape[1] + 1) - 1e-6)
    np.testing.assert_allclose(found[:, blocks], sums, atol=1.0)  # a row's thousandth of a kelvin, rounded otherwise
    assert np.all(sums.max(axis=1) > 100.0)


def test_the_end_of_an_alarm_begins_the_sum_anew(example: Coefficients) -> None:
    run, model = a_run(example, [0.25], 30.0)
    rows = rows_of(run, model)
    heat = HeatFromRows(example)
    for row in rows[:-2]:
        before = heat.take({**row, "alarms": 4.0})
    after = heat.take({**rows[-2], "alarms": 0.0})
    assert (before[0] or 0.0) > 0.0
    assert after == [0.0, 0.0, 0.0]


def test_rows_without_a_model_s_temperatures_have_none(example: Coefficients) -> None:
    heat = HeatFromRows(example)
    rows: list[Row] = [{"time_s": float(k), "pwm": 100.0, "casing_degC": 30.0} for k in range(50)]
    assert [heat.take(row) for row in rows] == [[None] * 3] * 50


def test_hours_without_a_row_are_passed_at_once(example: Coefficients) -> None:
    run, model = a_run(example, [1.0], 30.0)
    heat = HeatFromRows(example)
    rows = rows_of(run, model)
    for row in [*rows[:100], {**rows[100], "time_s": 1e9}]:
        found = heat.take(row)
    assert all(value is not None for value in found)


def test_a_view_has_a_column_for_each_rule(example: Coefficients) -> None:
    view = View(known_of(example), HeatFromRows(example))
    view.feed(b"time_s,pwm,casing_degC,casing_model_degC,time_to_limit_s\n0,0,30,30,\n1,0,30,30,60\n", 0.0)
    assert view.columns()[-3:] == [f"{name}_missing_percent" for name in RULES]
    assert view.since(0)[1][-3:] == [0.0, 0.0, 0.0]
    assert view.history(100)["curves"]["heat_missing_percent"] == [[0.0, 1.0], [0.0, 0.0]]
    assert view.history(100)["curves"]["time_to_limit_s"] == [[1.0], [60.0]]


def changes(values: Sequence[float | None]) -> list[float]:
    known = [value for value in values if value is not None]
    return [known[0], *(after for before, after in pairwise(known) if after != before)]


def test_an_emulated_board_s_memory_and_its_rows_say_the_same(tmp_path: Path) -> None:
    """The firmware's words, against those that are computed from what it prints each sample."""
    tree = json.loads(EXAMPLE.read_text(encoding="utf-8"))
    tree["wiring"]["row_every_s"] = 0.25
    known = parse(json.dumps(tree).encode())
    source = emulated(known, tmp_path)
    source.start()
    try:
        wait_until(lambda: source.view.recorder.rows > 2)
        source.send(b"arm\n200\n")
        source.change("fault", FAULT)
        wait_until(lambda: "heat" in source.view.status()["alarms"])
    finally:
        source.stop()
    heat = HeatFromRows(known)
    names = source.view.columns()
    computed = [heat.take(dict(zip(names, row, strict=True))) for row in source.view.since(0)]
    for place, rule in enumerate(heat.rules):
        board, rows = changes(column(source, rule.column)), changes([values[place] for values in computed])
        assert board[: len(rows)] == rows[: len(board)]
        assert abs(len(board) - len(rows)) <= 1  # the memory is looked at when a row has come
    assert max(value or 0.0 for value in column(source, "heat_missing_percent")) >= 100.0
