"""The attacker: its judge against closed forms, its board against the reference, what it finds, a short campaign."""

from __future__ import annotations

import json
from dataclasses import replace
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.attack import schedules
from benchmarks.attack.board import Board
from benchmarks.attack.campaign import attack_file
from benchmarks.attack.exact import BITS, ExactComponent
from benchmarks.attack.random_files import random_document
from benchmarks.attack.report import Attacked, Refused, Report, Timed
from benchmarks.attack.search import BRIEF, QUICK, Finding, attack
from benchmarks.attack.victim import FORMS
from gen.coefficients import parse
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from gen.reference.model import ReferenceModel
from tests.examples import EXAMPLES, ROOT, example

GAIN = 2.5e-3
FILES = 20
"""How many random files an ordinary run attacks, each in one form."""


def document(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((ROOT / "examples" / name / "coeffs.json").read_text(encoding="utf-8"))
    return found


def constant(*poles: float, gain: float = 1.0, step: float = 0.25) -> dict[str, Any]:
    """A file with one component that does not depend on PWM but by its steady rise."""
    component = {
        "name": "part",
        "order": len(poles),
        "gain": {"poly": [gain]},
        "poles": [{"real": {"poly": [pole]}} for pole in poles],
    }
    return {
        "format": "gen-coefficients",
        "version": 1,
        "name": "constant",
        "sample_time_s": step,
        "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 3000},
        "ambient": {"fixed_degC": -20.0},
        "validity": {"pwm": [0, 255], "outside": "hold"},
        "domain": {"pwm": [0, 255], "ambient_degC": [-20.0, -20.0], "temperature_degC": [-20.0, 960.0]},
        "components": [component],
    }


@pytest.mark.parametrize("poles", [(-0.3,), (-0.01, -0.0025)])
def test_the_judge_agrees_with_the_closed_form_in_forty_digits(poles: tuple[float, ...]) -> None:
    """From rest at T0: T = S + (T0 - S) sum of exponentials, of one pole and of two."""
    exact = ExactComponent(constant(*poles, gain=GAIN), 0)
    found = exact.rises(959_106, [200] * 1000)
    with localcontext(Context(prec=60)):
        p = [Decimal(pole) for pole in poles]
        product = -p[0] if len(p) == 1 else p[0] * p[1]
        steady, start = Decimal(GAIN) * 200 / product, Decimal("959.106")
        for samples in (1, 10, 1000):
            grown = [(pole * samples / 4).exp() for pole in p]
            away = grown[0] if len(p) == 1 else (p[1] * grown[0] - p[0] * grown[1]) / (p[1] - p[0])
            wanted = steady + (start - steady) * away
            assert abs(Fraction(found[samples], 1 << BITS) - Fraction(wanted)) < Fraction(1, 10**45)


@pytest.mark.parametrize("name", EXAMPLES)
def test_its_reading_of_a_file_is_its_own_and_the_same(name: str) -> None:
    read = document(name)
    for index, component in enumerate(example(name).model.components):
        for pwm in schedules.domain(read):
            found = schedules.coefficients(read, read["components"][index], pwm)
            wanted = component.denominator([pwm])[0, 1:]
            np.testing.assert_allclose([float(a) for a in found.denominator], wanted, rtol=1e-13)
            np.testing.assert_allclose(float(found.steady), component.steady_rise([pwm])[0], rtol=1e-12)


@pytest.mark.parametrize(("arithmetic", "name"), [("fixed", "my1016"), ("float", "my1016"), ("fixed", "two_mass")])
def test_its_board_has_the_words_of_the_reference(arithmetic: Arithmetic, name: str) -> None:
    """Also at commands of either sign."""
    program = lower(example(name), arithmetic, "table")
    pwm = np.random.default_rng(3).integers(-255, 256, (60, 4))
    starts = [-40_000, 0, 31_234, 10_000_000]
    model = ReferenceModel(program, starts)
    boards = [Board(component) for component in program.components]
    states = [board.start(starts) for board in boards]
    before = None
    for command in pwm:
        model.step(command)
        row = np.abs(command)
        states = [board.sample(state, row, before) for board, state in zip(boards, states, strict=True)]
        before = row
        found = np.array([board.rise(state) for board, state in zip(boards, states, strict=True)])
        np.testing.assert_array_equal(found, model.rises)


def test_commands_outside_of_the_domain_are_what_it_attacks_at_its_ends() -> None:
    """The judge knows the domain's rows only; the board limits |PWM| to them."""
    read = constant(-0.3)
    read["domain"]["pwm"] = read["validity"]["pwm"] = [40, 200]
    component = read["components"][0]
    component["gain"] = {"poly": [1e-3, 0.1]}
    program = lower(parse(json.dumps(read).encode()), "fixed", "table")
    pwm = np.random.default_rng(4).integers(-255, 256, (80, 1))
    model, board = ReferenceModel(program, [0]), Board(program.components[0])
    state, before, rows = board.start([0]), None, []
    for command in pwm:
        model.step(command)
        row = np.clip(np.abs(command), 40, 200) - 40
        state = board.sample(state, row, before)
        before = row
        rows.append(int(row[0]))
        assert board.rise(state)[0] == model.rises[0, 0]
    assert {0, 160} <= set(rows)
    exact = ExactComponent(read, 0).rises(0, rows)[-1]
    proof = program.components[0].proof
    assert proof is not None
    assert abs(float(Fraction(exact, 1 << BITS)) - float(model.rises[0, 0])) <= proof.bound_K


def attacked(component: FixedComponent, read: dict[str, Any]) -> Finding:
    """What is found of the MY1016's bearing, or of a component that stands in its place."""
    return attack(component, ExactComponent(read, 1), QUICK, np.random.default_rng(1))


@pytest.fixture(scope="module")
def bearing() -> FixedComponent:
    component = lower(example("my1016"), "fixed", "table").components[1]
    assert isinstance(component, FixedComponent)
    return component


def defect_in_a_rate(component: FixedComponent) -> FixedComponent:
    rates = component.rates.copy()
    rates[77] += rates[77] >> 17  # by 8 in a million
    return replace(component, rates=rates)


def defect_in_a_steady_rise(component: FixedComponent) -> FixedComponent:
    steady = component.steady.copy()
    steady[200] += 400  # 5e-5 K
    return replace(component, steady=steady)


@pytest.mark.parametrize("defect", [defect_in_a_rate, defect_in_a_steady_rise])
def test_a_defect_in_one_of_256_rows_breaks_the_bound(defect: Any, bearing: FixedComponent) -> None:  # noqa: ANN401
    proof = bearing.proof
    assert proof is not None
    assert attacked(bearing, document("my1016")).error_K <= proof.bound_K
    assert attacked(defect(bearing), document("my1016")).error_K > proof.bound_K


def test_a_start_that_is_off_at_few_of_many_starts_is_found(
    bearing: FixedComponent, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Issue 11: a start off by more units than were counted, at the upper end of the range only."""
    proof, whole = bearing.proof, Board.start
    assert proof is not None

    def start(board: Board, rise_mK: list[int]) -> list[Any]:
        state = whole(board, rise_mK)
        state[0] = state[0] + np.where(np.array(rise_mK) > bearing.start_range_mK[1] - 100, 40 << 16, 0)
        return state

    monkeypatch.setattr(Board, "start", start)
    found = attacked(bearing, document("my1016"))
    assert found.error_K > proof.bound_K
    assert found.start_mK > bearing.start_range_mK[1] - 100


def report_of(bound_K: float | None, *, allowed: bool = False) -> Report:
    entry = Attacked("file", "part", 1, "fixed/table", bound_K, 1e-6, allowed=allowed, start_mK=0, samples=1)
    return Report([entry], [], [Timed("file", "fixed/table", 1.0)])


def test_what_must_not_be_is_told() -> None:
    assert report_of(2e-6).faults() == []
    assert report_of(None, allowed=True).faults() == []
    for report in (report_of(0.9e-6), report_of(None)):
        assert len(report.faults()) == 1
    assert len(Report([], [], [Timed("file", "fixed/table", 10.1)]).faults()) == 1
    assert len(Report([], [], [Timed("file", "fixed/table", 1.0, "Traceback\nKeyError: 'a'")]).faults()) == 1
    assert len(Report([], [Refused("file", "fixed/table", "message", "nothing was told")], []).faults()) == 1
    assert "0.500" in report_of(2e-6).summary()


def campaign(path: Path, forms: tuple[tuple[Arithmetic, ScheduleKind], ...], report: Report) -> None:
    attack_file(path, path.stem, BRIEF, 1, report, print, forms, by_command=path.stem == "random3")


@pytest.mark.campaign
@pytest.mark.parametrize("part", range(4))
def test_random_files_are_refused_in_a_line_or_keep_their_bounds(part: int, tmp_path: Path) -> None:
    report = Report.empty()
    for number in range(part, FILES, 4):
        path = tmp_path / f"random{number}.json"
        path.write_text(json.dumps(random_document(1, number)), encoding="utf-8")
        campaign(path, (FORMS[number // 4 % 4],), report)
    # How long a build takes is the machine's business; `python -m benchmarks.attack` looks at that.
    quick = Report(report.attacked, report.refused, [replace(t, seconds=0.0) for t in report.timed])
    assert quick.faults() == []
    assert report.attacked


@pytest.mark.parametrize("form", FORMS)
def test_the_my1016_keeps_its_bounds(form: tuple[Arithmetic, ScheduleKind]) -> None:
    report = Report.empty()
    campaign(ROOT / "examples" / "my1016" / "coeffs.json", (form,), report)
    assert [entry.line() for entry in report.attacked if entry.broken] == []
    assert len(report.attacked) == 4
    assert all(entry.ratio is not None and entry.ratio > 0.01 for entry in report.attacked)
