"""A thermocouple that goes wild while the motor runs takes part in no refinement; what was wild is known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

import gen
from gen.coefficients import load
from gen.refinement.condense import read_measured
from gen.runs import read_run, write_run
from tests.refinement.network.motor import Tree, read, run, tree, write
from tests.refinement.plant import COEFFICIENTS
from tests.refinement.plant_effects import make


def spoil(path: Path, part: str, seed: int) -> int:
    """A tenth of a sensor's readings in a third of a run, 90 K to 150 K low; gives how many."""
    chance = np.random.default_rng(seed)
    sound = read_run(path)
    third = sound.time_s.size // 3
    wild = np.zeros(sound.time_s.size, dtype=bool)
    wild[third : 2 * third] = chance.random(third) < 0.1
    values = np.where(wild, sound.temps[part] - chance.uniform(90.0, 150.0, wild.size), sound.temps[part])
    write_run(path, replace(sound, temps={**sound.temps, part: values}))
    return int(np.count_nonzero(wild))


def test_wild_readings_are_left_out_of_transfer_functions_and_said(tmp_path: Path) -> None:
    fit, test, _ = make(tmp_path, ("hidden_node",), 11)
    motor = gen.load(COEFFICIENTS)
    sound = gen.refine(motor, fit=fit, test=test)
    counts = {str(path): spoil(path, "casing", seed) for seed, path in enumerate((*fit[:3], test[0]))}
    found = gen.refine(motor, fit=fit, test=test)
    effects = found.effects()
    assert (
        effects[["component", "effect"]].to_numpy().tolist()
        == sound.effects()[["component", "effect"]].to_numpy().tolist()
    )
    assert found.verdict == sound.verdict
    for key in ("before", "after"):
        wild, clean = (one.details()[key]["test"]["rmse_K"] for one in (found, sound))
        assert abs(wild - clean) < 0.02
    said = [warning for warning in found.warnings if "not believed" in warning]
    assert [warning.partition(": ")[0] for warning in said] == list(counts)
    for warning, count in zip(said, counts.values(), strict=True):
        assert f"casing_degC: {count} of " in warning
        assert warning in found.html()


def test_wild_readings_are_left_out_of_a_network_and_said(tmp_path: Path) -> None:
    motor: Tree = tree()
    baseline = tmp_path / "small.json"
    baseline.write_text(json.dumps(motor), encoding="utf-8")
    motor["network"]["heats"][0]["power_W"]["poly"][1] *= 1.3
    runs = [write(run(read(motor), seed), tmp_path / f"run_{seed}.csv") for seed in (1, 2, 3)]
    sound = gen.refine(gen.load(baseline), fit=runs[:2], test=runs[2:])
    for seed, path in enumerate(runs):
        spoil(path, "winding", seed)
    found = gen.refine(gen.load(baseline), fit=runs[:2], test=runs[2:])
    assert found.verdict == sound.verdict
    assert found.effects()["effect"].tolist() == sound.effects()["effect"].tolist()
    for key in ("before", "after"):
        wild, clean = (one.details()[key]["test"]["rmse_K"] for one in (found, sound))
        assert abs(wild - clean) < 0.05
    said = [warning for warning in found.warnings if "not believed" in warning]
    assert [warning.partition(": ")[0] for warning in said] == [str(path) for path in runs]
    assert all(warning in found.html() for warning in said)


def test_what_the_file_says_of_a_thermocouple_holds(tmp_path: Path) -> None:
    """A part that may change by 50 K/s is believed where another is not."""
    motor = json.loads(COEFFICIENTS.read_text(encoding="utf-8"))
    path = tmp_path / "run.csv"
    rows = [f"{k},100,{30 + 30 * (k % 40 == 20)},30" for k in range(80)]
    path.write_text("time_s,pwm,brush_degC,bearing_degC\n" + "\n".join(rows) + "\n", encoding="utf-8")
    assert np.isnan(read_measured(load(COEFFICIENTS), path).temps["brush"]).sum() == 2
    for thermocouple in motor["wiring"]["thermocouples"]:
        thermocouple["max_rate_K_per_s"] = 50.0
    changed = tmp_path / "quick.json"
    changed.write_text(json.dumps(motor), encoding="utf-8")
    assert not np.isnan(read_measured(load(changed), path).temps["brush"]).any()
