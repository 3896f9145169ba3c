"""What a file may say and few say: heat given far from all temperatures that are reached, laws from nothing on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gen
from gen.errors import CheckFailed
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.model.network_solution import NetworkSolution
from tests.certificate.networks import emitted, read
from tests.certificate.test_network_laws import ARITHMETICS, closed_motor
from tests.examples import ROOT

DOMAIN = [200, 255]


def two_nodes() -> dict[str, Any]:
    """The example at few |PWM|."""
    tree = dict(json.loads((ROOT / "examples" / "two_nodes" / "coeffs.json").read_text(encoding="utf-8")))
    tree["domain"]["pwm"] = tree["validity"]["pwm"] = DOMAIN
    tree["accuracy"] = {"fixed_limit_K": 1e-3, "float_limit_K": 1e-1}
    return tree


@pytest.mark.parametrize("reference", [-273.15, -254.0, -200.0, 250.0, 255.0, 260.0, 3000.0])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_heat_may_be_given_at_a_temperature_that_nothing_reaches(
    tmp_path: Path, arithmetic: Arithmetic, reference: float
) -> None:
    """Words are wide enough for the reference and for differences to it: what overflows, `gen check` refutes."""
    tree, near = two_nodes(), two_nodes()
    tree["network"]["heats"][0] |= {"per_K": 1e-4, "reference_degC": reference}
    out, program = emitted(tmp_path, read(tree), arithmetic)
    assert {part.name for part in gen.check(out).parts} == {part.name for part in program.parts}
    # The same heat, given at 20 degC.
    share = 1.0 + 1e-4 * (20.0 - reference)
    near["network"]["heats"][0] |= {"power_W": {"poly": [8e-4 * share, 0, 0]}, "per_K": 1e-4 / share}
    near["network"]["heats"][0] |= {"reference_degC": 20.0}
    time, pwm = np.array([0.0, 600.0, 7200.0]), np.full(3, 255)
    far, beside = (NetworkSolution(read(one).model).simulate_times(time, pwm, 25.0)["casing"] for one in (tree, near))
    assert far == pytest.approx(beside, abs=1e-9)


@pytest.mark.parametrize("law", [[0.0132, 0.0], [1e-4, 0.0, 0.0]])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_convection_may_begin_at_nothing(tmp_path: Path, arithmetic: Arithmetic, law: list[float]) -> None:
    """Its slope is 0 where both ends are as warm, and nowhere less."""
    tree = closed_motor()
    path = next(path for path in tree["network"]["paths"] if "convection" in path)
    path["convection"] = {"poly": law}
    out, program = emitted(tmp_path, read(tree), arithmetic)
    assert {part.name for part in gen.check(out).parts} == {part.name for part in program.parts}


def test_what_no_words_hold_is_refused() -> None:
    """A sensor that shows a ninth of what is there may begin 1 450 K hot, and the law goes with the cube of that."""
    tree = two_nodes()
    tree |= {"sample_time_s": 10.0, "accuracy": {"fixed_limit_K": 1000.0, "float_limit_K": 1000.0}}
    tree["domain"]["ambient_degC"], tree["domain"]["temperature_degC"] = [-60, 25], [-60, 100]
    gap = {"between": ["mass", "part"], "conductance_W_per_K": {"poly": [500.0]}}
    out = {"between": ["mass", "ambient"], "conductance_W_per_K": {"poly": [293.0]}}
    tree["network"] = {
        "nodes": [
            {"name": "mass", "capacity_J_per_K": 8.77e6, "sensor": {}},
            {"name": "part", "capacity_J_per_K": 2.193e5, "sensor": {"gain_about": "ambient", "gain_error": -0.89}},
        ],
        "paths": [gap | {"convection": {"poly": [2.4414e-7, 0.0, 0.0, 0.01]}}, out],
        "heats": [],
    }
    with pytest.raises(CheckFailed, match=r"change by more in one sample than the words of fixed point hold; expected"):
        lower(read(tree), "fixed", "table")
