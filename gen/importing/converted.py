"""What one table becomes, and what was found in it on the way."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gen.arrays import IntArray
from gen.importing.behind import alone
from gen.importing.guessing.evidence import Facts
from gen.importing.numbers import Parsed
from gen.importing.table import Counted, Table
from gen.runs import Run


@dataclass
class Converted:
    """The runs of one table.

    Parameters
    ----------
    table
        Of which.
    runs
        With what to put behind the file's name; empty for one run.
    counted
        What was found.
    warnings
        What is suspicious, in a line each.
    """

    table: Table
    runs: list[tuple[str, Run]] = field(default_factory=list)
    counted: list[Counted] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def count(self, what: str, rows: IntArray, column: str = "") -> None:
        """Note rows of the table, if there are any."""
        if rows.size:
            self.counted.append(Counted(what, int(rows.size), self.table.place(int(rows[0]), column)))


def count_units_apart(facts: Facts, parsed: Parsed, unit: str, made: Converted) -> None:
    """Count numbers whose unit is another than their column's, and those without one among others."""
    if parsed.converted is not None:
        made.count(f"number in another unit, made {unit}", np.flatnonzero(parsed.converted), facts.name)
    if facts.named[2] == "values":
        made.count(f"number without a unit, taken for {unit}", alone(parsed), facts.name)
