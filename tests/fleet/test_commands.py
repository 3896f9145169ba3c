"""`gen fleet` as users run it."""

from __future__ import annotations

import json
import shlex
import subprocess
from pathlib import Path

import pytest

from gen.commands.fleet import fleet as group
from gen.fleet.folder.labels import labels_of, read_labels
from gen.fleet.folder.store import Store
from gen.runs import read_run, write_run
from tests.cli.commands import run_file
from tests.command import GEN, gen
from tests.fleet.made import run_of


@pytest.mark.parametrize("command", sorted(group.commands))
def test_every_command_has_an_example(command: str) -> None:
    assert (group.commands[command].epilog or "").startswith(f"Example:  gen fleet {command} ")


def test_a_run_is_added_once_with_the_day_that_it_says(tmp_path: Path) -> None:
    path = run_file(tmp_path)
    path.write_text("# started: 2026-03-04T05:06:07Z\n# fault: none\n" + path.read_text())
    for said in (
        "run.csv: runs/motor=a/day=2026-03-04/run-",
        "run.csv: already there, runs/motor=a/day=2026-03-04/run-",
    ):
        done = gen("fleet", "add", "run.csv", "--motor", "a", "--to", "store", cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith(said)
    store = Store(str(tmp_path / "store"))
    (kept,) = store.runs("a")
    assert store.run(kept).comments == read_run(path).comments


def test_pieces_of_one_log_are_kept_by_the_day_and_in_the_order_of_their_first_rows(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(
        "time,pwm,winding_degC\n"
        + "".join(
            f"2024-05-{day:02d} {hour:02d}:{minute:02d}:00,{100 + day},{20.0 + minute:.1f}\n"
            for day, hour in ((1, 8), (1, 12), (3, 2))
            for minute in range(30)
        )
    )
    assert gen("import", "log.csv", "--out", "runs", "--split", cwd=tmp_path).returncode == 0
    pieces = [f"runs/log_{number}.csv" for number in (3, 2, 1)]
    done = gen("fleet", "add", *pieces, "--motor", "a", "--to", "store", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    kept = [(each.day, each.name[:5]) for each in Store(str(tmp_path / "store")).runs("a")]
    assert kept == [("2024-05-01", "log_1"), ("2024-05-01", "log_2"), ("2024-05-03", "log_3")]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run.csv", "bad.csv", "--motor", "a"], "error: bad.csv: line 3, column pwm: "),
        (["run.csv", "--motor", "../a"], "error: --motor: "),
        (["run.csv", "--motor", "a", "--day", "2026-02-30"], "error: --day: "),
        (["run.csv", "run.csv", "--motor", "a"], "error: run.csv: is given twice"),
        (["run.csv", "room.csv", "--motor", "a"], "error: room.csv: found no reading of any part; "),
        (["empty.csv", "--motor", "a"], "error: empty.csv: found no reading of any part; "),
        (["missing.csv", "--motor", "a"], "error: missing.csv: there is no such file"),
        (["run.csv", "--motor", "a", "--label", "supplier"], "error: --label: found 'supplier', expected KEY=VALUE"),
        (["run.csv", "--motor", "a", "--label", "a=../b"], "error: --label: found 'a=../b'"),
        (["run.csv", "--motor", "a", "--label", "a=b", "--label", "a=c"], "error: --label: a is given twice"),
        (["--motor", "a", "--label", "a=b"], "error: store: a has no runs there"),
        (["--motor", "a"], "error: RUN: nothing to add"),
        (["run.csv", "--motor", "a", *(f"--label=k{n}=v" for n in range(33))], "error: --label: a would have 33"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(tmp_path: Path, arguments: list[str], said: str) -> None:
    path = run_file(tmp_path)
    (tmp_path / "bad.csv").write_text(path.read_text().replace("0.25,102", "0.25,fast"))
    (tmp_path / "room.csv").write_text("time_s,pwm,ambient_degC,current_A\n0,102,22,1\n1,102,22,1\n")
    (tmp_path / "empty.csv").write_text("time_s,pwm,brush_degC,brush_model_degC\n0,102,,40\n1,102,,40\n")
    done = gen("fleet", "add", *arguments, "--to", "store", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith(said)
    assert not (tmp_path / "store").exists()


def test_what_comes_through_a_pipe_without_a_reading_is_refused_before_the_others_are_kept(tmp_path: Path) -> None:
    run_file(tmp_path)
    head = "printf 'time_s,pwm,ambient_degC\\n0,1,22\\n1,1,22\\n'"
    command = shlex.join([*GEN, "fleet", "add", "run.csv", "/dev/stdin", "--motor", "a", "--to", "store"])
    done = subprocess.run(f"{head} | {command}", shell=True, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: /dev/stdin: found no reading of any part; ")
    assert not (tmp_path / "store").exists()


def test_labels_stay_until_they_are_given_anew_or_taken_away(tmp_path: Path) -> None:
    run_file(tmp_path)
    store, add = Store(str(tmp_path / "store")), ["fleet", "add", "--motor", "a", "--to", "store"]
    done = gen(*add, "run.csv", "--label", "supplier=A", "--label", "thermocouples=2026-03", cwd=tmp_path)
    assert done.stdout.startswith("a: supplier=A\na: thermocouples=2026-03\nrun.csv: runs/motor=a/")
    assert gen(*add, "run.csv", cwd=tmp_path).stdout.startswith("run.csv: already there")
    assert labels_of(store, ["a", "b"]) == {"a": {"supplier": "A", "thermocouples": "2026-03"}, "b": {}}
    done = gen(*add, "--label", "supplier=B", "--label", "thermocouples=", "--label", "none=", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "a: supplier=B, before A\na: thermocouples=2026-03 taken away\n")
    assert read_labels(store, "a") == {"supplier": "B"}
    store.write("labels/motor=a.json", b'["supplier"]')
    done = gen(*add, "run.csv", "--label", "supplier=C", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "store/labels/motor=a.json: is no file of labels" in done.stderr


@pytest.mark.parametrize("command", [["identify"], ["refine"], ["watch"], ["report", "--out", "pages"]])
def test_a_store_that_is_none_is_told_and_nothing_is_written(tmp_path: Path, command: list[str]) -> None:
    done = gen("fleet", command[0], "nowhere", *command[1:], cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "nowhere" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_thresholds_come_from_all_healthy_runs(fleet: Store, tmp_path: Path) -> None:
    rule = {"name": "hot", "kind": "above_model", "component": "casing", "persistence_s": 60, "settle_s": 600}
    (tmp_path / "rules.json").write_text(json.dumps({"alarms": [{**rule, "speed_percent": [10, 100]}]}))
    (tmp_path / "wrong.json").write_text(json.dumps({"alarms": [{**rule, "component": "nothing"}]}))
    command = ["fleet", "thresholds", "store", "--jobs", "1", "--rules"]
    done = gen(*command, "rules.json", cwd=tmp_path)
    assert done.returncode == 1
    assert "no healthy run is newer" in done.stderr
    for number in (0, 1):
        fleet.add(f"m{number}", "2026-02-01", "later", run_of(70 + number, hours=4.0))
    fleet.add("m2", "2026-02-01", "later", run_of(72, heat=3.0, hours=4.0))
    faulty = tmp_path / "faulty.csv"
    write_run(faulty, run_of(73, heat=3.0, hours=4.0))
    faulty.write_text("# fault: bearing\n" + faulty.read_text())
    gen("fleet", "add", "faulty.csv", "--motor", "m1", "--to", "store", "--day", "2026-02-02", cwd=tmp_path)
    done = gen(*command, "wrong.json", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "wrong.json: $.alarms[0].component" in done.stderr
    done = gen(*command, "rules.json", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "of 3 healthy runs" in done.stdout
    made = json.loads(fleet.read("thresholds/motor=m0.json"))
    assert made["alarms"][0]["threshold_K"] >= 0.5
