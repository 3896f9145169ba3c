"""Ways of heat that were lost, and a room's sensor that hangs elsewhere: told by their names, and not learnt as others.

Each motor is the file's with one thing changed, solved exactly.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

import gen
from gen.cli import cli
from tests.refinement.network.motor import NOISE_K, Tree, finned, read, run, tree, write
from tests.refinement.network.test_refine_network import error_K, files, refined


def blocked() -> Tree:
    """What speed adds to the casing's cooling is down to a third; at rest it loses what it did."""
    motor = tree()
    motor["network"]["paths"][1]["conductance_W_per_K"]["power"] = {"constant": 0.2, "forced": 0.1, "exponent": 0.8}
    return motor


def test_blocked_vents_are_told_and_not_learnt(tmp_path: Path) -> None:
    """Heat that grows with temperature looks like it, and would be learnt as what healthy motors do."""
    found = refined(blocked(), tmp_path)
    (effect,) = found.details()["effects"]
    assert (effect["name"], effect["component"], effect["parameters"]["other"]) == ("path_change", "casing", "ambient")
    # 0.02 W/K of it are there from the slowest speed on, beyond what there is at rest.
    assert effect["parameters"]["factor_of_what_speed_adds"] == pytest.approx(1.0 / 3.0, abs=0.06)
    assert (effect["changed"], effect["written"]) == (True, False)
    assert found.model.text == found.baseline.text
    assert "blocked vents" in " ".join(found.warnings)
    assert found.verdict == "partly explained"


def loose(motor: Tree) -> Tree:
    """The winding's sensor shows 0.85 of the rise."""
    motor["network"]["nodes"][0]["sensor"] |= {"gain_error": -0.15}
    return motor


def test_a_loose_sensor_is_told_beside_blocked_vents(tmp_path: Path) -> None:
    """A search that ends in the change would leave it to be found once the vents are open."""
    found = refined(loose(blocked()), tmp_path)
    change, sensor = found.details()["effects"]
    assert (change["name"], change["changed"], change["written"]) == ("path_change", True, False)
    assert (sensor["name"], sensor["component"], sensor["changed"]) == ("sensor_gain", "winding", False)
    assert sensor["parameters"]["gain_error"] == pytest.approx(-0.15, abs=0.02)
    # The motor is warmer by more than the sensor hides: a file that knows the sensor alone would miss the runs by more.
    assert not sensor["written"]
    assert found.model.text == found.baseline.text
    assert any("right beside it alone" in warning for warning in found.warnings)
    assert found.verdict == "partly explained"


def test_what_was_accepted_is_in_the_file(tmp_path: Path) -> None:
    refined(blocked(), tmp_path)  # leaves its files
    baseline = gen.load(tmp_path / "small.json")
    runs = [tmp_path / f"run_{seed}.csv" for seed in (1, 2, 3)]
    accepted = gen.refine(baseline, fit=runs[:2], test=runs[2:], accept_change=True)
    assert error_K(accepted, tmp_path) < 1.2 * NOISE_K
    network, before = accepted.model.coefficients.model.network, baseline.coefficients.model.network
    assert network is not None
    assert before is not None
    outside = [number for number, path in enumerate(network.paths) if path.second is None]
    assert network.conductances[0, outside] == pytest.approx(before.conductances[0, outside], rel=0.1)
    assert network.conductances[255, outside] == pytest.approx(0.3, rel=0.1)


@pytest.mark.parametrize("share", [0.2, 0.4])
def test_a_joint_that_came_loose_is_told_with_both_its_ends(share: float, tmp_path: Path) -> None:
    motor = tree()
    motor["network"]["paths"][0]["conductance_W_per_K"] = {"poly": [0.5 * share]}
    found = refined(motor, tmp_path)
    (effect,) = found.details()["effects"]
    assert (effect["name"], effect["component"], effect["parameters"]["other"]) == ("path_change", "winding", "casing")
    assert effect["parameters"]["factor"] == pytest.approx(share, rel=0.1)
    assert f"winding to casing conducts {effect['parameters']['factor']:.2g} times what it did" in found.warnings[0]
    assert found.model.text == found.baseline.text


def test_a_part_that_came_off_altogether_is_told_as_well(tmp_path: Path) -> None:
    """How little is left no run tells: that is no reason to doubt it."""
    motor = finned()
    joint = next(path for path in motor["network"]["paths"] if set(path["between"]) == {"casing", "fins"})
    joint["conductance_W_per_K"] = {"poly": [1e-4]}
    one, two, three = files(motor, tmp_path)
    (tmp_path / "finned.json").write_text(json.dumps(finned()), encoding="utf-8")
    found = gen.refine(gen.load(tmp_path / "finned.json"), fit=[one, two], test=[three])
    (effect,) = found.details()["effects"]
    assert (effect["name"], {effect["component"], effect["parameters"]["other"]}) == ("path_change", {"casing", "fins"})
    assert effect["parameters"]["factor"] < 0.05
    assert "conducts next to nothing of what it did" in found.warnings[0]


def test_heat_that_grows_by_more_than_metals_do_is_told_and_not_learnt(tmp_path: Path) -> None:
    """What cools less than it did can look like it; no healthy motor does so."""
    motor = tree()
    motor["network"]["heats"][0] |= {"per_K": 0.02, "reference_degC": 25}
    found = refined(motor, tmp_path)
    (effect,) = found.details()["effects"]
    assert (effect["name"], effect["component"]) == ("temperature_dependent_loss", "winding")
    assert effect["parameters"]["per_K"] == pytest.approx(0.02, rel=0.15)
    assert (effect["changed"], effect["written"]) == (True, False)
    assert "copper and magnets come to less than 1.2%" in found.warnings[0]


def test_a_room_sensor_that_reads_too_much_is_one_sensor(tmp_path: Path) -> None:
    """And not as many as the motor has, each of which reads too little."""
    base = read(tree())
    paths = []
    for seed in (1, 2, 3):
        one = run(base, seed)
        assert one.ambient is not None
        paths.append(write(replace(one, ambient=one.ambient + 1.5), tmp_path / f"run_{seed}.csv"))
    file = tmp_path / "small.json"
    file.write_text(json.dumps(tree()), encoding="utf-8")
    found = gen.refine(gen.load(file), fit=paths[:2], test=paths[2:])
    (effect,) = found.details()["effects"]
    assert (effect["name"], effect["component"]) == ("sensor_offset", "ambient")
    assert effect["parameters"]["offset_K"] == pytest.approx(1.5, abs=0.1)
    assert error_K(found, tmp_path) < 1.2 * NOISE_K
    assert found.verdict == "explained"


def test_a_file_that_the_runs_bend_by_little_has_not_changed(tmp_path: Path) -> None:
    """A tenth more or less is what a file may be off by."""
    motor = tree()
    motor["network"]["paths"][0]["conductance_W_per_K"] = {"poly": [0.55]}
    found = refined(motor, tmp_path)
    assert "path_change" not in set(found.effects()["effect"])


def test_the_command_says_that_the_motor_has_changed(tmp_path: Path) -> None:
    refined(blocked(), tmp_path)  # leaves its files
    fit = [str(tmp_path / f"run_{seed}.csv") for seed in (1, 2)]
    out = tmp_path / "out.json"
    args = ["refine", str(tmp_path / "small.json"), "--fit", *fit, "--test", str(tmp_path / "run_3.csv")]
    told = CliRunner().invoke(cli, [*args, "--out", str(out)])
    assert told.exit_code == 0
    lines = told.stdout.splitlines()
    (effect,) = (number for number, line in enumerate(lines) if "casing: path_change" in line)
    assert lines[effect + 1].endswith("the file was wrong there; OUT does not hold it")


def test_a_room_sensor_that_the_motor_warms_is_told_and_not_learnt(tmp_path: Path) -> None:
    """It takes up some of the casing's rise, and reads too much besides: each part then looks cooler than it should."""
    base = read(finned())
    paths = []
    for seed in (1, 2, 3):
        one = run(base, seed, noise_K=0.4)
        assert one.ambient is not None
        shown = one.ambient + 0.06 * (one.temps["casing"] - one.ambient) + 1.5
        paths.append(write(replace(one, ambient=shown), tmp_path / f"run_{seed}.csv"))
    file = tmp_path / "small.json"
    file.write_text(json.dumps(finned()), encoding="utf-8")
    for accept in (False, True):
        found = gen.refine(gen.load(file), fit=paths[:2], test=paths[2:], accept_change=accept)
        (effect,) = found.details()["effects"]
        assert (effect["name"], effect["component"], effect["parameters"]["of"]) == ("sensor_gain", "ambient", "casing")
        assert 0.02 < effect["parameters"]["share_of_the_rise"] < 0.1
        assert effect["parameters"]["offset_K"] == pytest.approx(1.5, abs=0.5)
        assert (effect["changed"], found.model.text) == (True, found.baseline.text)
        assert "hang it elsewhere" in " ".join(found.warnings)
        assert found.verdict == "partly explained"
