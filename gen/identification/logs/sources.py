"""Runs with where they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from gen.runs import Run, read_run
from gen.side_by_side import side_by_side

MOST_ROWS = 100_000
"""A run of more than twice as many rows is thinned to about as many: blocks are longer than that in the end."""


@dataclass(frozen=True, eq=False)
class Source:
    """One run file."""

    path: str
    run: Run

    @property
    def name(self) -> str:
        """Short name of the run."""
        return Path(self.path).stem


def read_sources(paths: Sequence[Path]) -> list[Source]:
    """Read run files; long ones are thinned.

    Raises
    ------
    InputError
        When one is no run file.
    """
    return side_by_side([partial(_read, path) for path in paths])


def _read(path: Path) -> Source:
    return Source(str(path), read_run(path, most_rows=MOST_ROWS))
