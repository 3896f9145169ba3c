"""The command that judges refinement: cases, arguments, files, interruption."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from benchmarks.network_refinement import __main__ as command
from benchmarks.network_refinement.judge import Judged
from benchmarks.network_refinement.table import rows, text
from benchmarks.plants.cases import bench
from benchmarks.plants.planted.draw import LIBRARY, NotVisible
from benchmarks.plants.planted.kinds import FAULTS, OUTSIDE
from benchmarks.plants.planted.trial import Trial, Written, write_trial
from tests.benchmarks.refinement_oracle import TRIAL, Answers, answering, made, perfect


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Written:
    return write_trial(TRIAL, tmp_path_factory.mktemp("trial"))


def test_what_no_bench_sees_is_no_trial(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def fails(trial: Trial, folder: Path) -> Written:
        raise NotVisible("drift: nothing that the sensors see")

    monkeypatch.setattr(command, "write_trial", fails)
    result = command.in_a_folder(Trial(1, ("drift",), 2), tmp_path)
    assert result.status == "unseen"
    assert rows([result]) == []
    assert "unseen: 1:drift:2: drift: nothing" in text([result])


def test_a_plant_that_raises_is_counted(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def fails(trial: Trial, folder: Path) -> Written:
        raise RuntimeError("the integration failed")

    monkeypatch.setattr(command, "write_trial", fails)
    result = command.in_a_folder(Trial(1, ("drift",), 2), tmp_path)
    assert (result.status, result.named) == ("raised", [])
    (row,) = rows([result])
    assert (row.trials, row.without) == (1, 1)


def test_the_cases_are_what_was_asked_for() -> None:
    trials = command.options_of(["--cases", "16x2", "nothingx3", "--seed", "5"]).trials
    assert len(trials) == 35
    assert [trial.names for trial in trials[:17]] == [*((name,) for name in LIBRARY), ()]
    assert sorted({trial.seed for trial in trials}) == [5, 6, 7]
    assert len(command.options_of(["--cases", "outsidex1", "faultsx2"]).trials) == len(OUTSIDE) + 2 * len(FAULTS)
    pairs = command.options_of(["--cases", "pairsx9", "--fit-runs", "2,6"]).trials
    assert len(pairs) == 18
    assert all(len(set(trial.names)) == 2 and set(trial.names) <= set(LIBRARY) for trial in pairs)
    assert len({trial.names for trial in pairs}) > 4
    only = command.options_of(["--cases", "16x4", "--only", "drift", "--first", "3"]).trials
    assert [str(trial) for trial in only] == ["0:drift:2", "1:drift:2", "2:drift:2"]
    later = command.options_of(["--cases", "16x4", "--only", "drift", "--skip", "1", "--first", "2"]).trials
    assert later == only[1:]
    assert [str(trial) for trial in command.options_of(["--cases", "airflowx2"]).trials] == [
        "0:airflow:2",
        "1:airflow:2",
    ]
    (one,) = command.options_of(["--case", "4:airflow+drift:6"]).trials
    assert one == Trial(4, ("airflow", "drift"), 6)


@pytest.mark.parametrize(
    "arguments",
    [
        ["--keep", "x"],
        ["--cases", "windx3"],
        ["--cases", "16"],
        ["--case", "1:wind:2"],
        ["--only", "wind"],
        ["--fit-runs", "21"],
        ["--jobs", "3"],
        ["--go-on"],
    ],
)
def test_wrong_arguments_are_told(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as told:
        command.options_of(arguments)
    assert told.value.code == 2
    assert "error:" in capsys.readouterr().err


def test_the_command_judges_the_trials_and_writes_them_down(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[str] = []

    def answer(trial: Trial, models: Path, *, kind: str, accept_change: bool) -> Judged:
        assert (kind, accept_change) == ("network", False)
        assert models == tmp_path / "models"
        asked.append(str(trial))
        return made(str(trial), trial.names)

    monkeypatch.setattr(command, "in_a_folder", answer)
    out = tmp_path / "made" / "table.json"
    arguments = ["--cases", "driftx2", "nothingx2", "--json", str(out), "--models", str(tmp_path / "models")]
    monkeypatch.setattr("sys.argv", ["network_refinement", *arguments])
    command.main()
    assert asked == ["0:drift:2", "0:nothing:2", "1:drift:2", "1:nothing:2"]
    left = json.loads(out.read_text(encoding="utf-8"))
    assert [entry["trial"] for entry in left["trials"]] == asked
    assert left["trials"][0]["first"] is True
    assert [row["planted"] for row in left["table"]] == ["drift", "nothing"]
    assert next(goal for goal in left["goals"]["2"] if goal["text"] == "nothing: nothing named")["reached"] == 1.0
    told = capsys.readouterr()
    assert re.search(r"right name first +100 % of 2 ", told.out)
    assert "1/4 0:drift:2: named drift, explained; 4.00 -> 1.10 floors" in told.err


def test_an_interrupted_command_goes_on(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked: list[str] = []

    def answer(trial: Trial, models: Path, **_: object) -> Judged:
        asked.append(str(trial))
        return made(str(trial), trial.names)

    monkeypatch.setattr(command, "in_a_folder", answer)
    out = tmp_path / "table.json"
    before = [made("0:drift:2", ["airflow"], after_K=float("nan"))]
    out.write_text(command.as_json(before), encoding="utf-8")
    monkeypatch.setattr("sys.argv", ["network_refinement", "--cases", "driftx3", "--json", str(out), "--go-on"])
    command.main()
    assert asked == ["1:drift:2", "2:drift:2"]
    left = command.judged_before(out)
    assert [result.trial for result in left] == ["0:drift:2", "1:drift:2", "2:drift:2"]
    assert left[0].after_K != left[0].after_K  # no number stays none
    assert left[0].effects == before[0].effects


def test_one_trial_is_left_to_look_at(
    written: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = Answers(written, perfect(written))
    kept = tmp_path / "kept"
    answers.written = Written(
        written.trial,
        written.setting,
        tuple(kept / path.name for path in written.fit),
        tuple(kept / path.name for path in written.test),
        written.floor_K,
    )
    answering(monkeypatch, answers)
    monkeypatch.setattr("sys.argv", ["network_refinement", "--case", str(TRIAL), "--keep", str(kept)])
    command.main()
    files = {path.name for path in (*written.fit, *written.test)}
    left = {path.name for path in kept.iterdir()}
    assert {"identified.json", "refined.json", "judged.json", "truth.json", *files} == left
    true = json.loads((kept / "truth.json").read_text(encoding="utf-8"))
    assert true["planted"][0]["name"] == "load_heating"
    assert true["bench"]["plant"]["capacity"] == list(bench(2).plant.capacity)
    assert re.search(r"right name first +100 % of 1 ", capsys.readouterr().out)
