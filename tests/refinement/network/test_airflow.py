"""A fan that cools a surface of its own, whatever the motor does: found, written, built and found no second time."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import gen
from gen.refinement.network.effects import candidates
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from tests.refinement.network.motor import NOISE_K, Tree, read, run, tree, wave
from tests.refinement.network.test_refine_network import error_K, files, refined

FAN = {"fan_mps": (0.0, 6.0)}
ADDED = 0.3


def blown() -> Tree:
    """The motor with a fan whose flow adds as much to the casing's cooling at rest as at full speed."""
    motor = tree()
    motor["network"]["channels"] = [{"column": "fan_mps", "range": [0, 10], "neutral": 0}]
    motor["network"]["paths"].append(
        {
            "between": ["casing", "ambient"],
            "conductance_W_per_K": {"poly": [ADDED]},
            "factors": [{"channel": "fan_mps", "table": {"at": [0, 6], "value": [0, 1]}}],
        }
    )
    return motor


def test_a_flow_beside_the_motor_s_own_is_a_path_of_its_own(tmp_path: Path) -> None:
    found = refined(blown(), tmp_path, FAN)
    (effect,) = found.details()["effects"]
    assert (effect["name"], effect["component"], effect["parameters"]["channel"]) == ("airflow", "casing", "fan_mps")
    assert effect["parameters"]["conductance_at_most_flow_W_per_K"] == pytest.approx(ADDED, rel=0.05)
    assert found.verdict == "explained"
    assert error_K(found, tmp_path) < 1.1 * NOISE_K
    network = found.model.coefficients.model.network
    assert network is not None
    assert [path.label for path in network.paths[1:]] == ["casing - ambient", "casing - ambient, by fan_mps"]
    again = gen.refine(found.model, fit=[tmp_path / f"run_{k}.csv" for k in (1, 2)], test=[tmp_path / "run_3.csv"])
    assert (again.verdict, len(again.effects())) == ("nothing missing", 0)


def test_what_a_channel_makes_is_offered_once_and_has_not_come_with_speed() -> None:
    """A file holds one path of a channel between two ends; at rest in still air that one conducts nothing."""
    told = {"fan_mps": wave(1, 0.0, 6.0)}
    for motor, paths in ((tree(), 1), (blown(), 2)):
        network = read(motor).model.network
        assert network is not None
        data = make_data(read(motor), [(f"run {k}", run(read(motor), k, told)) for k in (1, 2)])
        made = Anchored.of(network, 255, data.columns).motor()
        flows = [effect for effect in candidates(made, data.offered) if effect.name == "airflow"]
        beside = [one for one in flows if one.numbers[0].name == "conductance_at_most_flow_W_per_K"]
        assert len(beside) == (2 if paths == 1 else 0)  # with the flow, and with its root
        assert [made.path_at(q).place for q in made.outer] == list(range(paths))
        assert [bool(made.with_speed[q].max() > 0.0) for q in made.outer] == [True, False][:paths]


def test_a_board_is_proven_for_such_a_file(tmp_path: Path) -> None:
    found = refined(blown(), tmp_path, FAN)
    built = gen.build(found.model, tmp_path / "firmware")
    assert (built.guarantees()["bound_K"] < 1e-4).all()
    gen.check(built.folder)  # raises where an inequality does not hold


def test_what_is_found_on_one_of_two_ways_to_the_room_is_written_on_that_one(tmp_path: Path) -> None:
    """The file knows the fan; the motor has lost most of what its own turning adds, and the fan blows as before."""
    motor = blown()
    motor["network"]["paths"][1]["conductance_W_per_K"]["power"] = {"constant": 0.2, "forced": 0.1, "exponent": 0.8}
    one, two, three = files(motor, tmp_path, FAN)
    (tmp_path / "blown.json").write_text(json.dumps(blown()), encoding="utf-8")
    found = gen.refine(gen.load(tmp_path / "blown.json"), fit=[one, two], test=[three], accept_change=True)
    assert [effect["name"] for effect in found.details()["effects"]] == ["path_change"]
    assert error_K(found, tmp_path) < 1.2 * NOISE_K
    network = found.model.coefficients.model.network
    assert network is not None
    assert network.conductances[255, 1:] == pytest.approx([0.3, ADDED], rel=0.1)
