"""The table that judges identification: a perfect model, hand-made ones, and what refuses, raises or leaves out."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import gen
from benchmarks.network_identification import __main__ as command
from benchmarks.network_identification import rest
from benchmarks.network_identification.judge import Held, Judged, judge
from benchmarks.network_identification.table import by_rest, more_data, rested, rows, text
from benchmarks.plants.cases import Case, Written, fresh_runs, write_case
from benchmarks.plants.profiles import DataKind
from benchmarks.plants.rooms import RoomKind
from gen.errors import CheckFailed, InputError

CASE = Case(1, DataKind.UNSETTLED, RoomKind.HELD)


@dataclass
class Oracle:
    """A model that says what it is told to, as far as the judge asks."""

    components: tuple[str, ...]
    text: str = "{}"

    def save(self, path: Path) -> None:
        path.write_text(self.text, encoding="utf-8")


@dataclass
class Found:
    """What identification gives, as far as the judge asks."""

    model: Oracle
    table: pd.DataFrame = field(default_factory=pd.DataFrame)
    warnings: tuple[str, ...] = ()
    choice: None = None

    def summary(self) -> pd.DataFrame:
        return self.table


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Written:
    return write_case(CASE, tmp_path_factory.mktemp("case"))


def names(files: Written) -> list[str]:
    return [files.bench.plant.names[node] for node in files.bench.plant.sensed]


def truth(files: Written, off: float = 0.0) -> Any:  # noqa: ANN401 (stands in for gen.simulate)
    """A simulator that knows the plant's own temperatures, and is off by a constant."""
    runs = {run.profile.name: run.run for run in fresh_runs(files.bench, CASE.room)}

    def simulate(_: Oracle, path: Path) -> pd.DataFrame:
        run = runs[path.stem]
        plant = files.bench.plant
        columns = {f"{plant.names[node]}_degC": run.temperature[:, node] + off for node in plant.sensed}
        return pd.DataFrame(columns, index=pd.Index(run.time, name="time_s"))

    return simulate


def judged(files: Written, monkeypatch: pytest.MonkeyPatch, found: Found, folder: Path, off: float = 0.0) -> Judged:
    monkeypatch.setattr(gen, "identify", lambda runs, **_: found)
    monkeypatch.setattr(gen, "simulate", truth(files, off))
    result = judge(files, "parts", folder)
    assert result.status == "ok", result.message
    return result


def test_who_knows_the_truth_errs_by_one_noise_floor(
    files: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    result = judged(files, monkeypatch, Found(Oracle((*names(files), "else"))), tmp_path)
    assert result.floors == pytest.approx(1.0, rel=1e-9)
    assert result.whole
    assert set(result.by_run) == {"test_turning", "test_stopping"}
    assert set(result.by_node) == set(names(files))
    worse = judged(files, monkeypatch, Found(Oracle(tuple(names(files)))), tmp_path, off=3.0)
    assert worse.error_K == pytest.approx(np.hypot(3.0, files.floor_K), rel=0.05)  # 3 K beside noise and small biases


def test_a_node_that_the_model_lacks_is_told_and_never_good(
    files: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    result = judged(files, monkeypatch, Found(Oracle(tuple(names(files)[1:]))), tmp_path)
    assert result.left_out == names(files)[:1]
    (row,) = rows([result])
    assert row.left_out == pytest.approx(1.0 / len(names(files)))
    assert row.median < 1.3
    assert row.good == 0.0


def test_declared_errors_are_held_against_means_at_their_speeds(
    files: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def declare(low: float, high: float, pwm: tuple[int, int]) -> Found:
        band = {"pwm": pwm, "model_minus_measured_K": [low, high]}
        entries = [{"component": name, **band} for name in names(files)]
        return Found(Oracle(tuple(names(files)), json.dumps({"provenance": {"error": entries}})))

    wide = judged(files, monkeypatch, declare(0.5, 4.0, (0, 255)), tmp_path, off=2.0)
    assert wide.declared.inside == wide.declared.of > 200
    assert wide.undeclared == 0
    wrong = judged(files, monkeypatch, declare(-4.0, 0.5, (0, 255)), tmp_path, off=2.0)
    assert (wrong.declared.inside, wrong.declared.of) == (0, wide.declared.of)
    turning = judged(files, monkeypatch, declare(0.5, 4.0, (1, 255)), tmp_path, off=2.0)
    assert turning.undeclared > 0
    assert turning.declared.of + turning.undeclared == wide.declared.of
    level = fresh_runs(files.bench, CASE.room)[0].profile.holds[0][0]
    single = judged(files, monkeypatch, declare(0.5, 4.0, (level, level)), tmp_path, off=2.0)
    assert single.declared.of > 0  # both ends of a range belong to it
    assert single.declared.of + single.undeclared == wide.declared.of


def test_intervals_are_held_against_the_plants_own_rises(
    files: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    stand = files.bench
    rises = stand.plant.steady(153, stand.usual) - stand.usual
    records = []
    for number, (node, sensor) in enumerate(zip(stand.plant.sensed, stand.sensors, strict=True)):
        read = rises[node] + sensor.bias - stand.thermometer.bias
        centre, width = (rises[node], 1e-6) if number == 0 else (read, 1e-6)  # the first is right, the others as read
        records.append((stand.plant.names[node], 153, centre - width, centre + width))
        records.append((stand.plant.names[node], 0, -1.0, 1.0))
    columns = ["component", "pwm", "steady_rise_K_low", "steady_rise_K_high"]
    table = pd.DataFrame(records, columns=columns).set_index(["component", "pwm"])
    result = judged(files, monkeypatch, Found(Oracle(tuple(names(files))), table), tmp_path)
    count = len(stand.plant.sensed)
    assert result.true_rise == Held(1, count)
    assert result.read_rise == Held(count - 1, count)


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (InputError("no such thing"), "refused"),
        (CheckFailed("nothing is left"), "refused"),
        (ZeroDivisionError("by zero"), "raised"),
    ],
)
def test_what_gives_no_model_is_counted_and_named(
    files: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, error: Exception, status: str
) -> None:
    def fails(runs: object, **_: object) -> None:
        raise error

    monkeypatch.setattr(gen, "identify", fails)
    result = judge(files, "parts", tmp_path)
    assert result.status == status
    good = replace(result, case="2:unsettled:held", status="ok", error_K=1.0, by_run=by_run(1.0), nodes=4)
    (row,) = rows([result, good])
    assert (row.cases, row.refused + row.raised) == (2, 1)
    assert getattr(row, status) == 1
    assert row.good == (0.5 if good.floors <= 1.3 else 0.0)
    shown = text([result])
    assert f"{status}: 1:unsettled:held parts:" in shown
    assert str(error) in shown


def by_run(error: float) -> dict[str, float]:
    return {"test_turning": error, "test_stopping": error}


def made(case: str, floors: float, model: str = "parts", **more: Any) -> Judged:  # noqa: ANN401
    return Judged(case, model, floor_K=0.3, error_K=0.3 * floors, by_run=by_run(0.3 * floors), nodes=4, **more)


def test_only_what_a_model_is_made_from_is_disturbed(files: Written, tmp_path: Path) -> None:
    other, parts = write_case(CASE, tmp_path, disturbed_K=2.0), [f"{name}_degC" for name in names(files)]
    for number, (plain, moved) in enumerate(zip((*files.fit, *files.test), (*other.fit, *other.test), strict=True)):
        before, after = (pd.read_csv(path, comment="#") for path in (plain, moved))
        apart = float((after[parts] - before[parts]).abs().max().min())
        assert apart > 0.5 if number < len(files.fit) else apart == 0.0
        assert before.drop(columns=parts).equals(after.drop(columns=parts))
    assert other.floor_K == files.floor_K


@pytest.mark.parametrize(("seed", "rests"), [(1837, False), (1838, True)])
def test_who_rested_is_told_by_what_the_runs_hold(seed: int, rests: bool, tmp_path: Path) -> None:
    case = Case(seed, DataKind.MIXED, RoomKind.HELD)
    runs = [pd.read_csv(path, comment="#") for path in write_case(case, tmp_path).fit]
    assert any((run.pwm == 0).any() for run in runs) == rests == rested(case)


def test_what_nobody_can_know_of_a_motor_that_never_rested(capsys: pytest.CaptureFixture[str]) -> None:
    """Of two motors the one that rested is left out; the other's readings are missed by no less than their noise."""
    rest.main(["--plants", "2", "--seed", "1837", "--data", "mixed"])
    told, _, *lines = capsys.readouterr().out.splitlines()
    assert " 1 plants:" in told
    floors = [float(line.split()[3]) for line in lines]
    assert len(floors) == len(rest.FACTORS)
    assert 0.95 < min(floors) < max(floors)


def test_motors_that_never_rested_are_told_apart() -> None:
    both = [made("1837:mixed:held", 3.4), made("1838:mixed:held", 0.9)]
    assert by_rest(both) == [
        "parts, mixed, held: median 3.40, 90 % 3.40, within 1.3 0 % in 1 whose runs never rest; "
        "0.90, 90 % 0.90, within 1.3 100 % in 1 others"
    ]
    assert by_rest(both[:1]) == []


def test_the_percentiles_are_those_of_the_models_and_good_counts_every_case() -> None:
    results = [made(f"{seed}:long:moving", 1.0 + 0.05 * seed) for seed in range(11)]
    (row,) = rows(results)
    assert row.median == pytest.approx(1.25)
    assert row.high == pytest.approx(1.45)
    assert row.good == pytest.approx(7 / 11)
    refused = [*results, Judged("11:long:moving", "parts", "refused", "why")]
    (row,) = rows(refused)
    assert row.median == pytest.approx(1.25)
    assert row.good == pytest.approx(7 / 12)


def test_a_model_that_more_data_made_worse_is_named() -> None:
    results = [
        made("3:steps:held", 1.1),
        made("3:mixed:held", 1.15),
        made("4:steps:held", 1.1),
        made("4:mixed:held", 9.0),
        made("5:steps:held", 1.1),
        made("5:mixed:held", 1.0, left_out=["brush"]),
        made("6:steps:held", 1.1),
        made("6:mixed:held", 9.0, model="network"),
    ]
    (line,) = more_data(results)
    assert "2 of 3 models" in line
    assert "plants 5, 4" in line
    assert line.startswith("parts, held")


def test_the_command_judges_the_cases_that_were_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[str] = []

    def answer(case: Case, models: list[str], disturbed_K: float) -> list[Judged]:
        asked.append(f"{case}:{disturbed_K:g}")
        return [made(str(case), 1.0, model) for model in models]

    monkeypatch.setattr(command, "in_a_folder", answer)
    out = tmp_path / "made" / "table.json"
    arguments = [
        "--plants",
        "2",
        "--seed",
        "7",
        "--data",
        "steps,long",
        "--room",
        "moving",
        "--disturbed",
        "1.5",
        "--json",
        str(out),
    ]
    monkeypatch.setattr("sys.argv", ["network_identification", *arguments])
    command.main()
    assert asked == [f"{case}:moving:1.5" for case in ("7:steps", "7:long", "8:steps", "8:long")]
    written = json.loads(out.read_text(encoding="utf-8"))
    assert [f"{entry['case']}:1.5" for entry in written["cases"]] == asked
    assert [(row["data"], row["cases"]) for row in written["table"]] == [("steps", 2), ("long", 2)]
    assert written["cases"][0]["message"] == ""
    assert "parts    steps      moving          2" in capsys.readouterr().out


def test_one_case_is_left_to_look_at(
    files: Written, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(gen, "identify", lambda runs, **_: Found(Oracle(tuple(names(files)))))
    monkeypatch.setattr(gen, "simulate", truth(files))
    monkeypatch.setattr("sys.argv", ["network_identification", "--case", str(CASE), "--keep", str(tmp_path / "kept")])
    command.main()
    left = {path.name for path in (tmp_path / "kept").iterdir()}
    assert {"parts.json", "judged.json", "plant.json", *(path.name for path in (*files.fit, *files.test))} == left
    drawn = json.loads((tmp_path / "kept" / "plant.json").read_text(encoding="utf-8"))
    assert tuple(drawn["plant"]["capacity"]) == files.bench.plant.capacity
    assert "parts    unsettled  held            1" in capsys.readouterr().out


def test_a_plant_that_cannot_be_written_is_counted_too(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def fails(case: Case, folder: Path, disturbed_K: float) -> Written:
        raise RuntimeError("no plant within the limits")

    monkeypatch.setattr(command, "write_case", fails)
    (result,) = command.in_a_folder(CASE, ["parts"], tmp_path)
    assert (result.status, result.case) == ("raised", str(CASE))
    assert "no plant within the limits" in result.message
    assert json.loads(command.as_json([result]))["cases"][0]["error_K"] is None


@pytest.mark.parametrize("arguments", [["--keep", "x"], ["--data", "stairs"], ["--case", "1:steps"], ["--jobs", "3"]])
def test_wrong_arguments_are_told(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as told:
        command.options_of(arguments)
    assert told.value.code == 2
    assert "error:" in capsys.readouterr().err


def test_the_parts_are_judged_from_files_to_figures(tmp_path: Path) -> None:
    """The whole way once: an identification, its model on runs that took no part."""
    (result,) = command.in_a_folder(Case(7, DataKind.STEPS, RoomKind.HELD), ["parts"], tmp_path)
    assert result.status == "ok", result.message
    assert 0.9 < result.floors < 40.0
    assert result.declared.of + result.undeclared > 200
    assert result.true_rise.of == result.read_rise.of == 5 * (result.nodes - len(result.left_out))
    assert gen.load(tmp_path / "parts.json").components
