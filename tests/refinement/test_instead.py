"""A file with transfer functions whose parts do not explain the runs, and the network that does."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import gen
from gen.cli import cli
from gen.coefficients import in_place_of_parts, parse
from gen.refinement.instead import refine as instead_refine
from gen.refinement.instead.network import Instead, network_instead
from gen.refinement.instead.refine import RefinedAsNetwork
from gen.refinement.instead.settling import Elsewhere
from gen.runs import write_run
from tests.examples import ROOT
from tests.identification.network.plant import Plant, holds

MOTOR = Plant(
    capacity=(80.0, 300.0, 150.0),
    links=((0, 1, 0.6), (1, 2, 0.4)),
    surfaces=((0, 0.25, 0.3), (2, 0.05, 0.1)),
    heats=((1, 5.0, 12.0),),
    sensed={"casing": 0, "bearing": 2},
)
"""A rotor without a sensor heats its casing and a bearing: neither follows the PWM by a lag of its own."""
WORN = replace(MOTOR, heats=((1, 5.0, 12.0), (2, 1.0, 1.5)))
"""The bearing heats, too."""
RULE = {
    "name": "hot",
    "kind": "above_model",
    "component": "casing",
    "threshold_K": 3.0,
    "speed_percent": [20, 100],
    "hysteresis_K": 1.0,
    "persistence_s": 60,
    "settle_s": 600,
}


@dataclass(frozen=True)
class Bench:
    """A motor identified part by part from cold steps, and later runs at changing speeds; the last is for the test."""

    model: gen.Model
    runs: list[Path]
    worn: list[Path]


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    folder, rng = tmp_path_factory.mktemp("runs"), np.random.default_rng(0)
    cold: list[Path] = []
    runs: list[Path] = []
    worn: list[Path] = []
    for speed in (60, 120, 180, 255):
        cold.append(folder / f"cold{speed}.csv")
        write_run(cold[-1], MOTOR.run(holds((speed, 90)), rng, noise=0.05))
    for number in range(3):
        speeds = rng.integers(60, 255, 4)
        pwm = holds(*((int(speed), 25) for speed in speeds), (0, 30))
        for plant, into in ((MOTOR, runs), (WORN, worn)):
            into.append(folder / f"{'worn' if plant is WORN else 'run'}{number}.csv")
            write_run(into[-1], plant.run(pwm, rng, noise=0.05))
    found = gen.identify(cold, model="parts", name="bench").model
    tree = json.loads(found.text) | {"description": "on the bench", "alarms": [RULE]}
    path = folder / "coeffs.json"
    path.write_text(json.dumps(tree))
    return Bench(gen.load(path), runs, worn)


@pytest.fixture(scope="module")
def refined(bench: Bench) -> gen.Refinement:
    return gen.refine(bench.model, fit=bench.runs[:2], test=bench.runs[2:])


def test_runs_that_parts_do_not_explain_are_explained_by_one_network(refined: gen.Refinement) -> None:
    errors = refined.errors()
    assert errors["before_rmse_K"].min() > 0.5
    assert errors["after_rmse_K"].max() < 0.12, "its sensors have 0.09 K"
    assert refined.verdict == "explained"
    assert isinstance(refined.found, RefinedAsNetwork)
    assert refined.found.lead.startswith("a network explains this, parts alone do not")
    told = refined.details()["instead_of_parts"]
    assert told["error_K"]["network"] < 0.6 * told["error_K"]["parts"], "of one run, by the other alone"
    assert told["settles_elsewhere"] == []


def test_what_the_file_holds_beside_its_model_stays(bench: Bench, refined: gen.Refinement) -> None:
    before, after = json.loads(bench.model.text), json.loads(refined.model.text)
    assert "network" in after
    assert "components" not in after
    for key in ("name", "description", "input", "domain", "alarms", "sample_time_s"):
        assert after[key] == before[key]
    assert set(refined.model.components) == {"casing", "bearing"}


def test_the_error_told_is_what_the_new_file_gives(bench: Bench, refined: gen.Refinement) -> None:
    read, shown = gen.read_run(bench.runs[2]), gen.simulate(refined.model, bench.runs[2])
    error = np.sqrt(np.mean((shown["casing_degC"] - read["casing_degC"]).to_numpy() ** 2))
    told = refined.errors().loc[("test", bench.runs[2].stem, "casing"), "after_rmse_K"]
    assert told == pytest.approx(error, rel=1e-6)


def test_the_report_says_what_took_the_parts_place(refined: gen.Refinement) -> None:
    page = refined.html()
    assert "A network explains this, parts alone do not" in page
    assert page.count('class="network"') == 1, "nothing was found in it, so there is one to draw"


def test_a_worn_bearing_is_another_motor(bench: Bench) -> None:
    """The file knows where its parts settle; a network of the worn motor's own runs has the bearing warmer."""
    found = network_instead(
        bench.model.coefficients, bench.model.text, bench.model.coefficients, bench.worn, lambda _: None
    )
    assert found is not None
    warmer = {one.part: one for one in found.elsewhere}
    assert "bearing" in warmer
    assert warmer["bearing"].network_K > warmer["bearing"].file_K + 1.0
    assert "the motor has changed since the file was made, or the file was wrong there" in found.other_motor


def _elsewhere(monkeypatch: pytest.MonkeyPatch, refined: gen.Refinement) -> None:
    """Have the network that was found settle elsewhere."""
    assert isinstance(refined.found, RefinedAsNetwork)
    other: Instead = replace(refined.found.instead, elsewhere=(Elsewhere("bearing", 120, 40.0, 30.0),))
    monkeypatch.setattr(instead_refine, "network_instead", lambda *_: other)


def test_another_motor_is_told_and_written_only_where_that_is_asked_for(
    bench: Bench, refined: gen.Refinement, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    _elsewhere(monkeypatch, refined)
    (tmp_path / "c.json").write_text(bench.model.text)
    out, command = tmp_path / "out.json", ["refine", str(tmp_path / "c.json"), "--out", str(tmp_path / "out.json")]
    files = ["--fit", *map(str, bench.runs[:2]), "--test", str(bench.runs[2])]
    done = CliRunner().invoke(cli, [*command, *files])
    assert done.exit_code == 0
    assert "not written without --accept-change" in done.stderr
    assert "bearing settles 10 K warmer at PWM 120 than the file and its error allow (40 K, not 30 K)" in done.stderr
    assert "network" not in json.loads(out.read_text())
    done = CliRunner().invoke(cli, [*command, *files, "--accept-change"])
    assert done.exit_code == 0
    assert "bearing settles 10 K warmer" in done.stderr
    assert "a network explains this" in done.stdout
    assert "network" in json.loads(out.read_text())


def test_a_single_run_tells_nothing_of_another_model(bench: Bench) -> None:
    model = bench.model
    assert network_instead(model.coefficients, model.text, model.coefficients, bench.runs[:1], lambda _: None) is None


def test_effects_beside_transfer_functions_leave_with_them() -> None:
    """And so does an ambient that acts at once, which no network's does."""
    parts = json.loads((ROOT / "examples" / "two_mass_refined" / "coeffs.json").read_text())
    network = (ROOT / "examples" / "my1016_rig" / "network.json").read_text()
    made = json.loads(in_place_of_parts(json.dumps(parts | {"ambient": {"fixed_degC": 25, "at_once": True}}), network))
    assert "effects" in parts
    assert "effects" not in made
    assert made["ambient"] == {"fixed_degC": 25}
    assert made["network"] == json.loads(network)["network"]
    assert parse(json.dumps(made | {"wiring": None, "alarms": []}).encode()).model.network is not None
