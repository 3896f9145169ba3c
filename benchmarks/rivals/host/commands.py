"""What the commands take to start, and three of them to work, as multiples of `python -c pass`."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from benchmarks.rivals.host.process import process
from benchmarks.rivals.host.simulators import ARITHMETICS, MY1016

COMMANDS = (
    "build", "verify", "check", "simulate", "emulate", "log", "live", "import", "identify", "thresholds", "refine",
    "plan", "plot", "init", "fleet",
)  # fmt: skip


@dataclass(frozen=True)
class Start:
    """A process: its processor time as a multiple of `python -c pass`, and the most memory that it held, in MB."""

    title: str
    multiple: float
    memory_MB: float


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
