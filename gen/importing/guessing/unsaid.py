"""What is kept as it is, though it may be a temperature that nothing says."""

from __future__ import annotations

from gen.importing.guessing import names
from gen.importing.guessing.alike import temperatures, unit_alike
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import Choices, quoted
from gen.importing.guessing.input_scale import spanned
from gen.importing.mapping import Mapping
from gen.importing.units import DEGC, Unit, is_foreign

_OTHERS = (
    names.OTHER,
    names.FLAG,
    names.WANTED,
    names.ASKED,
    names.MOIST,
    names.RISE,
    names.DIFFERENCE,
    names.NO_DRIVE,
    names.CHARGED,
    names.PLACE,
)
_MOST_SHOWN = 8


def unsaid(evidence: Evidence, mapping: Mapping, choices: Choices) -> str:
    """Columns that are kept as they are, and begin and move as the temperatures do; empty where none does.

    Parameters
    ----------
    evidence
        The columns.
    mapping
        What was decided of them.
    choices
        What the user says.
    """
    kept = [entry.source for entry in mapping.column if entry.to and not entry.unit]
    told = {*choices.columns, *choices.units}
    known = temperatures(evidence, mapping)
    left = [facts for name in kept if name not in told and not _says_other(facts := evidence.facts[name])]
    found = [(facts, unit) for facts in left if (unit := unit_alike(facts, known)) is not None]
    if not found:
        return ""
    shown = ", ".join(f"{facts.name} ({spanned(facts)})" for facts, _ in found[:_MOST_SHOWN])
    taken = {entry.to.removesuffix("_degC") for entry in mapping.column if entry.to.endswith("_degC")}
    options = " ".join(_option(facts, unit, taken) for facts, unit in found[:_MOST_SHOWN])
    more = f" and {len(found) - _MOST_SHOWN} more" if len(found) > _MOST_SHOWN else ""
    if len(found) == 1:
        return (
            f"{shown}: begins where the temperatures do and moves as slowly, and nothing says what it is: kept as it "
            f"is, no part of the model; if it is a temperature: {options}"
        )
    return (
        f"{shown}{more}: begin where the temperatures do and move as slowly, and nothing says what they are: kept as "
        f"they are, no part of the model; if these are temperatures: {options}"
    )


def _says_other(facts: Facts) -> bool:
    """Whether its name or what stands behind it says another quantity."""
    base = names.apart(facts.named[0])
    if facts.kind != "number" or facts.named[1] is not None or is_foreign(facts.written_unit):
        return True
    if names.NUMBERED.fullmatch(base):
        return False
    electrical = names.CURRENT.fullmatch(base) or names.VOLTAGE.fullmatch(base)
    return (
        bool(electrical)
        or any(pattern.search(base) for pattern in _OTHERS)
        or bool(names.OTHER_UNIT.fullmatch(facts.written_unit))
    )


def _option(facts: Facts, unit: Unit, taken: set[str]) -> str:
    part = names.component_name(names.apart(facts.named[0]), taken)
    taken.add(part)
    named = f"--column {quoted(f'{facts.name}={part}_degC')}"
    return named if unit == DEGC else f"{named} --unit {quoted(f'{facts.name}={unit.name}')}"
