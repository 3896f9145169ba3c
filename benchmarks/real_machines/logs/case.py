"""What is fitted and what is tested of a log, and what its readers have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gen.runs import Run, read_run

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Case:
    """What is fitted, and what is tested.

    Attributes
    ----------
    machine
        Short name of the log.
    what
        Which of its runs are tested, and what is special.
    parts
        The temperatures that are judged; others are neighbours.
    fit, test
        Runs by name.
    """

    machine: str
    what: str
    parts: tuple[str, ...]
    fit: dict[str, Run]
    test: dict[str, Run]

    def __str__(self) -> str:
        return f"{self.machine}, {self.what}"


def driven_by(run: Run, said: str) -> Run:
    """A run that says what its input is, as `gen import --input COLUMN --full-scale X` writes it."""
    return replace(run, comments={**run.comments, "input": said})


def between(run: Run, first: float, until: float) -> Run:
    """The rows of a run from a time until another, s; time begins anew."""
    rows = (run.time_s >= first) & (run.time_s < until)
    ambient = None if run.ambient is None else run.ambient[rows]
    temps = {name: values[rows] for name, values in run.temps.items()}
    return Run(run.time_s[rows] - run.time_s[rows][0], run.pwm[rows], temps, ambient, comments=run.comments)


def files(paths: list[Path]) -> dict[str, Run]:
    """Run files by their names."""
    return {path.stem: read_run(path) for path in paths}


def each_left_out(
    machine: str, runs: dict[str, Run], parts: tuple[str, ...], short: Callable[[str], str]
) -> Iterator[Case]:
    """Test each run on a model of all others."""
    for left in runs:
        fit = {name: run for name, run in runs.items() if name != left}
        yield Case(machine, short(left), parts, fit, {left: runs[left]})
