"""What each of the other columns becomes: a part's temperature, the ambient, current, voltage, speed, or else."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gen.importing.guessing import names
from gen.importing.guessing.ambient import ambient_of
from gen.importing.guessing.doubles import told_twice
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.extremes import least_of_pairs
from gen.importing.guessing.guesses import Choices, Guess, quoted
from gen.importing.guessing.machine_parts import with_machine_parts
from gen.importing.guessing.quantities import CANONICAL, UNSAID, WARM_C, Sorted, sorted_out
from gen.importing.mapping import Entry
from gen.importing.units import TEMPERATURE, VOLTAGE, unit_of

AMBIENT = "ambient_degC"
_PARTS, _LEAST_PARTS_C = (0.1, 0.01, 0.001), 10.0
_KELVIN = (260.0, 373.0)
"""Of a motor, cold or warm; batteries tell tenths of them."""


def decide_columns(evidence: Evidence, choices: Choices, used: set[str]) -> tuple[list[Entry], list[Guess]]:
    """Say of every column that is not time or input what it becomes.

    Parameters
    ----------
    evidence
        The columns.
    choices
        What the user says.
    used
        Columns that have a place already.

    Raises
    ------
    InputError
        Without a file name: what was said names no column, or a unit that is none.
    """
    taken = {"time_s", "pwm"} | {name for name in choices.columns.values() if name}
    entries: list[Entry] = []
    guesses: list[Guess] = []
    left = [sorted_out(facts, evidence, choices) for name, facts in evidence.facts.items() if name not in used]
    left = with_machine_parts(left, evidence, choices)
    doubles = told_twice([e.facts for e in left if e.quantity == TEMPERATURE], {*choices.columns, *choices.units})
    pairs = least_of_pairs([e.facts for e in left if e.quantity == TEMPERATURE], {*choices.columns, *choices.units})
    room, doubtful = _ambient([entry for entry in left if entry.facts.name not in {*pairs, *doubles}], choices)
    for found in left:
        if found.facts.name in pairs or found.facts.name in doubles:
            entries.append(Entry.model_validate({"from": found.facts.name, "to": ""}))
            guesses.append(_left_out(found.facts.name, pairs, doubles))
            continue
        entry, guess = _entry(found, choices, taken, found.facts.name == room, doubtful)
        if entry.to:
            taken.add(entry.to)
            taken.add(entry.to.removesuffix("_degC"))
        entries.append(entry)
        guesses.append(guess)
    return entries, guesses


def _left_out(name: str, pairs: Mapping[str, str], doubles: Mapping[str, str]) -> Guess:
    if name in doubles:
        return Guess(name, "left out", 0.9, f"the same as {quoted(doubles[name])}, in another unit")
    return Guess(name, "left out", 0.9, f"the least of each interval, beside {quoted(pairs[name])}, which is taken")


def _ambient(found: list[Sorted], choices: Choices) -> tuple[str, bool]:
    """The column of the ambient's temperature, empty where there is none; and whether that is doubtful."""
    told = [name for name, new in choices.columns.items() if new in (AMBIENT, AMBIENT.removesuffix("_degC"))]
    if told:
        return told[0], False
    return ambient_of([e.facts for e in found if e.quantity == TEMPERATURE and e.facts.name not in choices.columns])


def _entry(found: Sorted, choices: Choices, taken: set[str], ambient: bool, doubtful: bool) -> tuple[Entry, Guess]:
    facts = found.facts
    base, in_name, _ = facts.named
    if in_name is not None and found.unit is None:  # the letters are none
        base = facts.name
    unit = found.unit
    name = "" if unit is None else unit.name
    new = choices.columns.get(facts.name)
    if new == "" or (new is None and facts.kind != "number"):
        why = "--column" if new == "" else found.why
        return Entry.model_validate({"from": facts.name, "to": ""}), Guess(facts.name, "left out", 0.9, why)
    why = found.why if new is None else f"{found.why}; name by --column"
    confidence, settle = found.confidence, ""
    if found.quantity == TEMPERATURE:
        to = AMBIENT if ambient else f"{names.component_name(base, taken)}_degC"
        if new:
            to = new if new.endswith("_degC") else f"{new}_degC"
        shown = quoted(f"{facts.name}=degC")
        settle = f"--unit {shown} or =degF or =K{''.join(f' or ={unit}' for unit in _in_parts(facts))}"
        if ambient and doubtful:
            confidence, why = UNSAID, f"{why}; the ambient, or of a part"
            settle = f"--column {quoted(f'{facts.name}={AMBIENT}')} or {quoted(f'{facts.name}=NAME_degC')}"
        elif confidence <= UNSAID:
            settle += f", or --column {quoted(f'{facts.name}=')} to leave it out"
    elif new:
        to = new
    else:
        to, name, confidence = _channel(found, base, taken)
    taken_for = to if not name or to.endswith(f"_{name}") else f"{to}, from {name}"
    entry = Entry.model_validate({"from": facts.name, "to": to, "unit": name})
    return entry, Guess(facts.name, taken_for, confidence, why, settle)


def _in_parts(facts: Facts) -> list[str]:
    """Of which parts of a degree whole numbers may be: a converter's, a PLC's, a kernel's (`45312`)."""
    begin = float(np.median(facts.starts)) if facts.starts.size else 0.0
    if not facts.whole or begin <= WARM_C:
        return []
    found = [f"{part:g}degC" for part in _PARTS if _LEAST_PARTS_C <= begin * part <= WARM_C]
    return [*found, *(["0.1K"] if _KELVIN[0] <= begin / 10.0 <= _KELVIN[1] else [])]


def _channel(found: Sorted, base: str, taken: set[str]) -> tuple[str, str, float]:
    """Name and unit of what is no temperature; only what has a fixed name is converted."""
    unit = found.unit
    if unit is not None and unit.quantity in CANONICAL:
        to, pattern = CANONICAL[unit.quantity]
        named = pattern.fullmatch(base) or unit_of(base)
        if unit.quantity == VOLTAGE:
            named = named or names.VOLTAGE_IN_VOLTS.fullmatch(base)
        if to not in taken and named:
            return to, unit.name, found.confidence
    written = found.unit.name if found.unit is not None else found.facts.columns[0].unit
    kept = names.channel_name(base, written, taken)
    if kept.endswith("_degC"):
        kept = f"{kept}_value"
    return kept, "", found.confidence
