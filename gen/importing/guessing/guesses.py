"""What was decided of a log, how sure that is, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from gen.runs.drive import Machine

CERTAIN = 1.0
DOUBTFUL = 0.6
"""A guess below this is refused rather than taken."""


@dataclass(frozen=True)
class Guess:
    """One decision.

    Parameters
    ----------
    subject
        Of what: a column of the log, or "decimal mark" and the like.
    taken
        What it is taken for.
    confidence
        0..1; 1 for what was said and not guessed.
    why
        In words.
    settle
        What to add to the command to settle it; for a doubtful guess, never empty.
    """

    subject: str
    taken: str
    confidence: float
    why: str
    settle: str = ""

    @property
    def doubtful(self) -> bool:
        """Whether it may not be taken."""
        return self.confidence < DOUBTFUL


@dataclass(frozen=True)
class Choices:
    """What the user says; empty fields are guessed, or taken from the mapping file.

    Parameters
    ----------
    time
        A column, two of them with a comma between, or the rows' interval in s.
    drive
        The input: a column, or the same counts for all rows.
    full_scale
        The input's value that is 255 counts, in its unit.
    rest
        The input's value that is 0 counts, in its unit.
    machine
        What the input drives: ``motor`` or ``heater``.
    columns
        Name in the log -> name in the run file; empty to leave it out.
    units
        Name in the log or in the run file -> unit.
    decimal
        The decimal mark.
    runs
        The column that says which run a row belongs to.
    duplicates
        Which of the rows of one time to take: "first", "last", the "mean" of them, or "spread" over the time until the
        next.
    sort
        Whether rows are put in the order of their times.
    series
        The column whose names each become a column; behind a comma, that of the values.
    zone
        Of which time zone local times are.
    sheet
        Of a workbook, the only sheet to read.
    """

    time: str = ""
    drive: str = ""
    full_scale: float | None = None
    rest: float | None = None
    machine: Machine | Literal[""] = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    decimal: str = ""
    runs: str = ""
    duplicates: str = ""
    sort: bool = False
    series: str = ""
    zone: str = ""
    sheet: str = ""


def quoted(text: str) -> str:
    """A name as a shell takes it."""
    return (
        text if text and all(c.isalnum() or c in "_.-%/=:," for c in text) else "'" + text.replace("'", "'\\''") + "'"
    )
