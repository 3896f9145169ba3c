"""Columns of names between which readings go to and fro: sensors that share a column, of which nobody was told."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.series_columns import come_by_turns, moving, numbers_by_turns, series_of
from gen.importing.mapping import Entry

_APART = 3.0
"""How far readings go from row to row, of how far those of each name do: noise about a limit by which rows were named
makes less than 2."""
_LEAST = 3
"""Readings of a name."""


def mixed(evidence: Evidence, entries: Sequence[Entry], told: Collection[str]) -> tuple[str, str, str] | None:
    """A column of names by turns, a temperature that holds readings of several of them, and what `--series` is told.

    Parameters
    ----------
    evidence
        The columns.
    entries
        What they become.
    told
        Columns that are none of names.
    """
    taken = {entry.source for entry in entries if entry.to.endswith("_degC")}
    temperatures = [evidence.facts[entry.source] for entry in entries if entry.to.endswith("_degC")]
    for name, facts in evidence.facts.items():
        if name in told or name in taken or not (come_by_turns(facts) or numbers_by_turns(facts)):
            continue
        found = next((entry.name for entry in temperatures if _goes_to_and_fro(entry, facts.texts)), "")
        if found:
            return name, found, series_of(name, [found, *(f.name for f in moving(evidence, {name}) if f.name != found)])
    return None


def _goes_to_and_fro(entry: Facts, names: Sequence[str]) -> bool:
    """Whether readings lie elsewhere for each name, as the temperatures of no one thing do."""
    values = np.concatenate([parsed.values for parsed in entry.parsed])
    known = np.isfinite(values)
    of, values = np.array(names)[known], values[known]
    each = [values[of == name] for name in dict.fromkeys(of.tolist())]
    each = [own for own in each if own.size >= _LEAST]
    return len(each) > 1 and _way(values) > _APART * sum(map(_way, each))


def _way(values: FloatArray) -> float:
    return float(np.abs(np.diff(values)).sum())
