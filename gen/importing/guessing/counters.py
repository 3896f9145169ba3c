"""Columns that rise and never fall: counters, odometers, energies, whose names may look like those of sensors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.importing.guessing.evidence import Facts

_LEAST_ROWS = 10
_FALLS = 0.25
"""Of what a temperature moved by, for a log in which motors cool."""
_MOVES_K = 2.0


def counts_rows(facts: Facts) -> str:
    """What is said of a column that rises by the same step in every row, from 0 or by whole numbers; else empty.

    Parameters
    ----------
    facts
        Of numbers.
    """
    steps = facts.steps
    if steps.size < _LEAST_ROWS or steps.min() <= 0 or np.ptp(steps) > 1e-6 * steps.max():
        return ""
    step = float(np.median(steps))
    if not facts.whole and facts.span[0] > step * (1 + 1e-6):
        return ""
    return f"rises by {step:.4g} in every row: a counter"


def never_falls(facts: Facts) -> bool:
    """Whether it rises, and falls in no row.

    Parameters
    ----------
    facts
        Of numbers.
    """
    steps = facts.steps
    return bool(steps.size >= _LEAST_ROWS and steps.min() >= 0 and steps.max() > 0)


def that_falls(temperatures: Sequence[Facts]) -> str:
    """The first temperature that falls back by a good part of what it moved by; empty where none does.

    Parameters
    ----------
    temperatures
        Columns that are temperatures by their unit or their name.
    """
    return next((facts.name for facts in temperatures if any(_fell(entry.values) for entry in facts.parsed)), "")


def _fell(values: FloatArray) -> bool:
    found = values[np.isfinite(values)]
    moved = float(np.ptp(found)) if found.size else 0.0
    return bool(moved > _MOVES_K and found.max() - found[-1] > _FALLS * moved)
