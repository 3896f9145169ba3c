"""`gen import` as a user meets it, and what it writes in the hands of the other commands."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.interface import import_runs, load, simulate
from gen.runs import read_run
from tests.cli.commands import COEFFICIENTS
from tests.command import GEN, gen
from tests.importing.logs import truth

TEXT = str(truth().to_csv(index=False, lineterminator="\n"))


def test_the_table_says_what_was_taken_how_sure_and_why(tmp_path: Path) -> None:
    (tmp_path / "bench.csv").write_text(TEXT.replace("time_s", "t [ms]"))
    done = gen("import", "bench.csv", "--out", "runs", "--mapping", "map.toml", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    row = next(line for line in lines if line.startswith("t [ms]"))
    assert row.split()[2:] == ["time", "in", "ms", "0.95", "by", "its", "name", "and", "unit;", "it", "rises"]
    assert lines[-1].startswith("runs/bench.csv: 120 rows")
    assert 'unit = "ms"' in (tmp_path / "map.toml").read_text()
    again = gen("import", "bench.csv", "--out", "again", "--mapping", "map.toml", cwd=tmp_path)
    assert again.returncode == 0
    assert " 0." not in again.stdout  # nothing guessed
    assert (tmp_path / "again" / "bench.csv").read_bytes() == (tmp_path / "runs" / "bench.csv").read_bytes()


def test_folders_above_the_new_one_are_made(tmp_path: Path) -> None:
    (tmp_path / "bench.csv").write_text(TEXT)
    import_runs([tmp_path / "bench.csv"], out=tmp_path / "motors" / "third" / "runs")
    assert (tmp_path / "motors" / "third" / "runs" / "bench.csv").is_file()


def test_a_doubt_is_one_line_on_stderr_and_nothing_is_written(tmp_path: Path) -> None:
    (tmp_path / "bench.csv").write_text(TEXT.replace(",204,", ",80,").replace("time_s", "t [s]"))
    done = gen("import", "bench.csv", "--out", "runs", "--mapping", "map.toml", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("error: bench.csv: doubtful: pwm: ")
    assert "0.40 ?" in done.stdout
    assert [item.name for item in tmp_path.iterdir()] == ["bench.csv"]
    told = gen("import", "bench.csv", "--out", "runs", "--unit", "pwm=percent", cwd=tmp_path)
    assert told.returncode == 0, told.stderr


def test_options_are_those_of_the_function(tmp_path: Path) -> None:
    (tmp_path / "bench.csv").write_text("a,b,c\n" + TEXT.split("\n", 1)[1].replace(",21.0\n", "\n"))
    frame = truth().iloc[:, :3].set_axis(["a", "b", "c"], axis=1)
    frame.to_csv(tmp_path / "bench.csv", index=False)
    options = ["--time", "a", "--unit", "a=s", "--input", "b", "--full-scale", "255", "--column", "c=coil"]
    done = gen("import", "bench.csv", "--out", "runs", *options, "--unit", "c=degC", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    run = read_run(tmp_path / "runs" / "bench.csv")
    np.testing.assert_array_equal(run.temps["coil"], truth().winding_degC)
    np.testing.assert_array_equal(run.pwm, truth().pwm)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["missing.csv"], "error: missing.csv: there is no such file; expected a log"),
        (["bench.csv", "bench.csv"], "error: bench.csv: is given twice; expected each run once"),
        (["bench.csv", "--column", "x"], 'error: --column: found "x", expected OLD=NEW'),
    ],
)
def test_bad_usage_is_one_line(arguments: list[str], said: str, tmp_path: Path) -> None:
    (tmp_path / "bench.csv").write_text(TEXT)
    done = gen("import", *arguments, "--out", "runs", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.strip()) == (2, "", said)


def test_nothing_in_a_file_steers_the_terminal(tmp_path: Path) -> None:
    text = TEXT.replace("casing_degC", "cas\x1b[31ming_degC").replace("pwm", "[bold]pwm[/bold]")
    (tmp_path / "bench.csv").write_text(text)
    done = gen("import", "bench.csv", "--out", "runs", cwd=tmp_path)
    assert "\x1b" not in done.stdout + done.stderr
    assert "[bold]pwm[/bold]" in done.stdout


def test_an_interrupted_import_leaves_nothing(tmp_path: Path) -> None:
    rows = np.arange(60_000)
    frame = pd.DataFrame({"time_s": rows * 0.25, "pwm": 200, "winding_degC": 20 + rows % 400 / 10})
    frame.to_csv(tmp_path / "bench.csv", index=False)
    for delay in (0.3, 0.7, 1.1, 1.5):
        process = subprocess.Popen(
            [*GEN, "import", "bench.csv", "--out", "runs"],
            cwd=tmp_path,
            stderr=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ},
        )
        time.sleep(delay)
        process.send_signal(signal.SIGINT)
        process.communicate()
        if (tmp_path / "runs").exists():
            assert read_run(tmp_path / "runs" / "bench.csv").time_s.size == rows.size
            (tmp_path / "runs" / "bench.csv").unlink()
            (tmp_path / "runs").rmdir()
        assert [item.name for item in tmp_path.iterdir()] == ["bench.csv"]


def test_what_is_written_is_simulated_and_identified(tmp_path: Path) -> None:
    """A motor's model gives a log in another dialect; imported, it is the run that was simulated, and is identified."""
    model = load(COEFFICIENTS)
    part = model.components[-1]
    for pwm in (102, 204):
        times = pd.Index(np.arange(0.0, 14_400.0, 20.0), name="time_s")
        true = simulate(model, pd.DataFrame({"pwm": pwm, "ambient_degC": 22.0}, index=times))
        log = pd.DataFrame(
            {
                "Zeit": (pd.Timestamp("2024-05-01 22:00:00") + pd.to_timedelta(times, unit="s")).strftime("%H:%M:%S"),
                "PWM [%]": pwm / 2.55,
                f"T {part} [°F]": (true[f"{part}_degC"] * 1.8 + 32).round(3),
                "Raum [°F]": 71.6,
            }
        )
        log.to_csv(tmp_path / f"log_{pwm}.csv", sep=";", decimal=",", index=False, encoding="cp1252")
    found = import_runs([tmp_path / "log_102.csv", tmp_path / "log_204.csv"], tmp_path / "runs")
    run = read_run(found.runs[1])
    assert set(run.pwm.tolist()) == {204}
    again = simulate(model, found.runs[1])
    np.testing.assert_allclose(again[f"{part}_degC"], run.temps[part], atol=2e-3)
    done = gen("identify", *found.runs, "--model", "parts", "--out", tmp_path / "coeffs.json")
    assert done.returncode == 0, done.stderr
    assert [entry["name"] for entry in json.loads((tmp_path / "coeffs.json").read_text())["components"]] == [part]


def test_temperatures_and_input_in_two_files_are_not_joined_and_the_message_says_so(tmp_path: Path) -> None:
    """Each with a clock of its own, from 0."""
    true = truth()
    true.drop(columns="pwm").to_csv(tmp_path / "temps.csv", index=False)
    true[["time_s", "pwm"]].to_csv(tmp_path / "drive.csv", index=False)
    for files, said in ((["temps", "drive"], "no column is a motor's PWM"), (["drive", "temps"], "is a part's temp")):
        done = gen("import", *(f"{name}.csv" for name in files), "--out", "runs", cwd=tmp_path)
        assert (done.returncode, (tmp_path / "runs").exists()) == (2, False)
        assert said in done.stderr
        assert "put beside it first, by times of one clock" in done.stderr
    alone = gen("import", "temps.csv", "--out", "runs", cwd=tmp_path)
    assert "put beside it" not in alone.stderr


def test_an_interrupt_while_files_are_put_in_place_waits_until_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Behind the mapping, before the runs."""
    from gen.importing import importing

    def and_interrupt(path: Path, text: str) -> None:
        path.write_text(text, encoding="utf-8")
        os.kill(os.getpid(), signal.SIGINT)

    (tmp_path / "bench.csv").write_text(TEXT)
    monkeypatch.setattr(importing, "write_text", and_interrupt)
    found = import_runs([tmp_path / "bench.csv"], tmp_path / "runs", mapping=tmp_path / "map.toml")
    assert (tmp_path / "map.toml").exists()
    assert read_run(found.runs[0]).time_s.size == len(truth())
