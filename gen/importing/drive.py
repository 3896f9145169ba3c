"""The input of every row of a table, in counts."""

from __future__ import annotations

from collections.abc import Mapping as Named

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.errors import InputError
from gen.importing.converted import Converted, count_units_apart
from gen.importing.guessing.evidence import Evidence
from gen.importing.mapping import InputForm, Mapping
from gen.importing.odd_inputs import errors_among, glitches_among
from gen.importing.units import unit_of
from gen.runs.drive import FULL_COUNTS

_HALF_A_COUNT = 0.5
_MOST_UNREAD, _FEW_UNREAD = 0.05, 3
"""Of the rows, and rows, up to which an input may be text, as in a damaged capture: it is held there."""
_AT_REST = 0.02
"""Of the full scale, about a rest that is not 0: a signal of 4 to 20 mA rests at 4.02 mA, or at 3.97 mA."""


def odd_of(evidence: Evidence, mapping: Mapping) -> dict[float, str]:
    """Numbers in the input's column that are none of the input, and what they are.

    Parameters
    ----------
    evidence
        Of the rows that have a time.
    mapping
        What the columns are.
    """
    form = mapping.input
    if form.counts is not None or mapping.overflow == "keep":
        return {}
    facts, unit = evidence.facts[form.column], unit_of(form.unit)
    values = np.concatenate([facts.parsed_in(i, unit).values for i in range(len(evidence.tables))])
    values = values[np.isfinite(values)]
    found = errors_among(values)
    glitches = np.array(glitches_among(values[~np.isin(values, list(found))]))
    return found | dict.fromkeys(
        glitches[_beyond(glitches, form)].tolist(), "far beyond all others, and the full scale"
    )


def drive_of(
    evidence: Evidence, index: int, form: InputForm, time: FloatArray, odd: Named[float, str], made: Converted
) -> FloatArray:
    """The input in counts, not rounded, NaN where it is missing.

    Parameters
    ----------
    evidence, index
        The table among those of its header.
    form
        What the input is.
    time
        Of each row, NaN where it has none.
    odd
        Numbers that are none of the input, from :func:`odd_of`.
    made
        Told what was found.

    Raises
    ------
    InputError
        Without a file name, with the place: the input exceeds its full scale.
    """
    table = made.table
    if form.counts is not None:
        return np.full(table.rows, float(form.counts))
    facts = evidence.facts[form.column]
    parsed = facts.parsed_in(index, unit_of(form.unit))
    count_units_apart(facts, parsed, form.unit, made)
    unread = np.flatnonzero(parsed.text & np.isfinite(time))
    if unread.size > max(_MOST_UNREAD * np.isfinite(time).sum(), _FEW_UNREAD):
        cell = facts.columns[index].cells[int(unread[0])]
        raise InputError(
            f'found "{cell}", and no number in {unread.size} of {time.size} rows; expected numbers, or words as OFF',
            place=table.place(int(unread[0]), form.column),
        )
    made.count("text in a number's field", np.flatnonzero(parsed.text), form.column)
    made.count('word for "no number"', np.flatnonzero(parsed.words), form.column)
    found = parsed.values.copy()
    for value, words in odd.items():
        rows = np.flatnonzero(found == value)
        made.count(f"{value:g} ({words}), no input", rows, form.column)
        found[rows] = np.nan
    values = form.counts_of(found)
    if form.rest:
        resting = np.abs(values) <= _AT_REST * FULL_COUNTS
        made.count(
            f"within {_AT_REST:.0%} of the rest, taken as at rest",
            np.flatnonzero(resting & (values != 0.0)),
            form.column,
        )
        below = values < -_AT_REST * FULL_COUNTS
        if below.any() and not np.any(values > _AT_REST * FULL_COUNTS):
            raise InputError(
                f"never goes beyond the rest of {form.rest:g} {form.unit}, but below it; expected --rest and "
                "--full-scale in its unit",
                place=table.place(int(np.argmax(below)), form.column),
            )
        made.count("below the rest, taken as backwards", np.flatnonzero(below), form.column)
        values[resting] = 0.0
    if form.sign:
        sign = evidence.facts[form.sign].parsed[index].values
        values = values * np.where(sign < 0 if form.backwards is None else sign == form.backwards, -1.0, 1.0)
    in_time = np.where(np.isfinite(time), found, np.nan)
    beyond = np.flatnonzero(_beyond(in_time, form))
    if beyond.size:
        raise InputError(
            f"found {found[beyond[0]]:g}, beyond the full scale of {form.said}; expected "
            f"--full-scale of at least {np.nanmax(np.abs(in_time - form.rest)) + form.rest:g}, or --unit",
            place=table.place(int(beyond[0]), form.column),
        )
    reached = float(np.nanmax(np.abs(in_time - form.rest))) if np.isfinite(in_time).any() else 0.0
    if 0.0 < reached < _HALF_A_COUNT * (form.full_scale - form.rest) / FULL_COUNTS:
        made.warnings.append(
            f"{table.label}: {form.column}: reaches {reached:g} {form.unit}, which is no count of {FULL_COUNTS} at a "
            f"full scale of {form.full_scale:g} {form.unit}: --full-scale, or --unit?"
        )
    return np.asarray(values)


def _beyond(values: FloatArray, form: InputForm) -> BoolArray:
    """Which values exceed the full scale by more than a count's rounding."""
    return np.asarray(np.abs(form.counts_of(values)) > FULL_COUNTS + _HALF_A_COUNT)
