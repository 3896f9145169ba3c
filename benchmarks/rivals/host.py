"""What the tools cost on this computer, as ratios within one run.

Steps: processor time of one sample of the MY1016's four components, as a multiple of what the emitted library takes
that g++ compiled, with the pipe that feeds it. Commands: processor time of `gen COMMAND --help`, and of some work, as
a multiple of `python -c pass`, with the most memory that the process held.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.box import MARKDOWN
from rich.table import Table

from benchmarks.rivals.code.ours import told
from benchmarks.rivals.growth.measure import processor_s
from gen.coefficients import load
from gen.errors import CheckFailed
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.model import ExactSolution
from gen.reference.board import reference_of
from gen.verification.profiles import Integers, Profile
from gen.verification.runners import HostRunner, write_library

ROOT = Path(__file__).parents[2]
MY1016 = ROOT / "examples" / "my1016" / "coeffs.json"
LANES = 64
ARITHMETICS: tuple[Arithmetic, ...] = ("fixed", "float")
COMMANDS = (
    "build", "verify", "check", "simulate", "emulate", "log", "live", "import", "identify", "thresholds", "refine",
    "plan", "plot", "init",
)  # fmt: skip
TRIES = 3
"""Of each process; the least counts."""
LAUNCHER = """
import os, sys
nowhere = [(os.POSIX_SPAWN_OPEN, number, os.devnull, os.O_WRONLY, 0) for number in (1, 2)]
pid = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ, file_actions=nowhere)
_, status, usage = os.wait4(pid, 0)
print(os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, usage.ru_maxrss)
"""
"""Starts a process from a small one: the most memory of a process counts what its parent held when it was started."""


@dataclass(frozen=True)
class Rate:
    """How long a sample takes, as a multiple of the compiled library's."""

    title: str
    multiple: float


@dataclass(frozen=True)
class Start:
    """A process: its processor time as a multiple of `python -c pass`, and the most memory that it held, in MB."""

    title: str
    multiple: float
    memory_MB: float


def host(quick: bool, tell: Callable[[str], None]) -> tuple[list[Rate], list[Start]]:
    """Measure both tables; `quick`: fewer samples, and only some commands."""
    tell("steps")
    made = rates(500 if quick else 4000)
    return made, starts(COMMANDS[:3] if quick else COMMANDS, tell)


def rates(length: int) -> list[Rate]:
    """Time all simulators on random PWM.

    Parameters
    ----------
    length
        Samples of each of `LANES` lanes, and of the one lane; the compiled library runs twenty times as many.
    """
    model = load(MY1016).model
    pwm = np.random.default_rng(7).integers(-255, 256, (LANES, length))
    found: dict[str, float] = {}
    for arithmetic in ARITHMETICS:
        program = lower(load(MY1016), arithmetic, "table")
        found[f"{arithmetic}: emitted library, g++ -O2"] = _library(program, np.tile(pwm, (1, 20)))
        found[f"{arithmetic}: reference, {LANES} lanes at once"] = _reference(program, pwm)
        found[f"{arithmetic}: reference, one lane"] = _reference(program, pwm[:1])
    exact = ExactSolution(model)
    exact.simulate(pwm)  # the exponentials are made
    found[f"exact solution, {LANES} lanes at once"] = taken(lambda: exact.simulate(pwm)) / pwm.size
    unit = found["fixed: emitted library, g++ -O2"]
    return [Rate(title, seconds / unit) for title, seconds in found.items()]


def _library(program: Program, pwm: Integers) -> float:
    """Processor time of a sample of the compiled library, s."""
    coefficients = load(MY1016)
    context = project_context(coefficients, program, coefficients.name)
    profile = told(program, Profile(pwm, np.zeros(len(pwm), dtype=np.int64)))
    with tempfile.TemporaryDirectory(prefix="rivals-") as folder:
        runner = HostRunner(write_library(program, context, render.library(context), Path(folder)), "g++ -O2")
        return taken(lambda: runner.run(profile)) / profile.samples


def _reference(program: Program, pwm: Integers) -> float:
    """Processor time of a sample of the reference, s."""
    model = reference_of(program, [0] * len(pwm))

    def run() -> None:
        for step in range(pwm.shape[1]):
            model.step(pwm[:, step])

    return taken(run) / pwm.size


def starts(commands: Sequence[str], tell: Callable[[str], None]) -> list[Start]:
    """Start each command, and do some work with three."""
    gen = [sys.executable, "-m", "gen"]
    unit, memory = process([sys.executable, "-c", "pass"])
    found = [Start("python -c pass", 1.0, memory)]
    for name in commands:
        tell(f"gen {name} --help")
        seconds, memory = process([*gen, name, "--help"])
        found.append(Start(f"gen {name} --help", seconds / unit, memory))
    with tempfile.TemporaryDirectory(prefix="rivals-") as folder:
        for arithmetic in ARITHMETICS:
            tell(f"gen build, {arithmetic}")
            out = ["--out", f"{folder}/{arithmetic}", "--arithmetic", arithmetic]
            seconds, memory = process([*gen, "build", str(MY1016), *out], 1)
            found.append(Start(f"gen build of the MY1016, {arithmetic}/table", seconds / unit, memory))
        tell("gen check")
        seconds, memory = process([*gen, "check", f"{folder}/fixed"], 1)
        found.append(Start("gen check of it, fixed/table", seconds / unit, memory))
    return found


def process(command: Sequence[str], tries: int = TRIES) -> tuple[float, float]:
    """Run a process: its least processor time, s, and the most memory that it held, MB.

    Raises
    ------
    CheckFailed
        When it fails.
    """
    least, most = float("inf"), 0.0
    for _ in range(tries):
        done = subprocess.run(
            [sys.executable, "-S", "-c", LAUNCHER, *command], capture_output=True, text=True, check=True, cwd=ROOT
        )
        status, seconds, kilobytes = done.stdout.split()
        if int(status):
            raise CheckFailed(f"{' '.join(command)} ends with {status}")
        least, most = min(least, float(seconds)), max(most, int(kilobytes) / 1024)
    return least, most


def taken(work: Callable[[], object]) -> float:
    """Processor time of this process and of those that it started, s."""
    begun = processor_s()
    work()
    return processor_s() - begun


def rates_table(found: Sequence[Rate]) -> Table:
    """Make the table of the simulators."""
    table = Table("simulator", "time of a sample", box=MARKDOWN)
    for one in found:
        table.add_row(one.title, f"x {one.multiple:.3g}")
    return table


def starts_table(found: Sequence[Start]) -> Table:
    """Make the table of the commands."""
    table = Table("command", "processor time", "most memory", box=MARKDOWN)
    for one in found:
        table.add_row(f"`{one.title}`", f"x {one.multiple:.0f}", f"{one.memory_MB:.0f} MB")
    return table
