"""The rivals that need no further library: they compile cleanly, and do what their table says of them."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from benchmarks.rivals import __main__ as command
from benchmarks.rivals.code import measure, tables
from benchmarks.rivals.code.catalogue import RIVALS, Rival
from benchmarks.rivals.code.profiles import profiles
from benchmarks.rivals.code.programs import Program
from benchmarks.rivals.code.row import Row, errors
from benchmarks.rivals.code.table import code_table
from benchmarks.rivals.missing import LibraryMissing, library
from gen.emulate.firmware import cache_folder
from gen.model import ExactSolution, ThermalModel
from tests.examples import example

LENGTH = 1200
WITHOUT_LIBRARIES = [rival for rival in RIVALS if rival.clean]
CLAIMED_K = {"a": 2e-3, "b": 2e-3, "f": 1e-4, "g": 2e-3}
"""Of all parts over eighteen minutes (`--quick`)."""


def model() -> ThermalModel:
    return example("my1016").model


@cache
def measured(letter: str) -> Row:
    rival = next(rival for rival in RIVALS if rival.letter == letter)
    profile = profiles(LENGTH)
    return measure.rival_row(rival, example("my1016"), profile, ExactSolution(model()).simulate(profile.pwm))


@pytest.mark.parametrize("rival", WITHOUT_LIBRARIES, ids=lambda rival: str(rival.letter))
def test_a_rival_compiles_cleanly_and_its_cost_is_measured(rival: Rival) -> None:
    row = measured(rival.letter)
    assert row.missing is None
    assert 1000 < row.cycles_held < 100_000
    assert row.cycles_change >= 0.9 * row.cycles_held
    assert row.flash_bytes > 1000 and row.ram_bytes >= 16 and row.stack_bytes > 0


@pytest.mark.parametrize("letter", CLAIMED_K)
def test_a_rival_that_works_is_as_near_as_the_table_says(letter: str) -> None:
    for of_parts in measured(letter).error_K.values():
        assert max(of_parts.values()) < 10.0 * CLAIMED_K[letter]


def test_in_q31_the_brush_never_leaves_0_and_the_others_are_right(tmp_path: Path) -> None:
    rival = next(rival for rival in RIVALS if rival.letter == "d")
    profile = profiles(LENGTH)
    board = Program(rival, model(), tmp_path).on_board(profile, cache_folder())
    assert not board.words[0, :, 0].any()
    exact = ExactSolution(model()).simulate(profile.pwm)
    assert exact["brush"][0, -1] > 1.0
    for name, error in measured("d").error_K["step"].items():
        assert (error > 1.0) == (name == "brush")


def test_in_direct_form_float32_loses_the_brush_alone() -> None:
    lost = measured("c").error_K["step"]
    assert lost["brush"] > 0.1 * ExactSolution(model()).simulate(profiles(LENGTH).pwm)["brush"][0].max()
    assert max(error for name, error in lost.items() if name != "brush") < 1e-2


def test_integers_and_products_agree_with_the_host_and_exponentials_do_not() -> None:
    assert {letter: measured(letter).equal for letter in "acdg"} == {"a": False, "c": True, "d": True, "g": True}


@pytest.mark.parametrize("pwm", [51, 128, 255])
def test_difference_equations_are_those_of_scipy(pwm: int) -> None:
    for component in model().components:
        a, b = tables.difference_equation(model(), component.name, pwm)
        gain = np.array([float(component.effective_gain([pwm])[0])])
        poles = np.array([float(value) for value in component.denominator([pwm])[0]])
        numerator, denominator, _ = cont2discrete((gain, poles), dt=model().sample_time, method="zoh")
        assert a == pytest.approx(denominator[1:], rel=1e-12)
        # Numerators of a cascade near 1 are differences of nearly equal numbers: their response is compared.
        ours = lfilter([0.0, *b], [1.0, *a], np.full(400, float(pwm)))
        theirs = lfilter(np.ravel(numerator), denominator, np.full(400, float(pwm)))
        assert ours == pytest.approx(theirs, rel=1e-3, abs=1e-9)


def test_a_q31_word_is_a_quarter_of_its_coefficient_and_stays_in_range() -> None:
    assert tables.q31_word(-3.0) == f"{-3 * 2**29}L"
    assert tables.q31_word(4.0) == f"{2**31 - 1}L"
    assert tables.q31_word(1e-10) == "0L"


def test_an_error_that_is_no_number_is_infinite() -> None:
    rises = np.zeros((3, 2, 1))
    rises[1, 1] = np.nan
    found = errors(rises, {"part": np.array([[0.0, 1.0, 0.5]] * 3)})
    assert found == {"step": {"part": 1.0}, "staircase": {"part": np.inf}, "toggling": {"part": 1.0}}


def test_a_missing_library_is_said_with_what_installs_it() -> None:
    with pytest.raises(LibraryMissing, match=re.escape("nothing_like_it is not installed: pip install '.[rivals]'")):
        library("nothing_like_it.inside")


def test_a_missing_library_has_a_row_and_the_command_fails(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def nothing(name: str) -> None:
        raise LibraryMissing(f"{name} is not installed")

    monkeypatch.setattr("benchmarks.rivals.code.casadi_step.library", nothing)
    rival = next(rival for rival in RIVALS if rival.letter == "e")
    row = measure.rival_row(rival, example("my1016"), profiles(4), {})
    monkeypatch.setitem(command.PARTS, "code", lambda quick, tell: ([code_table([row])], [row]))
    written = tmp_path / "rivals.json"
    assert command.main(["--only", "code", "--json", str(written)]) == 1
    said = capsys.readouterr()
    assert "| (e) CasADi" in said.out and "casadi is not installed" in said.out
    assert said.err.endswith("casadi is not installed\n")
    assert json.loads(written.read_text())["code"][0]["missing"] == "casadi is not installed"
