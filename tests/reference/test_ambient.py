"""An ambient that moves, as the board deals with it: against an oracle of its own, and with a sensor that is noisy."""

from __future__ import annotations

import json
from functools import cache
from typing import Any, Literal, get_args

import numpy as np
import pytest
from scipy.linalg import expm

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients, parse
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.reference.model import ReferenceModel
from gen.reference.simulate import simulate_run
from gen.runs import Run
from tests.examples import ROOT, example

ROOM_MC = 24_100


@cache
def program(name: str, arithmetic: Arithmetic, *, at_once: bool = False) -> Program:
    return lower(coefficients(name, at_once=at_once), arithmetic, "table")


@cache
def coefficients(name: str, *, at_once: bool = False) -> Coefficients:
    tree: dict[str, Any] = json.loads((ROOT / "examples" / name / "coeffs.json").read_text())
    tree["ambient"]["at_once"] = at_once
    return parse(json.dumps(tree).encode())


def test_it_passes_the_dynamics_where_the_file_says_nothing() -> None:
    assert example("my1016").model == coefficients("my1016").model
    assert example("my1016").model.ambient_passes


def solved(thermal: Program, pwm: IntArray, told_mC: IntArray, start_mK: int) -> FloatArray:
    """T of every component, degC, shape (components, L), sample by sample from the poles of the file."""
    found = []
    for component in thermal.model.components:
        n, lanes = component.order, pwm.shape[0]
        a = component.denominator(np.arange(256))
        # The state is (T, T' tau, ..): scaled, as the highest derivatives of slow parts are tiny.
        tau = float(a[128, -1]) ** (-1.0 / n)
        grown = {}
        for level in np.unique(np.abs(pwm)).tolist():
            generator = np.zeros((n + 1, n + 1))
            generator[range(n - 1), range(1, n)] = 1.0 / tau
            generator[n - 1, :n] = -a[level, :0:-1] * tau ** (n - 1 - np.arange(n, dtype=np.float64))
            generator[n - 1, n] = a[level, -1] * tau ** (n - 1)  # for an input that is settled to
            grown[level] = expm(generator * thermal.model.sample_time)
        settled = component.steady_rise(np.arange(256))
        x = np.zeros((lanes, n))
        x[:, 0] = (told_mC[:, 0] + start_mK) / 1000.0
        for step in range(pwm.shape[1]):
            for lane in range(lanes):
                level = abs(int(pwm[lane, step]))
                towards = settled[level] + told_mC[lane, step + 1] / 1000.0
                x[lane] = (grown[level] @ np.append(x[lane], towards))[:n]
        found.append(x[:, 0])
    return np.array(found)


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
@pytest.mark.parametrize("name", ["my1016", "two_mass", "my1016_rig"])
def test_the_board_is_within_its_bound_of_the_exact_solution(name: str, arithmetic: Arithmetic) -> None:
    """PWM and ambient change at every sample, change now and then, or swing between their ends together."""
    board = program(name, arithmetic)
    assert board.ambient is not None
    random = np.random.default_rng(5)
    lanes, length = 3, 700
    pwm = random.integers(-255, 256, (lanes, length))
    told = random.integers(board.ambient.low, board.ambient.high + 1, (lanes, length + 1))
    pwm[1], told[1] = np.repeat(pwm[1, ::70], 70), np.resize(np.repeat(told[1, ::50], 50), length + 1)
    hot = np.arange(length) // 100 % 2 == 0
    pwm[2], told[2] = np.where(hot, 255, 0), np.append(board.ambient.low, np.where(hot, *told_ends(board)))
    model = ReferenceModel(board, [3_000] * lanes, told[:, 0][None])
    for step in range(length):
        model.set_channels(told[:, step + 1][None])
        model.step(pwm[:, step])
    assert not model.saturations.any()
    away = np.abs(model.readings - solved(board, pwm, told, 3_000)).max(axis=1)
    for component, error in zip(board.components, away, strict=True):
        assert component.proof is not None
        assert error < component.proof.bound_K, component.name
    np.testing.assert_allclose(model.rises_mK / 1000.0 + told[:, -1] / 1000.0, model.readings, rtol=0, atol=0.00051)


def told_ends(board: Program) -> tuple[int, int]:
    assert board.ambient is not None
    return board.ambient.high, board.ambient.low


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
def test_a_noisy_sensor_of_the_ambient_no_longer_shakes_the_model(arithmetic: Arithmetic) -> None:
    """Two minutes at rest beside a thermocouple of 0.25 K a count that noise of 0.15 K moves between its counts."""
    random = np.random.default_rng(60)
    told = np.rint((ROOM_MC + random.normal(0.0, 150.0, 480)) / 250.0).astype(np.int64) * 250
    jumps = {}
    for at_once in (True, False):
        board = program("my1016", arithmetic, at_once=at_once)
        model = ReferenceModel(board, [0], None if at_once else told[:1][None])
        shown = []
        for ambient in told:
            if not at_once:
                model.set_channels(np.array([[ambient]]))
            model.step(np.array([0]))
            shown.append(model.rises_mK[:, 0] + ambient)  # NAME_temperature_mC(component, ambient)
        jumps[at_once] = np.abs(np.diff(np.array(shown), axis=0))
    assert (jumps[True][:, 0] >= 200).sum() >= 60
    assert jumps[False].max() <= 2  # thousandths of a kelvin


def test_an_ambient_beyond_the_domain_is_held_to_it() -> None:
    board = program("my1016", "fixed")
    models = [ReferenceModel(board, [0], np.array([[told]])) for told in (50_000, 10**9)]
    for model in models:
        for _ in range(50):
            model.step(np.array([200]))
    np.testing.assert_array_equal(models[0].record(), models[1].record())


def test_one_that_is_never_told_changes_no_word_s_meaning() -> None:
    """Rises count from the fixed ambient then, as they do where it acts at once."""
    still, moving = (program("my1016", "fixed", at_once=at_once) for at_once in (True, False))
    models = [ReferenceModel(one, [12_000]) for one in (still, moving)]
    for pwm in [0] * 40 + [255] * 400 + [90] * 200:
        for model in models:
            model.step(np.array([pwm]))
    np.testing.assert_allclose(models[0].rises, models[1].rises, rtol=0, atol=2e-5)


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("name", ["my1016", "two_mass"])
def test_a_run_gives_the_same_by_board_and_exactly(name: str, arithmetic: Literal["fixed", "float"]) -> None:
    model = coefficients(name).model
    time = np.arange(0.0, 900.0, 0.25)
    room = np.where(time < 200.0, 21.0, np.where(time < 600.0, 33.5, 18.25))
    pwm = np.where(time < 400.0, 180, 60).astype(np.int64)
    part = model.component_names[0]
    run = Run(time, pwm, {part: np.full(time.size, 26.0)}, room)
    given = coefficients(name)
    exact = simulate_run(given, run, "exact", "auto", "run.csv")
    board = simulate_run(given, run, arithmetic, "auto", "run.csv")
    assert exact[f"{part}_degC"][0] == pytest.approx(26.0)
    for component in model.component_names:
        shown = exact[f"{component}_degC"]
        np.testing.assert_allclose(board[f"{component}_degC"], shown, rtol=0, atol=2e-4)
        assert np.abs(np.diff(shown)).max() < 0.2, "the room's step of 12.5 K passes the part"
    assert "ambient_mK" in board
