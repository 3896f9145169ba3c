"""What is told of a log whose ambient nobody named, and which of its temperatures moves as a room's."""

from __future__ import annotations

import numpy as np

from gen.importing.guessing import names
from gen.importing.guessing.alike import correlation_of_changes, moved, temperatures
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import quoted
from gen.importing.mapping import Mapping

_AMBIENT = "ambient_degC"
_MUCH_LESS = 0.5
"""Of what the others move by (their median), at most."""
_LEAST_MOVED_K = 3.0
"""By the others, for a log that shows what follows the motor."""
_FOLLOWS = 0.4
"""Correlation of the changes with those of any other."""
_ROOMS_degC = (-50.0, 60.0)
"""Where rooms are, the open air among them; a sensor that is not connected stands at -127 degC."""


def without_ambient(evidence: Evidence, mapping: Mapping) -> tuple[str, bool]:
    """What is said where no column is the ambient's, and whether a column is likely to be; empty where there is one.

    Parameters
    ----------
    evidence
        The columns.
    mapping
        What was decided of them.
    """
    if any(entry.to == _AMBIENT for entry in mapping.column) or any(
        _AMBIENT in table.comments for table in evidence.tables
    ):
        return "", False
    said = "no ambient temperature: gen identify takes it from where the runs begin"
    found = _like_a_room(evidence, mapping)
    if found is None:
        return f"{said}; if a column is the room's: --column OLD={_AMBIENT}", False
    facts, own, others = found
    return (
        f"{said}; {facts.name} moves by {own:.2g} K, where the others move by {others:.2g} K, and not with them; if it "
        f"is the room's: --column {quoted(f'{facts.name}={_AMBIENT}')}"
    ), True


def _like_a_room(evidence: Evidence, mapping: Mapping) -> tuple[Facts, float, float] | None:
    """The temperature that moves least, by much less than the others, and not with them; with what they move by, K."""
    measured = [(facts, unit) for facts, unit in temperatures(evidence, mapping) if facts.values.size]
    moves = {facts.name: moved(facts) * unit.scale for facts, unit in measured}
    if len(moves) < 2:
        return None
    facts, unit = min(measured, key=lambda column: moves[column[0].name])
    least, usual = facts.name, float(np.median(facts.values)) * unit.scale + unit.offset
    if not _ROOMS_degC[0] <= usual <= _ROOMS_degC[1]:
        return None
    others = float(np.median([value for name, value in moves.items() if name != least]))
    base = names.apart(facts.named[0])
    if names.PARTS.search(base) or names.MACHINE_PARTS.search(base):  # what is heavy, or far from the heat
        return None
    if others < _LEAST_MOVED_K or moves[least] > _MUCH_LESS * others:
        return None
    if any(correlation_of_changes(facts, evidence.facts[name]) >= _FOLLOWS for name in moves if name != least):
        return None
    return facts, moves[least], others
