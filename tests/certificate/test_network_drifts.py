"""Sensors that drift since the start: what is emitted of them is proven, and no other drift."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gen
from gen.errors import CheckFailed, InputError
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.reference.board import reference_of
from gen.reference.network import ReferenceNetwork
from tests.campaign import share
from tests.certificate.networks import assert_about, assert_proven, emitted, read, with_sensors
from tests.certificate.test_network import ARITHMETICS, CERTIFICATE, MODEL, changed
from tests.certificate.test_planted import Edit, planted, replaced

#: By node: beside a lag, an offset, a gain; slow and fast, large and next to nothing; one that does not drift.
SENSORS: list[list[dict[str, Any]]] = [
    [{"drift_K": 3.0, "drift_h": 1.5}, {"lag_s": 6.0, "drift_K": -8.0, "drift_h": 20}, {"offset_K": 0.4}],
    [
        {"gain_error": 0.3, "offset_K": 0.4, "drift_K": 1e-3, "drift_h": 0.05},
        {},
        {"gain_error": -0.2, "gain_about": "zero_degC", "lag_s": 6.0, "drift_K": -500.0, "drift_h": 48},
    ],
]
Projects = dict[Arithmetic, tuple[Path, Program]]


@pytest.fixture(scope="module")
def projects(tmp_path_factory: pytest.TempPathFactory) -> Projects:
    """The first of them in both arithmetics."""
    return {one: emitted(tmp_path_factory.mktemp(one), read(with_sensors(SENSORS[0])), one) for one in ARITHMETICS}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("case", range(len(SENSORS)))
def test_drifts_are_proven(tmp_path: Path, case: int, arithmetic: Arithmetic) -> None:
    assert_proven(*emitted(tmp_path, read(with_sensors(SENSORS[case])), arithmetic))


def test_the_statement_is_about_its_drifts(projects: Projects, tmp_path: Path) -> None:
    assert_about(projects["fixed"][0], tmp_path, with_sensors(SENSORS[0]), "drift_K", "states")


def _state(**parts: object) -> Edit:
    """The first state that drifts, changed."""

    def change(tree: dict[str, Any]) -> None:
        next(state for state in tree["states"] if "drifts_to_K" in state).update(parts)

    return changed(change)


def _reading(number: int, **parts: object) -> Edit:
    def change(tree: dict[str, Any]) -> None:
        tree["components"][number] |= parts

    return changed(change)


def _exchanged(tree: dict[str, Any]) -> None:
    one, other = tree["components"][:2]
    one["drift"], other["drift"] = other["drift"], one["drift"]


def _without_its_error(tree: dict[str, Any]) -> None:
    part = tree["components"][1]
    part["bound_K"] -= 0.9 * tree["states"][part["drift"]]["error_K"]


DEFECTS: dict[str, tuple[str, Edit]] = {
    "no drift of a reading": (MODEL, replaced(r" \+ drifted\(&reading\)", "")),
    "taken off": (MODEL, replaced(r" \+ drifted\(&reading\)", " - drifted(&reading)")),
    "another's drift": (MODEL, replaced(r"chain_T_node0, chain_D_node0", "chain_T_node0, chain_D_node2")),
    "the drift of a sensor that has none": (MODEL, replaced(r"chain_T_node4, 0", "chain_T_node4, chain_D_node0")),
    "a beginning at the ambient": (MODEL, replaced(r"    rest_at\(chain_D_node0, 0\);\n", "")),
    "a beginning of its own": (MODEL, replaced(r"rest_at\(chain_D_node0, 0\)", "rest_at(chain_D_node0, 1)")),
    "a start that goes on": (MODEL, replaced(r"if \(reading\.drift\) \{", "if (false) {")),
    "a start of all": (MODEL, replaced(r"rest_at\(reading\.drift, 0\)", "rest_at(reading.state, 0)")),
    "a drift from the node": (MODEL, replaced(r"upper\(reading->drift\)", "upper(reading->node)")),
    "another end in the certificate": (CERTIFICATE, _state(drifts_to_K=3.01)),
    "another sign in the certificate": (CERTIFICATE, _state(drifts_to_K=-3.0)),
    "another time constant in the certificate": (CERTIFICATE, _state(time_constant_s=5420.0)),
    "a narrower range in the certificate": (CERTIFICATE, _state(range_degC=[0.0, 2.9])),
    "less error in the certificate": (CERTIFICATE, _state(error_K=1e-9)),
    "drifts exchanged in the certificate": (CERTIFICATE, changed(_exchanged)),
    "a bound without the drift's": (CERTIFICATE, changed(_without_its_error)),
}
#: Of a float32 network's, which are a hundred times as wide.
WIDE = {"less error in the certificate", "a bound without the drift's"}
PLANTED = [(name, one) for name in DEFECTS for one in ARITHMETICS if one == "fixed" or name not in WIDE]


@pytest.mark.campaign
@pytest.mark.parametrize(("defect", "arithmetic"), share(PLANTED))
def test_a_defect_of_a_drift_is_refuted(
    projects: Projects, tmp_path: Path, defect: str, arithmetic: Arithmetic
) -> None:
    name, edit = DEFECTS[defect]
    with pytest.raises(CheckFailed):
        gen.check(planted(projects[arithmetic][0], tmp_path, name, edit))


@pytest.mark.parametrize(
    "edit",
    [_state(lags=0), _state(time_constant_s=None), _state(capacity_J_per_K=5.0), _reading(0, drift=None)],
)
def test_a_drift_that_means_nothing_is_no_certificate(projects: Projects, tmp_path: Path, edit: Edit) -> None:
    with pytest.raises(InputError, match=r"is no certificate"):
        gen.check(planted(projects["fixed"][0], tmp_path, CERTIFICATE, edit))


def test_what_the_reference_shows_is_its_own_and_the_drift_s_word() -> None:
    """From every start: at first what was asked for, then moved as the closed form has it."""
    program = lower(read(with_sensors(SENSORS[0])), "fixed", "table")
    network = program.network
    assert network is not None
    chance, lanes = np.random.default_rng(4), 50
    told = np.array([chance.integers(c.low, c.high + 1, lanes) for c in network.channels])
    asked = chance.integers(-10_000, 120_001, (3, lanes))
    board = reference_of(
        program, {r.name: (a - told[0]).tolist() for r, a in zip(network.readings, asked, strict=True)}, told
    )
    assert isinstance(board, ReferenceNetwork)
    word = 2.0**-network.fraction_bits
    assert np.abs(board.readings - asked / 1000.0).max() < 4 * word
    for _ in range(400):
        board.step(np.full(lanes, 110))
    for number, (reading, sensor) in enumerate(zip(network.readings, SENSORS[0], strict=True)):
        drift = sensor.get("drift_K", 0.0) * -np.expm1(-100.0 / 3600.0 / sensor.get("drift_h", 1.0))
        for lane in range(lanes):
            behind = Fraction(float(board.temperatures[reading.state, lane])) + Fraction(sensor.get("offset_K", 0))
            shown = Fraction(float(board.readings[number, lane]))
            assert abs(float(shown - behind) - drift) < 3 * word + 2e-5 * abs(drift)
