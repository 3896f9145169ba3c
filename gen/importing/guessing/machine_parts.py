"""Columns of parts that are no motor's (`gearbox`, `esc`; a printer's bed, `B`): temperatures where they move so."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gen.importing.guessing import names
from gen.importing.guessing.alike import follows, moved, unit_alike
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import Choices
from gen.importing.guessing.quantities import KEPT, UNSAID, Sorted, unless_it_counts
from gen.importing.units import TEMPERATURE, Unit

_LIKE_OTHERS = 0.75
"""How sure it is that such a column is a temperature."""
_VOLTS = 8.0
"""By which a battery of 24 V falls until it is empty, at most."""
_TARGET = " target"
"""Behind the name of what a line tells beside what it is wanted to be: `B:58.2 /60.0`."""


def with_machine_parts(found: Sequence[Sorted], evidence: Evidence, choices: Choices) -> list[Sorted]:
    """Take what is named after a part of a machine, or regulated beside a temperature, and moves as they do, for one.

    Parameters
    ----------
    found
        What all columns were taken for.
    evidence
        The columns.
    choices
        What the user says.
    """
    known = [
        (entry.facts, entry.unit)
        for entry in found
        if entry.quantity == TEMPERATURE and entry.unit is not None and entry.confidence > UNSAID
    ]
    made = []
    for entry in found:
        facts = entry.facts
        unit = None
        unsure = entry.why == KEPT or (entry.quantity == TEMPERATURE and entry.confidence == UNSAID)
        part = _of_a_machine(names.apart(facts.named[0]))
        regulated = not part and _is_regulated(facts, known, evidence)
        if unsure and facts.name not in choices.columns and (part or regulated):
            unit = unit_alike(facts, known)
        same = [other for other, its in known if its == unit]
        if unit is not None and follows(facts, same) and not _may_be_volts(facts):
            low, high = facts.span
            said = "regulated as a temperature is" if regulated else "a part by its name"
            said = f"{said}; {low:.4g}..{high:.4g}, and it begins and moves as the others do: {unit.name}"
            entry = unless_it_counts(Sorted(facts, TEMPERATURE, unit, _LIKE_OTHERS, said), evidence)
        made.append(entry)
    return made


def _may_be_volts(facts: Facts) -> bool:
    """Whether it is a battery's, and moves by no more than its volts do until it is empty."""
    return bool(names.CELLS.search(names.apart(facts.named[0]))) and moved(facts) < _VOLTS


def _is_regulated(facts: Facts, known: Sequence[tuple[Facts, Unit]], evidence: Evidence) -> bool:
    """Whether a wanted value stands beside it, as one does beside a temperature: a printer's bed, and its nozzle."""
    wanted = [name.removesuffix(_TARGET) for name in evidence.facts if name.endswith(_TARGET)]
    return facts.name in wanted and any(other.name in wanted for other, _ in known)


def _of_a_machine(base: str) -> bool:
    """Whether a name says nothing but which part of a machine, or where on it: `gearbox`, `battery 2`."""
    rest = names.MACHINE_PARTS.sub(" ", names.MACHINE_PARTS.sub(" ", base))
    words = [word for word in re.split(r"[\W_]+", rest) if word]
    return rest != base and all(names.PARTS.search(word) or names.WHERE.search(word) for word in words)
