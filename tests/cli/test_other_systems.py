"""What works without Linux: modules and functions that Windows lacks are hidden, and the commands run all the same."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.files import replace_folder
from gen.toolchain import run as run_tool

# asyncio and pyserial have modules of their own for each system, and take those of the one that they are on.
HIDDEN = """
import asyncio, serial, sys
GONE = {"pty", "tty", "fcntl", "termios", "resource", "grp", "pwd", "syslog", "readline", "crypt"}
class Hide:
    def find_spec(self, name, path=None, target=None):
        if name in GONE:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
for name in GONE:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Hide())
import os, signal
for name in ("killpg", "fork", "forkpty", "setsid", "getuid", "geteuid", "ttyname", "openpty", "mkfifo"):
    delattr(os, name)
for name in ("SIGKILL", "SIGALRM", "SIGHUP", "SIGPIPE", "SIGUSR1", "alarm", "setitimer", "pthread_kill"):
    delattr(signal, name)
"""
IMPORTS = """
import importlib, pkgutil, gen
for module in pkgutil.walk_packages(gen.__path__, "gen."):
    if module.name.rpartition(".")[2] != "__main__":
        importlib.import_module(module.name)
"""
COMMANDS = """
import json
from gen.__main__ import main
for command in json.loads(sys.stdin.read()):
    sys.argv = ["gen", *command]
    try:
        main()
    except SystemExit as end:
        assert not end.code, (command, end.code)
"""


def without(program: str, *, given: str = "", cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", HIDDEN + program], input=given, capture_output=True, text=True, check=False, cwd=cwd
    )


def test_the_modules_are_hidden() -> None:
    assert "No module named 'termios'" in without("import termios").stderr
    assert "has no attribute 'killpg'" in without("os.killpg").stderr


def test_every_module_can_be_imported() -> None:
    done = without(IMPORTS)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_way_from_a_log_to_a_project_needs_nothing_of_it(tmp_path: Path) -> None:
    """Import, plot, identify, simulate, refine, build with its report, check, init."""
    time = np.arange(0.0, 2400.0, 4.0)
    rng = np.random.default_rng(1)
    for name, duty in (("mon", 0.4), ("tue", 1.0), ("wed", 0.7)):
        drive = np.where(time < 1600.0, duty, 0.0)
        rise = np.zeros(time.size)
        for k in range(1, time.size):
            rise[k] = rise[k - 1] + 4.0 / 200.0 * (40.0 * drive[k - 1] - rise[k - 1])
        coil = np.round(21.0 + rise + rng.normal(0.0, 0.05, time.size), 3)
        frame = pd.DataFrame({"t [s]": time, "duty": drive, "coil [degC]": coil, "ambient [degC]": 21.0})
        frame.to_csv(tmp_path / f"{name}.csv", index=False, sep=";")
    runs = ["runs/mon.csv", "runs/tue.csv"]
    commands = [
        ["import", "mon.csv", "tue.csv", "wed.csv", "--out", "runs"],
        ["plot", *runs, "--out", "runs.html"],
        ["plot", *runs, "--out", "runs.png"],
        ["identify", *runs, "--out", "coeffs.json", "--report", "identified.html"],
        ["identify", *runs, "--out", "network.json", "--model", "network", "--max-hidden", "0"],
        ["simulate", "coeffs.json", "runs/wed.csv", "--arithmetic", "fixed", "--out", "simulated.csv"],
        ["plot", *runs, "--model", "coeffs.json", "--out", "runs.svg"],
        ["init", "coeffs.json", "--out", "start.json"],
        [
            "refine",
            "coeffs.json",
            "--fit",
            *runs,
            "--test",
            "runs/wed.csv",
            "--out",
            "refined.json",
            "--report",
            "r.html",
        ],
        ["build", "refined.json", "--out", "project"],
        ["build", "network.json", "--out", "other"],
        ["build", "refined.json", "--out", "project"],
        ["check", "project"],
    ]
    done = without(COMMANDS, given=json.dumps(commands), cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    for path in ("runs.html", "runs.png", "runs.svg", "identified.html", "r.html", "project/report.html"):
        assert (tmp_path / path).stat().st_size > 1000, path
    assert json.loads((tmp_path / "coeffs.json").read_text())["provenance"]["data"] == ["mon.csv", "tue.csv"]


def test_a_pseudo_terminal_is_refused_in_words(tmp_path: Path) -> None:
    done = without(
        "from pathlib import Path\nfrom gen.emulate.terminal import PseudoTerminal\nPseudoTerminal(Path('board'))",
        cwd=tmp_path,
    )
    assert "InputError: board: this system has no pseudo-terminals; expected Linux or macOS" in done.stderr


def test_an_interrupted_tool_is_ended_where_there_are_no_groups_of_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr("os.killpg")

    def interrupted(_: subprocess.Popen[str]) -> None:
        raise KeyboardInterrupt

    started: list[subprocess.Popen[str]] = []
    real = subprocess.Popen

    def kept(*arguments: object, **options: object) -> subprocess.Popen[str]:
        started.append(real(*arguments, **options))  # type: ignore[call-overload]
        return started[-1]

    monkeypatch.setattr(real, "communicate", interrupted)
    monkeypatch.setattr("gen.toolchain.subprocess.Popen", kept)
    with pytest.raises(KeyboardInterrupt):
        run_tool([sys.executable, "-c", "import time; time.sleep(60)"])
    assert started[0].poll() is not None
    for pipe in (started[0].stdout, started[0].stderr):
        assert pipe is not None
        pipe.close()


def test_a_project_can_be_replaced_where_text_files_get_other_line_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows writes CR LF unless told not to; then no file is as the manifest says."""
    real = Path.write_text

    def as_windows(path: Path, text: str, encoding: str | None = None, newline: str | None = None) -> int:
        return real(path, text.replace("\n", "\r\n") if newline is None else text, encoding=encoding, newline="")

    monkeypatch.setattr(Path, "write_text", as_windows)
    files = {"a.txt": "one\ntwo\n"}
    digest = hashlib.sha256(files["a.txt"].encode()).hexdigest()
    files["manifest.json"] = json.dumps({"tool": "gen 1", "files": {"a.txt": digest}})
    for _ in range(2):
        replace_folder(tmp_path / "project", files)
