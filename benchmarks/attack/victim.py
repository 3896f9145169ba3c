"""One coefficient file in one form: built as `gen build` builds it, or refused."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gen.errors import CheckFailed, InputError
from gen.interface import build, load
from gen.lowering.kinds import Arithmetic, ScheduleKind

if TYPE_CHECKING:
    from gen.lowering.program import Program

FORMS: tuple[tuple[Arithmetic, ScheduleKind], ...] = (
    ("fixed", "table"),
    ("fixed", "onboard"),
    ("float", "table"),
    ("float", "onboard"),
)


@dataclass(frozen=True)
class Built:
    """What came of a build.

    Attributes
    ----------
    program
        What the board holds; None if there is none.
    refusal
        The line with which it was refused; empty if it was not.
    crash
        The traceback of anything else that ended it; empty if nothing did.
    seconds
        Processor time.
    """

    program: Program | None
    refusal: str
    crash: str
    seconds: float


def built(path: Path, arithmetic: Arithmetic, schedule: ScheduleKind) -> Built:
    """Build a file into a folder that is thrown away."""
    program: Program | None = None
    refusal = crash = ""
    began = time.process_time()
    try:
        with tempfile.TemporaryDirectory() as folder:
            made = build(load(path), Path(folder) / "out", arithmetic=arithmetic, schedule=schedule)
            program = made.program
    except (InputError, CheckFailed) as error:
        refusal = str(error)
    except Exception:  # whatever it is, a user would see it
        crash = traceback.format_exc()
    return Built(program, refusal, crash, time.process_time() - began)


def refused_by_the_command(path: Path, arithmetic: Arithmetic, schedule: ScheduleKind) -> str:
    """What is wrong with how `gen build` refuses a file; empty if it does so as it should."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        command = [sys.executable, "-m", "gen", "build", str(path), "--out", str(out)]
        done = subprocess.run(
            [*command, "--arithmetic", arithmetic, "--schedule", schedule],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        )
        told = [line for line in done.stderr.splitlines() if not line.startswith("warning:")]
        if done.returncode not in (1, 2):
            return f"exit status {done.returncode}"
        if len(told) != 1 or "Traceback" in done.stderr:
            return f"{len(told)} lines on stderr in place of one"
        return "something was written" if out.exists() else ""
