"""Rows of one time that hold the largest and the least values of an interval, one after the other, as recorders write.

Of a clock that is too coarse two rows have one time, too. But what a recorder's interval spans holds what the next one
begins with: the second row of a time lies always below (or above) the first, and the next first one above (below) it
again. Samples of a clock that is too coarse go on in one direction where a temperature does, and in any where it rests.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import BoolArray, IntArray
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import Guess
from gen.importing.table import Cells

_MOSTLY = 0.9
_LEAST_PAIRS = 5
_LEAST_SHARE = 0.1
"""Of the pairs, those whose values differ, for a column to say anything."""
_WORDS = {"max": 1, "maximum": 1, "maximal": 1, "min": -1, "minimum": -1, "minimal": -1}


def extremes_by_turns(evidence: Evidence, times: Sequence[str]) -> Guess | None:
    """What is said of a log whose rows come in pairs of one time, the largest and the least; None of any other.

    Parameters
    ----------
    evidence
        The columns.
    times
        Those of the time.
    """
    if not times:
        return None
    firsts = [_pairs([evidence.facts[name].columns[i].cells for name in times]) for i in range(len(evidence.tables))]
    if any(rows is None for rows in firsts):
        return None
    found = [rows for rows in firsts if rows is not None]
    others = [facts for name, facts in evidence.facts.items() if name not in times]
    named = next((facts.name for facts in others if facts.kind == "text" and _says_which(facts, found)), "")
    if not named and not _by_turns([facts for facts in others if facts.kind == "number"], found):
        return None
    by = f"by the column {named}" if named else "the second beyond the next first one throughout"
    said = f"two rows for each time, the largest and the least of its interval: {by}"
    return Guess("rows of one time", "their mean", 0.9, said, "--duplicates first or --duplicates last")


def _pairs(columns: Sequence[Cells]) -> IntArray | None:
    """The first row of each pair of one time; None where rows do not come in pairs."""
    rows = len(columns[0])
    new = np.ones(rows, dtype=bool)
    if rows > 1:
        new[1:] = np.logical_or.reduce([_differs(cells) for cells in columns])
    begins = np.flatnonzero(new)
    lengths = np.diff(np.append(begins, rows))
    firsts = begins[lengths == 2]
    return firsts if firsts.size >= _LEAST_PAIRS and 2 * firsts.size >= _MOSTLY * rows else None


def _differs(cells: Cells) -> BoolArray:
    values = np.array([cell.strip() for cell in cells], dtype=object) if isinstance(cells, list) else cells
    return np.asarray(values[1:] != values[:-1], dtype=bool)


def _says_which(facts: Facts, firsts: Sequence[IntArray]) -> bool:
    """Whether a column of words names the largest and the least by turns."""
    signs = [np.array([_WORDS.get(cell.strip().casefold(), 0) for cell in column.cells]) for column in facts.columns]
    pairs = np.concatenate([sign[rows] * sign[rows + 1] for sign, rows in zip(signs, firsts, strict=True)])
    return bool((pairs == -1).all())


def _by_turns(numbers: Sequence[Facts], firsts: Sequence[IntArray]) -> bool:
    """Whether all columns that say anything go down within the pairs and up between them, or all the other way."""
    senses = [sense for facts in numbers if (sense := _sense(facts, firsts)) is not None]
    return bool(senses) and set(senses) in ({1}, {-1})


def _sense(facts: Facts, firsts: Sequence[IntArray]) -> int | None:
    """1 or -1: up or down within the pairs and back between them; 0: otherwise; None: it says nothing."""
    within = np.concatenate([p.values[r + 1] - p.values[r] for p, r in zip(facts.parsed, firsts, strict=True)])
    between = np.concatenate(
        [p.values[r[1:]] - p.values[r[:-1] + 1] for p, r in zip(facts.parsed, firsts, strict=True)]
    )
    within, between = (steps[np.isfinite(steps) & (steps != 0)] for steps in (within, between))
    if within.size < max(_LEAST_PAIRS, _LEAST_SHARE * sum(map(len, firsts))):
        return None
    sense = 1 if within[0] > 0 else -1
    back = between * sense < 0
    return sense if (within * sense > 0).all() and back.size >= _LEAST_PAIRS and back.mean() >= _MOSTLY else 0
