"""Commands that only complain say so at once: what is slow to import stays out until the input is known to be good."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import pytest

from gen.cli import cli
from tests.examples import ROOT

COEFFICIENTS = ROOT / "examples" / "my1016" / "coeffs.json"
RUN = "time_s,pwm,brush_degC\n" + "".join(f"{i},102,{30 + i}\n" for i in range(10))
SLOW = {
    "control",
    "fastapi",
    "jinja2",
    "matplotlib",
    "numba",
    "pandas",
    "plotly",
    "scipy",
    "starlette",
    "tsdownsample",
    "uvicorn",
}
# Runs commands one after the other in one interpreter; a slow package that one of them loads stays loaded.
WATCHED = """
import contextlib, io, json, sys
from gen.__main__ import main
told = []
for command in json.loads(sys.stdin.read()):
    sys.argv, status = ["gen", *command.split()], 0
    with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.redirect_stdout(io.StringIO()):
        try:
            main()
        except SystemExit as end:
            status = end.code or 0
    told.append([status, said.getvalue(), sorted({name.partition(".")[0] for name in sys.modules})])
print(json.dumps(told))
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One good file of each kind, and bad ones."""
    text = COEFFICIENTS.read_text()
    files = {
        "good.json": text,
        "broken.json": text[: len(text) // 2],
        "wrong.json": text.replace('"order": 3', '"order": 5', 1),
        "rules.json": '{"alarms": []}',
        "run.csv": RUN,
        "other.csv": RUN,
        "head.csv": RUN.replace("pwm", "speed"),
        "row.csv": RUN.replace("102", "fast", 1),
        "empty.csv": "",
    }
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    return tmp_path


def complaints(folder: Path, commands: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Each command with its message; it ends with 2 in one line, writes nothing and has loaded nothing slow."""
    given = list(commands)
    before = sorted(folder.iterdir())
    for command, (status, message, loaded) in zip(given, ended(folder, given), strict=True):
        assert (status, message.count("\n"), set(loaded) & SLOW) == (2, 1, set()), command
        yield command, message
    assert sorted(folder.iterdir()) == before


def ended(folder: Path, commands: Sequence[str]) -> list[tuple[int, str, list[str]]]:
    """Status, message and loaded packages of each command."""
    done = subprocess.run(
        [sys.executable, "-c", WATCHED],
        input=json.dumps(commands),
        capture_output=True,
        text=True,
        check=True,
        cwd=folder,
    )
    found: list[tuple[int, str, list[str]]] = json.loads(done.stdout)
    return found


def test_help_loads_nothing_slow(folder: Path) -> None:
    commands = ["--help", *(f"{name} --help" for name in cli.commands)]
    for command, (status, message, loaded) in zip(commands, ended(folder, commands), strict=True):
        assert (status, message, set(loaded) & SLOW) == (0, "", set()), command


def test_a_bad_coefficient_file_is_told_before_anything_slow(folder: Path) -> None:
    commands = (
        "build {} --out out",
        "verify {}",
        "simulate {} run.csv --out out.csv",
        "emulate {} --out out.csv",
        "thresholds {} run.csv --rules rules.json --out out.json",
        "refine {} --fit run.csv --test other.csv --out out.json",
        "plot run.csv --model {} --out out.html",
        "live --emulate {}",
        "live run.csv --model {}",
        "init {} --out out.json",
        "plan {} run.csv --hours 3 --out out.csv",
    )
    for file in ("missing.json", "broken.json", "wrong.json"):
        for command, message in complaints(folder, (command.format(file) for command in commands)):
            assert message.startswith(f"error: {file}: "), command


def test_a_bad_head_of_a_run_is_told_before_anything_slow(folder: Path) -> None:
    commands = (
        "simulate good.json {} --out out.csv",
        "identify run.csv {} --out out.json",
        "thresholds good.json run.csv {} --rules rules.json --out out.json",
        "refine good.json --fit run.csv {} --test other.csv --out out.json",
        "refine good.json --fit run.csv --test other.csv {} --out out.json",
        "plot run.csv {} --model good.json --out out.svg",
        "live {} --model good.json",
        "init run.csv {} --out out.json",
        "plan good.json run.csv {} --hours 3 --out out.csv",
    )
    for file in ("missing.csv", "empty.csv", "head.csv"):
        for command, message in complaints(folder, (command.format(file) for command in commands)):
            assert message.startswith(f"error: {file}: "), command


def test_other_complaints_load_nothing_slow(folder: Path) -> None:
    (folder / "torn").mkdir()
    (folder / "torn" / "certificate.json").write_text('{"format": "gen-certificate", "version": 1')
    (folder / "old").mkdir()
    expected = {
        "check missing": "missing/certificate.json: cannot be read",
        "check old": "old/certificate.json: cannot be read",
        "check torn": "torn/certificate.json: ",
        "check missing --coefficients broken.json": "broken.json: ",
        "simulate good.json row.csv --out out.csv": "row.csv: line 2, column pwm",
        "thresholds good.json run.csv row.csv --rules rules.json --out out.json": "row.csv: line 2, column pwm",
        "thresholds good.json run.csv --rules run.csv --out out.json": "run.csv: line 1",
        "plot run.csv row.csv --out out.html": "row.csv: line 2, column pwm",
        "init run.csv row.csv --out out.json": "row.csv: line 2, column pwm",
        "verify good.json --json no/such/folder.json": "no/such/folder.json: cannot be written",
        "emulate good.json --profile 0:300 --out out.csv": "--profile: found PWM 300",
        "emulate good.json --json no/such/folder.json --out out.csv": "no/such/folder.json: cannot be written",
        "import missing.csv --out runs": "missing.csv: there is no such file; expected a log",
        "import empty.csv --out runs": "empty.csv: is empty; expected a log",
        "import run.csv --out runs --mapping broken.json": "broken.json: is not TOML",
        "import run.csv --out runs --column x": '--column: found "x", expected OLD=NEW',
        "log no-such-port --out out.csv": "no-such-port: cannot be opened",
    }
    for command, message in complaints(folder, expected):
        assert message.startswith(f"error: {expected[command]}"), command
