"""Plants mutants in copies of the repository and runs their tests there.

Each trial is a fork of this process, which has the slow libraries loaded already and none of ``gen``; the copies stand
in a temporary folder and are removed.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import re
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.mutants.defects import Mutant

_HEAVY: tuple[str, ...] = (
    "numpy",
    "scipy.linalg",
    "scipy.optimize",
    "scipy.stats",
    "scipy.interpolate",
    "scipy.integrate",
    "pandas",
)
_HEAVY += ("openpyxl", "PIL.Image", "pydantic", "jinja2", "click", "rich.console", "pytest", "jsonschema", "serial")
# what Python has compiled goes along: it is used again only for files of the same time and size
_LEFT_OUT = shutil.ignore_patterns(".venv", ".git", "build", ".*_cache", ".hypothesis", ".pio")
CCACHE = Path("/usr/lib/ccache")
"""Debian's folder of compilers that remember what they compiled."""
_NO_PROGRAM = re.compile(r"\.(?:cpp|h|c):\d+:\d+: error:|does not compile|ImportError while importing|SyntaxError:")


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant.

    Attributes
    ----------
    mutant
        Which.
    outcome
        "caught", "survived", "too slow" (its tests were not through in time: it hangs, or nobody knows), "no program"
        (it does not compile or cannot be imported, which no test has to see) or "not tested".
    by
        The test that failed.
    seconds
        Of the trial.
    tests
        How many were to be run.
    """

    mutant: Mutant
    outcome: str
    by: str = ""
    seconds: float = 0.0
    tests: int = 0


@dataclass
class _Running:
    pid: int
    folder: Path
    output: Path
    mutant: Mutant
    tests: int
    began: float


def run(planned: Sequence[tuple[Mutant, Sequence[str]]], root: Path, jobs: int, limit_s: float) -> Iterator[Verdict]:
    """Try each mutant with its tests, in order, up to `jobs` at once; the first failing test ends a trial.

    Parameters
    ----------
    planned
        Mutants, each with tests as pytest takes them.
    root
        The repository; it is only read.
    jobs
        Copies.
    limit_s
        For one trial.
    """
    for name in _HEAVY:
        importlib.import_module(name)
    with tempfile.TemporaryDirectory(prefix="mutants-") as made:
        free = [Path(made) / str(number) for number in range(jobs)]
        for folder in free:
            shutil.copytree(root, folder, ignore=_LEFT_OUT)
        running: list[_Running] = []
        waiting = list(reversed(planned))
        try:
            while waiting or running:
                while waiting and free:
                    mutant, tests = waiting.pop()
                    if not tests:
                        yield Verdict(mutant, "not tested")
                        continue
                    running.append(_started(mutant, tests, free.pop()))
                time.sleep(0.05)
                for trial in list(running):
                    verdict = _ended(trial, limit_s)
                    if verdict is not None:
                        running.remove(trial)
                        shutil.copy2(root / trial.mutant.path, trial.folder / trial.mutant.path)
                        free.append(trial.folder)
                        yield verdict
        finally:
            for trial in running:
                _stop(trial)


def _started(mutant: Mutant, tests: Sequence[str], folder: Path) -> _Running:
    (folder / mutant.path).write_text(mutant.text, encoding="utf-8")
    output = folder / "trial.txt"
    sys.stdout.flush()
    pid = os.fork()
    if pid == 0:
        _child(folder, output, tests)
    return _Running(pid, folder, output, mutant, len(tests), time.perf_counter())


def _child(folder: Path, output: Path, tests: Sequence[str]) -> None:
    """Never returns."""
    code = 70
    try:
        os.setsid()
        os.chdir(folder)
        with output.open("w") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
        os.environ |= {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", **_compilers_that_remember(folder)}
        sys.dont_write_bytecode = True
        sys.path[:] = [str(folder), *sys.path[1:]]
        for name in [name for name in sys.modules if name.split(".")[0] in ("gen", "tests", "benchmarks")]:
            del sys.modules[name]
        import pytest

        code = int(pytest.main(["-x", "-q", "--tb=short", "-p", "no:cacheprovider", "--basetemp=made", *tests]))
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _compilers_that_remember(folder: Path) -> dict[str, str]:
    """Where ccache is installed, a trial compiles only what the mutant changed; nothing else depends on it."""
    if not CCACHE.is_dir():
        return {}
    # whatever folder a copy stands in, its files have the same names: relative to it
    return {"PATH": f"{CCACHE}:{os.environ['PATH']}", "CCACHE_BASEDIR": str(folder), "CCACHE_NOHASHDIR": "1"}


def _ended(trial: _Running, limit_s: float) -> Verdict | None:
    pid, status = os.waitpid(trial.pid, os.WNOHANG)
    seconds = time.perf_counter() - trial.began
    known = Verdict(trial.mutant, "", "", seconds, trial.tests)
    if pid == 0:
        if seconds < limit_s:
            return None
        _stop(trial)
        return replace(known, outcome="too slow")
    text = trial.output.read_text(encoding="utf-8", errors="replace")
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", text, re.MULTILINE)
    code = os.waitstatus_to_exitcode(status)
    if code == 0:
        return replace(known, outcome="survived")
    # a file of tests that computes something while it is imported can fail there already
    if code not in (1, 2) and code > 0 and "ERROR collecting" not in text:
        raise RuntimeError(f"pytest ended with {code} for {trial.mutant.path}:{trial.mutant.line}:\n{text[-2000:]}")
    outcome = "no program" if _NO_PROGRAM.search(text) else "caught"
    return replace(known, outcome=outcome, by=failed.group(1) if failed else f"exit status {code}")


def _stop(trial: _Running) -> None:
    """End a trial with all that it started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(trial.pid, signal.SIGKILL)
    with contextlib.suppress(ChildProcessError):
        os.waitpid(trial.pid, 0)
