"""What was taken as it stands, though something else is as likely."""

from __future__ import annotations

import numpy as np

from gen.importing.guessing.driving import told_beside
from gen.importing.guessing.evidence import Evidence
from gen.importing.guessing.guesses import Choices, quoted
from gen.importing.guessing.input_scale import spanned
from gen.importing.guessing.names import ENABLES
from gen.importing.guessing.no_ambient import without_ambient
from gen.importing.guessing.parted import mixed
from gen.importing.guessing.times.time_unit import short_in_seconds
from gen.importing.guessing.unsaid import unsaid
from gen.importing.listing import listed
from gen.importing.mapping import Mapping

_NEAR_REST = 0.02
"""Of the full scale, within which a motor rests."""
_MOST_BACK, _OFTEN = 0.95, 0.05
"""Of the full scale, and of the rows: an input that stands at its lower end."""
_FEW = 3
"""Rows at each end."""
_LIVE_ZEROS = ((4.0, 20.0), (1.0, 5.0), (1000.0, 2000.0))
"""Rest and end of signals: mA, V, and a servo's pulses in us."""


def suspicious(evidence: Evidence, mapping: Mapping, choices: Choices) -> list[str]:
    """Give what was taken as it stands, though something else is as likely, with the option that would correct it.

    Parameters
    ----------
    evidence
        The columns.
    mapping
        What was decided of them.
    choices
        What the user says.
    """
    label = evidence.tables[0].label
    time = short_in_seconds(evidence, mapping.time, choices)
    drive = _like_a_stick(evidence, mapping)
    drive = drive or _like_a_live_zero(evidence, mapping) or _like_another_rest(evidence, mapping)
    drive = drive or _like_switched(evidence, mapping)
    several = _like_several(evidence, mapping, choices)
    ambient, likely = without_ambient(evidence, mapping)
    other = (unsaid(evidence, mapping, choices), ambient if likely else "")
    return [f"{label}: {said}" for said in (time, drive, several, *other) if said]


def noted(evidence: Evidence, mapping: Mapping) -> list[str]:
    """Give what is worth to know and nothing speaks against.

    Parameters
    ----------
    evidence
        The columns.
    mapping
        What was decided of them.
    """
    ambient, likely = without_ambient(evidence, mapping)
    lines = [_beside_a_current(evidence, mapping), "" if likely else ambient]
    return [f"{evidence.tables[0].label}: {said}" for said in lines if said]


def _beside_a_current(evidence: Evidence, mapping: Mapping) -> str:
    """A current was taken for the input, and beside it stands what the motor may be told."""
    name = mapping.input.column
    others = told_beside(evidence.facts[name], evidence.numbers) if name else []
    if not others:
        return ""
    shown = listed(f"{entry.name} ({spanned(entry)})" for entry in others)
    return f"{name}: a current, which heats; what the motor is told may be {shown}, kept as an extra column"


def _like_a_stick(evidence: Evidence, mapping: Mapping) -> str:
    """An input that stands at its most negative and never near 0: a stick's way, whose rest may be at that end."""
    form = mapping.input
    values = evidence.facts[form.column].values if form.column and not form.sign else np.zeros(0)
    if not values.size or values.min() >= 0.0 or form.rest:
        return ""
    low = float(values.min())
    rests = float((np.abs(values) <= _NEAR_REST * form.full_scale).mean()) == 0.0
    if not rests or float((values == low).mean()) < _OFTEN or abs(low) < _MOST_BACK * form.full_scale:
        return ""
    return (
        f"{form.column}: stands at {low:g} and never near 0, as a stick's way does, whose rest is at that end; if "
        f"so: --rest {low:g} --full-scale {form.full_scale:g}"
    )


def _like_a_live_zero(evidence: Evidence, mapping: Mapping) -> str:
    """An input that reaches from the rest of a usual signal, which is not 0, to no more than its end: 4..20 mA."""
    form = mapping.input
    values = evidence.facts[form.column].values if form.column and not form.sign else np.zeros(0)
    if not values.size or values.min() == values.max() or form.rest:
        return ""
    low, high = float(values.min()), float(values.max())
    for rest, end in _LIVE_ZEROS:
        near = _NEAR_REST * end
        if abs(low - rest) <= near and 0.5 * (rest + end) <= high <= end + near and form.full_scale <= end + near:
            return (
                f"{form.column}: goes from {low:g} to {high:g}, as a signal of {rest:g} to {end:g} does, whose rest is "
                f"at {rest:g}; if so: --rest {rest:g} --full-scale {end:g}"
            )
    return ""


def _like_another_rest(evidence: Evidence, mapping: Mapping) -> str:
    """An input that begins and ends at one value and is never near 0: of a signal that rests there."""
    form = mapping.input
    values = evidence.facts[form.column].values if form.column and not form.sign and not form.rest else np.zeros(0)
    if not values.size or values.min() == values.max():
        return ""
    near = _NEAR_REST * form.full_scale
    first, last = float(np.median(values[:_FEW])), float(np.median(values[-_FEW:]))
    if abs(first - last) > near or values.min() <= near or values.max() > form.full_scale or first >= form.full_scale:
        return ""
    return (
        f"{form.column}: begins and ends at {first:g} and is never near 0, as of a signal that rests there; if so: "
        f"--rest {first:g} --full-scale {form.full_scale:g}"
    )


def _like_switched(evidence: Evidence, mapping: Mapping) -> str:
    """An input that stays while a switch beside it goes off."""
    form = mapping.input
    if not form.column or form.rest:
        return ""
    drive = evidence.facts[form.column]
    for entry in evidence.numbers:
        if not ENABLES.search(entry.name) or set(np.unique(entry.values).tolist()) != {0.0, 1.0}:
            continue
        pairs = zip(entry.parsed, drive.parsed, strict=True)
        off = np.concatenate([driven.values[own.values == 0.0] for own, driven in pairs])
        if off.size and np.all(off[np.isfinite(off)] != 0.0):
            return (
                f"{entry.name}: is 0 in {off.size} rows in which {form.column} is not; if it switches the motor, put "
                f"{form.column} x {entry.name} in place of {form.column} first"
            )
    return ""


def _like_several(evidence: Evidence, mapping: Mapping, choices: Choices) -> str:
    """A column that was said to be none of names, between which a temperature goes to and fro all the same."""
    others = {name for name in evidence.facts if name not in choices.columns} | {mapping.runs, mapping.input.column}
    found = mixed(evidence, mapping.column, others)
    if found is None:
        return ""
    name, column, said = found
    return f"{column}: goes to and fro with {name}, as of several sensors; if so: --series {quoted(said)}"
