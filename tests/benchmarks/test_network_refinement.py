"""The judge of refinement: who knows all gets full marks, who does nothing none, and what refuses or raises is told."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import gen
from benchmarks.network_refinement import __main__ as command
from benchmarks.network_refinement.judge import judge
from benchmarks.network_refinement.table import goals, rows, text
from benchmarks.plants.planted.trial import Trial, Written, write_trial
from gen.errors import CheckFailed, InputError
from tests.benchmarks.refinement_oracle import SMALL, TRIAL, Answers, Oracle, answering, judged, perfect


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Written:
    return write_trial(TRIAL, tmp_path_factory.mktemp("trial"))


def test_who_knows_all_gets_full_marks(written: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    result = judged(written, monkeypatch, tmp_path, perfect(written))
    assert result.status == "ok", result.message
    assert (result.first, result.among, result.false, result.flagged) == (True, True, [], False)
    assert result.after == pytest.approx(1.0, rel=1e-6)
    assert result.before > 1.3
    assert set(result.after_by_run) == {"test_1", "test_2"}
    assert result.truth["load_heating"]["parameters"]["torque"] > 0.0
    assert all(goal.met for goal in goals([result], 2) if goal.of)
    (row,) = rows([result])
    assert (row.planted, row.first, row.among, row.false) == ("load_heating", 1.0, 1.0, 0.0)
    assert {"identified.json", "refined.json"} <= {path.name for path in tmp_path.iterdir()}


def test_who_does_nothing_gets_no_marks(written: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    result = judged(written, monkeypatch, tmp_path, None)
    assert (result.first, result.among, result.named) == (False, False, [])
    assert result.after_K == result.before_K
    reached = {goal.text: goal.reached for goal in goals([result], 2) if goal.of}
    assert reached["single: right name first"] == 0.0
    assert reached["single: error after at most 1.3 floors"] == 0.0
    assert reached["all: error told is right to 10 %"] == 0.0  # it tells none


def test_what_refinement_tells_of_itself_is_held_against_what_is(
    written: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    boasting = perfect(written)
    boasting.model, boasting.told = Oracle(boasting.model.components, knows=False), written.floor_K
    result = judged(written, monkeypatch, tmp_path, boasting)
    assert result.after_K == result.before_K > 1.3 * result.told_K
    told = next(goal for goal in goals([result], 2) if "told" in goal.text)
    assert told.met is False


def test_a_name_among_the_lookalikes_is_told_apart_from_the_right_one(
    written: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    other = perfect(written)
    other.named = [("supply_voltage", ("load_heating", "drift")), ("supply_voltage", ()), ("airflow", ())]
    result = judged(written, monkeypatch, tmp_path, other)
    assert (result.first, result.among) == (False, True)
    assert result.named == result.false == ["supply_voltage", "airflow"]
    other.named = [("supply_voltage", ("drift",))]
    assert not judged(written, monkeypatch, tmp_path, other).among


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (InputError("a network"), "refused"),
        (CheckFailed("nothing is left"), "refused"),
        (ZeroDivisionError("by zero"), "raised"),
    ],
)
def test_what_gives_no_result_is_counted_and_named(
    written: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, error: Exception, status: str
) -> None:
    result = judged(written, monkeypatch, tmp_path, error)
    assert result.status == status
    assert result.before > 1.3
    assert not result.first
    assert all(goal.reached == 0.0 for goal in goals([result], 2) if goal.of)
    (row,) = rows([result])
    assert (row.trials, row.without) == (1, 1)
    assert f"{status}: {TRIAL}: " in text([result])
    assert json.loads(command.as_json([result]))["trials"][0]["after_K"] is None


def test_a_network_is_judged_from_files_to_figures(tmp_path: Path) -> None:
    """The whole way once: an identification, a refinement where nothing was changed, its model on the test runs."""
    result = command.in_a_folder(Trial(SMALL, (), 2), tmp_path, tmp_path / "kept")
    assert result.status == "ok", result.message
    assert 0.9 < result.before < 1.5
    assert result.told_K == pytest.approx(result.after_K, rel=0.1)
    assert gen.load(tmp_path / "kept" / "refined.json").components


def test_a_motor_is_identified_once_for_each_of_its_rooms(
    written: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    answers = Answers(written, perfect(written))
    answering(monkeypatch, answers)
    models = tmp_path / "models"
    judge(written, tmp_path, models)
    judge(written, tmp_path, models)
    assert answers.calls == ["identify", "refine", "refine"]
    assert [path.name for path in models.glob("*.json")] == ["2-measured.json"]


def test_a_motor_that_cannot_be_identified_says_nothing_of_refinement(
    written: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    answering(monkeypatch, Answers(written))

    def fails(runs: object, **_: object) -> None:
        raise CheckFailed("no network")

    monkeypatch.setattr(gen, "identify", fails)
    result = judge(written, tmp_path, tmp_path / "models")
    assert result.status == "no model"
    assert rows([result]) == []
    assert f"no model: {TRIAL}: CheckFailed: no network" in text([result])
