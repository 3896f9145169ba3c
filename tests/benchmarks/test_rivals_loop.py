"""The general tools' side of the loop: what is handed to them, and what is made of what they give back."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from benchmarks.identify_rivals import Predictor
from benchmarks.rivals.loop import tracing
from benchmarks.rivals.loop.identification import Identified, grey_box, rms
from benchmarks.rivals.loop.motors import missed, motor
from benchmarks.rivals.loop.network import casadi_network
from benchmarks.rivals.loop.table import identified_table, traced_table
from benchmarks.rivals.loop.terms import BLOCK_S, SETTLING, Course, courses, courses_of
from benchmarks.rivals.loop.tracing import Sparse, Traced, named, rival
from benchmarks.rivals.missing import LibraryMissing
from gen.coefficients import load
from gen.runs import Run
from tests.refinement.plant import COEFFICIENTS
from tests.refinement.plant_effects import make

NAMES = (*SETTLING, "load_heating", "coupling casing")


def course(load_heating: float) -> Course:
    terms = np.zeros((200, len(NAMES)))
    terms[:, 2], terms[:, 3], terms[:, 4] = 0.5, load_heating, 0.1
    return Course(np.full(200, 3.0), NAMES, terms)


def test_a_free_run_is_the_recursion_from_the_first_residual() -> None:
    factors = np.array([-0.4, -0.2, 0.0, 0.3, 0.0])  # r' = -0.04 r - 0.02 r 0.5 + 0.3 in K a minute
    made = Sparse(factors).free_run(course(1.0))
    rest = 0.3 / 0.05
    assert made == pytest.approx(rest + (3.0 - rest) * 0.95 ** np.arange(200))


def test_effects_are_named_by_size_and_the_model_s_own_terms_are_none() -> None:
    factors = np.array([-0.4, 0.0, 9.0, 0.3, 0.5])
    assert named(Sparse(factors), [course(1.0)]) == ["load_heating", "coupling"]
    assert named(Sparse(np.array([-0.4, 0.0, 9.0, 0.0, 0.0])), [course(1.0)]) == []


def test_the_term_of_what_was_planted_explains_the_residual(tmp_path: Path) -> None:
    fit, _, floor = make(tmp_path, ("airflow",), 70_001)
    found = courses(load(COEFFICIENTS), fit)
    worst = max(found, key=lambda part: tracing.rms([one.residual for one in found[part]]))
    own = found[worst]
    keep = [own[0].names.index(name) for name in (*SETTLING, "airflow")]
    terms = np.vstack([one.terms[:-1, keep] for one in own])
    steps = np.concatenate([np.diff(one.residual) for one in own])
    factors = np.zeros(len(own[0].names))
    factors[keep] = np.linalg.lstsq(terms, steps, rcond=None)[0]
    before = tracing.rms([one.residual for one in own])
    assert Sparse(factors).error_K(own) < 0.3 * before
    assert factors[own[0].names.index("airflow")] < 0.0  # air cools
    assert floor < before
    assert all(len(one.residual) == 2.5 * 3600 / BLOCK_S + 1 for one in own)


def test_a_block_without_a_reading_is_none_of_zero_degrees() -> None:
    """A logger's gap of some minutes: what lies between is taken from either side, and is no residual of the room."""
    time = np.delete(np.arange(0.0, 3600.0), slice(600, 900))
    temps = {name: np.full(time.size, 60.0) for name in ("brush", "bearing", "magnet", "casing")}
    for own in courses_of(load(COEFFICIENTS), Run(time, np.full(time.size, 120), temps), "run.csv").values():
        assert own.residual.size == 60
        assert np.abs(np.diff(own.residual)).max() < 3.0  # the model moves on meanwhile; 0 degC would be 60 K away


def test_a_motor_s_parts_are_handed_over_alone_on_a_grid_of_a_second() -> None:
    one = motor(1700)
    assert one.learnt.keys() == one.judged.keys() and 0.1 < one.floor_K < 1.5
    for runs in one.learnt.values():
        assert len(runs) == 7  # five steps and two mixed runs
        for run in runs:
            assert run.time_s == pytest.approx(np.arange(run.time_s.size))
            assert np.isfinite(run.temps["part"]).all()
            assert run.temps["part"][0] == pytest.approx(30.0, abs=4.0)  # cold: in its room, but for the sensors
        assert [int(run.pwm[100]) for run in runs[:5]] == [51, 102, 153, 204, 255]


def test_a_prediction_of_means_over_blocks_is_held_against_single_rows() -> None:
    """A part that warms evenly: its means are exact, so nothing is missed but at the ends; what diverged is told."""
    time = np.arange(4000.0)
    run = Run(time, np.full(4000, 120), {"part": 30.0 + 0.05 * time}, np.full(4000, 30.0))
    exact = missed(lambda pwm: 0.05 * time.reshape(-1, 20).mean(axis=1), run)
    assert np.abs(exact[10:-10]).max() < 1e-9 and np.abs(exact).max() < 0.5
    assert rms(exact) < 0.03
    assert rms(missed(lambda pwm: np.full(200, np.nan), run)) == np.inf


def heated(pwm: np.ndarray) -> np.ndarray:
    over, inner = np.zeros(len(pwm)), 0.0
    for k in range(1, len(pwm)):
        u = pwm[k - 1] / 255.0
        over[k] = over[k - 1] + 0.03 * u - (5e-4 + 3e-4 * u) * over[k - 1] + 1e-3 * (inner - over[k - 1])
        inner += 8e-4 * (over[k - 1] - inner)
    return over


@pytest.mark.parametrize("fit", [grey_box, casadi_network], ids=["by hand", "CasADi"])
def test_a_grey_box_of_two_capacities_predicts_two_capacities(fit: Callable[[list[Run]], Predictor]) -> None:
    if fit is casadi_network:
        pytest.importorskip("casadi")
    profiles = [np.repeat([level, 0], [4000, 2000]) for level in (80, 160, 255)]
    runs = [Run(np.arange(6000.0), pwm, {"part": 30.0 + heated(pwm)}, np.full(6000, 30.0)) for pwm in profiles]
    fresh = np.repeat([120, 255, 0, 60], 1500)
    truth = heated(fresh).reshape(-1, 20).mean(axis=1)
    assert fit(runs)(fresh) == pytest.approx(truth, abs=0.3)


def test_a_missing_tool_has_a_row_that_says_so() -> None:
    def absent(own: object) -> Sparse:
        raise LibraryMissing("pysindy is not installed: pip install '.[rivals]'")

    found = rival("PySINDy", absent, "airflow", {"part": [course(1.0)]}, {"part": [course(1.0)]})
    ours = Traced("gen refine", "airflow", "airflow", 0, 2.0, 0.3, 5.0)
    table = traced_table([ours, found])
    cells = [list(column.cells) for column in table.columns]
    assert cells[3] == ["yes", ""] and cells[7][0] == "x 1.000"
    shown = io.StringIO()
    Console(file=shown, width=300).print(table)
    assert "pysindy is not installed: pip install '.[rivals]'" in shown.getvalue()  # and no markup of it


def test_an_identifier_that_diverged_is_told_as_that() -> None:
    found = [Identified("gen identify", [0.1, 0.3, 0.2], 4.0), Identified("other", [0.5, np.inf, 0.4], 2.0)]
    cells = [list(column.cells) for column in identified_table(found, "plants").columns]
    assert cells[1:] == [["0.20 K", "0.50 K"], ["0.30 K", "diverged"], ["x 1.00", "x 0.50"]]
