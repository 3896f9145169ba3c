"""Identification and refinement over the number of runs and their length: processor time, and memory of the process."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from benchmarks.rivals.host.process import process
from benchmarks.rivals.host.runs import write_runs

Kind = Literal["parts", "network"]
Size = tuple[int, float]
KINDS: tuple[Kind, ...] = ("parts", "network")
SIZES: tuple[Size, ...] = ((2, 1.0), (2, 3.0), (2, 10.0), (6, 1.0), (20, 1.0))
QUICK_SIZES: tuple[Size, ...] = ((2, 1.0), (2, 3.0), (6, 1.0))
"""Number of runs and their length in h: longer ones, then more. All have a row a second, and four temperatures."""
TESTED: Size = (2, 3.0)
"""What refinement is judged by, whatever it learns from."""


@dataclass(frozen=True)
class Work:
    """What a command takes for runs of one size.

    Attributes
    ----------
    command, kind
        `identify` or `refine`, of parts or of a network.
    runs, hours
        How many, and how long each, h.
    seconds
        Processor time of the whole process, s.
    memory_MB
        The most that it held.
    """

    command: str
    kind: Kind
    runs: int
    hours: float
    seconds: float
    memory_MB: float


def worked(sizes: Sequence[Size], kinds: Sequence[Kind], tell: Callable[[str], None]) -> list[Work]:
    """Identify from runs of each size, and refine with as many and as long ones of the motor after it has changed.

    What is refined is for all sizes the model that the first of them gave, so that only the runs differ.

    Raises
    ------
    CheckFailed
        When a command fails.
    """
    found = []
    with tempfile.TemporaryDirectory(prefix="rivals-") as name:
        folder = Path(name)
        test = write_runs(folder, "test", *TESTED, dusty=True)
        for runs, hours in sizes:
            own = folder / f"{runs}x{hours:g}"
            fit, later = write_runs(own, "run", runs, hours), write_runs(own, "later", runs, hours, dusty=True)
            for kind in kinds:
                size = f"{kind}, {runs} runs of {hours:g} h"
                model, made = folder / f"{kind}.json", own / f"{kind}.json"
                tell(f"gen identify: {size}")
                seconds, memory = _gen("identify", fit, "--model", kind, "--out", made)
                found.append(Work("identify", kind, runs, hours, seconds, memory))
                if not model.exists():
                    made.rename(model)
                tell(f"gen refine: {size}")
                seconds, memory = _gen("refine", [model], "--fit", *later, "--test", *test, "--out", own / "new.json")
                found.append(Work("refine", kind, runs, hours, seconds, memory))
    order = [(command, kind) for command in ("identify", "refine") for kind in kinds]
    return sorted(found, key=lambda one: order.index((one.command, one.kind)))


def _gen(command: str, files: Sequence[Path], *options: str | Path) -> tuple[float, float]:
    return process([sys.executable, "-m", "gen", command, *map(str, (*files, *options))], 1)
