"""What each of the other columns is: a part's temperature, the ambient, current, voltage, speed, or something else."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from gen.errors import InputError
from gen.importing.guessing import names
from gen.importing.guessing.alike import follows, moved, unit_alike
from gen.importing.guessing.ambient import ambient_of
from gen.importing.guessing.counters import counts_rows, never_falls, that_falls
from gen.importing.guessing.doubles import told_twice
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.extremes import least_of_pairs
from gen.importing.guessing.guesses import CERTAIN, Choices, Guess, quoted
from gen.importing.guessing.odd_units import odd_in
from gen.importing.mapping import Entry
from gen.importing.units import (
    CURRENT,
    DEGC,
    DEGF,
    SPEED,
    TEMPERATURE,
    VOLTAGE,
    Unit,
    is_any_degree,
    is_foreign,
    split_name,
    unit_of,
)

AMBIENT = "ambient_degC"
_CANONICAL = {
    CURRENT: ("current_A", names.CURRENT),
    VOLTAGE: ("voltage_V", names.VOLTAGE),
    SPEED: ("speed_rpm", names.SPEED),
}
_COLD_C = (-40.0, 45.0)
"""degC at which a log may begin."""
_WARM_C, _FAR_C = 100.0, 150.0
_FEW_VALUES = 3
_STATES = 5.0
"""Up to which whole numbers are rather what something does than degrees."""
_LEAST_BOUND = 5
"""Rows, for a number that is the same in all of them to be a limit."""
_UNSAID = 0.5
"""How sure it is that a column named after a part is its temperature."""
_SLOW = 0.7
_LIKE_OTHERS = 0.75
"""How sure it is that a column is a temperature that is named after a part of a machine, and moves as the others."""
_VOLTS = 8.0
"""By which a battery of 24 V falls until it is empty, at most."""
_KEPT = "kept as it is"
_ALIKE_K = 8.0
"""How far apart sensors of one motor begin at most."""
_SAYS_SO = re.compile(r"(?i)temp|th?ermo|°")
_PARTS, _LEAST_PARTS_C = (0.1, 0.01, 0.001), 10.0
_KELVIN = (260.0, 373.0)
"""Of a motor, cold or warm; batteries tell tenths of them."""
_LEAST_REACHED, _FALLEN, _LEAST_BEGUN_C = 5.0, 3.0, 8.0
_LETTER = re.compile(r".*[_ ][A-Za-z]")


@dataclass(frozen=True)
class _Sorted:
    facts: Facts
    quantity: str
    unit: Unit | None
    confidence: float
    why: str


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
    left = [_sorted(facts, evidence, choices) for name, facts in evidence.facts.items() if name not in used]
    left = _with_alike(left, evidence, choices)
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


def _with_alike(found: list[_Sorted], evidence: Evidence, choices: Choices) -> list[_Sorted]:
    """What is named after a part of a machine without a unit, and begins and moves as the temperatures do, is one."""
    known = [
        (entry.facts, entry.unit)
        for entry in found
        if entry.quantity == TEMPERATURE and entry.unit is not None and entry.confidence > _UNSAID
    ]
    made = []
    for entry in found:
        facts = entry.facts
        unit = None
        unsure = entry.why == _KEPT or (entry.quantity == TEMPERATURE and entry.confidence == _UNSAID)
        if unsure and facts.name not in choices.columns and _of_a_machine(names.apart(facts.named[0])):
            unit = unit_alike(facts, known)
        same = [other for other, its in known if its == unit]
        if unit is not None and follows(facts, same) and not _may_be_volts(facts):
            low, high = facts.span
            said = f"a part by its name; {low:.4g}..{high:.4g}, and it begins and moves as the others do: {unit.name}"
            entry = _unless_it_counts(_Sorted(facts, TEMPERATURE, unit, _LIKE_OTHERS, said), evidence)
        made.append(entry)
    return made


def _may_be_volts(facts: Facts) -> bool:
    """Whether it is a battery's that moves by no more than the volts of one at the room's number of them."""
    return bool(names.CELLS.search(names.apart(facts.named[0]))) and moved(facts) < _VOLTS


def _of_a_machine(base: str) -> bool:
    """Whether a name says nothing but which part of a machine, or where on it: `gearbox`, `battery 2`."""
    rest = names.MACHINE_PARTS.sub(" ", names.MACHINE_PARTS.sub(" ", base))
    words = [word for word in re.split(r"[\W_]+", rest) if word]
    return rest != base and all(names.PARTS.search(word) or names.WHERE.search(word) for word in words)


def _left_out(name: str, pairs: Mapping[str, str], doubles: Mapping[str, str]) -> Guess:
    if name in doubles:
        return Guess(name, "left out", 0.9, f"the same as {quoted(doubles[name])}, in another unit")
    return Guess(name, "left out", 0.9, f"the least of each interval, beside {quoted(pairs[name])}, which is taken")


def _sorted(facts: Facts, evidence: Evidence, choices: Choices) -> _Sorted:
    """The quantity and the unit of a column."""
    base, unit, where = facts.named
    base = names.apart(base)
    told = choices.units.get(facts.name) or choices.units.get(choices.columns.get(facts.name) or facts.name)
    if told:
        unit = unit_of(told)
        if unit is None:
            raise InputError(f'found the unit "{told}", expected degC, degF, K, A, mA, V, rpm ..', place="--unit")
        return _Sorted(facts, unit.quantity, unit, CERTAIN, f"{unit.name} by --unit")
    if facts.kind != "number":
        return _Sorted(facts, "", None, 0.9, f"holds {facts.kind}")
    if unit is not None and where == "name" and _one_of_letters(facts.name, evidence):
        unit = None
    if unit in (DEGC, DEGF) and names.CHARGE.fullmatch(base) and facts.name not in choices.columns:
        return _Sorted(facts, "", None, 0.8, "a charge or a capacity by its name, in coulomb or farad; kept as it is")
    target = choices.columns.get(facts.name, "")
    if names.WANTED.search(base) and not target:
        return _Sorted(facts, "", unit, 0.8, "a wanted or modelled value by its name")
    if unit is not None and unit.quantity == TEMPERATURE:
        said = "" if target else _no_temperature(base) or _bound(facts, base, evidence)
        if said:
            return _Sorted(facts, "", unit, 0.8, said)
        return _by_unit(facts, unit, where, _thermal(facts, base))
    written = "" if unit is not None or target or not _thermal(facts, base) else facts.written_unit
    if is_foreign(written):
        return _Sorted(facts, "", None, 0.8, f"in {written}, which is no unit of a temperature; kept as it is")
    if is_any_degree(written):
        return replace(_by_range(facts, False), confidence=0.5, why=f"in {written}, of an angle or of a temperature")
    if unit is None and not target and _thermal(facts, base) and (bound := _bound(facts, base, evidence)):
        return _Sorted(facts, "", None, 0.8, bound)
    if unit is None and (told_unit := _told_for_all(evidence)) and _thermal(facts, base):
        return _by_unit(facts, told_unit[1], f"column {told_unit[0]}", True)
    if unit is None and target:
        return _by_range(facts, True) if target.endswith("_degC") or _thermal(facts, base) else _by_name(facts, base)
    if unit is None and _thermal(facts, base):
        if _SAYS_SO.search(base):
            return _by_range(facts, False)
        plain = _said(base) or _beside_such(facts, evidence)
        if base == "T" and _start_degC(facts) < _LEAST_BEGUN_C:  # a torque is called so, too, and begins at 0
            plain = False
        return _unless_it_counts(_by_range(facts, False) if plain else _of_a_part(facts), evidence)
    if unit is not None:
        return _Sorted(facts, unit.quantity, unit, 0.9, f"in {unit.name} by its {where}")
    return _by_name(facts, base)


def _told_for_all(evidence: Evidence) -> tuple[str, Unit] | None:
    """The column that says one unit of temperature in all rows, for all that has none, and the unit: `temp_unit`."""
    for facts in evidence.facts.values():
        if not names.TELLS_UNIT.fullmatch(names.carried(facts.name)):
            continue
        said = {text.strip() for text in facts.texts} - {""}
        unit = unit_of(next(iter(said))) if len(said) == 1 else None
        if unit is not None and unit.quantity == TEMPERATURE:
            return facts.name, unit
    return None


def _no_temperature(base: str) -> str:
    """What a name says that is told in degrees and is no temperature of anything; empty where it says no such thing."""
    if names.NO_TEMPERATURE.fullmatch(base):
        return "a time by its name"
    if names.RISE.search(base):
        return "a rise over the ambient by its name, and no temperature"
    if names.DIFFERENCE.search(base):
        return "a difference of temperatures by its name"
    return "of moist air by its name, and the temperature of nothing" if names.MOIST.search(base) else ""


def _bound(facts: Facts, base: str, evidence: Evidence) -> str:
    """What is said of a limit: the same in all rows, and called so; empty where it is none.

    The largest of several readings is called so, too: a limit lies beyond them.
    """
    low, high = facts.span
    if low != high or facts.values.size < _LEAST_BOUND or not names.BOUND.search(base):
        return ""
    if names.EXTREME.search(base) and any(
        other.span[0] < low < other.span[1]
        for other in evidence.numbers
        if other.in_degrees or names.is_thermal(other.name)
    ):
        return ""
    if names.AMBIENT.search(base) and low < _COLD_C[1]:  # of a recorder, that of each interval
        return ""
    return f"{low:g} in all rows, and a limit by its name: no temperature of a part"


def _one_of_letters(name: str, evidence: Evidence) -> bool:
    """Whether the last letter counts (`phase_A`, `phase_B`) and is no unit."""
    if not _LETTER.fullmatch(name):
        return False
    others = {other[-1] for other in evidence.facts if other[:-1] == name[:-1]}
    return len(others) > 1 and (others - set("CFKAVWs")) != set() and not others <= set("cfkCFK")


def _thermal(facts: Facts, base: str) -> bool:
    """Whether a name may be that of a temperature."""
    if names.SYMBOL.fullmatch(facts.named[0]) or base == "T":
        return True
    if not (names.THERMAL.fullmatch(base) or names.PARTS.search(base) or names.AMBIENT.search(base)):
        return False
    last = re.split(r"[/.]", base)[-1] or base  # `/motor/state/temperature` is no state
    if _electrical(base) or names.FLAG.search(last) or _no_temperature(base):
        return False
    if _SAYS_SO.search(base):
        return True
    return not names.OTHER.search(base) and not names.OTHER_UNIT.fullmatch(split_name(facts.name)[2])


def _said(base: str) -> bool:
    """Whether a name says that it is a temperature, or nothing but which part, or where: `stator end 2`."""
    if names.THERMAL.fullmatch(base) or base == "T":
        return True
    words = [word for word in re.split(r"[\W_]+", base) if word]
    if len(words) > 1 and len(words[0]) == 1 and words[0] not in "tT":
        return False  # `R_winding`: a phase, or a resistance
    return all(names.PARTS.search(word) or names.AMBIENT.search(word) or names.WHERE.search(word) for word in words)


def _beside_such(facts: Facts, evidence: Evidence) -> bool:
    """Whether a symbol stands beside another one that begins where it does: `Tw` beside `Tg`."""
    if not names.SYMBOL.fullmatch(facts.named[0]):
        return False
    others = [e for e in evidence.numbers if e is not facts and e.own is None and names.SYMBOL.fullmatch(e.named[0])]
    return any(abs(_start_degC(other) - _start_degC(facts)) <= _ALIKE_K for other in others)


def _of_a_part(facts: Facts) -> _Sorted:
    """A part's name with a word that nobody knows: `motor_dither`; or a symbol alone: `Tw`."""
    low, high = facts.span
    begin = float(np.median(facts.starts)) if facts.starts.size else low
    if low < _COLD_C[0] or not _COLD_C[0] <= begin <= _WARM_C or len(np.unique(facts.values)) <= _FEW_VALUES:
        return _Sorted(facts, "", None, 0.8, _KEPT)
    named = "called as one" if names.SYMBOL.fullmatch(facts.named[0]) or facts.named[0] == "T" else "named after a part"
    said = f"{named}, {low:.4g}..{high:.4g}, and nothing says that it is a temperature"
    return _Sorted(facts, TEMPERATURE, unit_of("degC"), _UNSAID, said)


def _unless_it_counts(found: _Sorted, evidence: Evidence) -> _Sorted:
    """A temperature by little of its name, unless it rises as none does."""
    facts = found.facts
    if found.quantity != TEMPERATURE:
        return found
    counter = counts_rows(facts)
    if counter:
        return _Sorted(facts, "", None, 0.8, f"{counter}; kept as it is")
    if not never_falls(facts):
        return found
    others = [entry for entry in evidence.numbers if entry is not facts and _is_temperature(entry)]
    others = [entry for entry in others if not _bound(entry, names.apart(entry.named[0]), evidence)]
    falling = that_falls(others)
    if not falling:
        return found if found.confidence <= _UNSAID else replace(found, why=f"{found.why}; it never falls")
    said = f"{found.why}; it never falls, though {falling} does"
    apart = abs(_start_degC(facts, found.unit) - float(np.median([_start_degC(entry) for entry in others])))
    if apart <= _ALIKE_K:  # what is heavy, or far from the heat, still warms while the others cool
        return replace(found, confidence=min(found.confidence, _SLOW), why=said)
    said += f", and begins {apart:.4g} K from the others: an energy or an odometer?"
    return replace(found, confidence=min(found.confidence, _UNSAID), why=said)


def _start_degC(facts: Facts, unit: Unit | None = None) -> float:
    unit = unit or facts.named[1]
    begin = float(np.median(facts.starts)) if facts.starts.size else 0.0
    return begin * unit.scale + unit.offset if unit is not None else begin


def _is_temperature(facts: Facts) -> bool:
    base, unit, _ = facts.named
    if unit is not None:
        return facts.in_degrees
    return _thermal(facts, names.apart(base)) and _said(names.apart(base))


def _electrical(base: str) -> bool:
    return any(pattern.fullmatch(base) for _, pattern in _CANONICAL.values()) and not re.search(
        r"(?i)temp|thermo", base
    )


def _by_unit(facts: Facts, unit: Unit, where: str, thermal: bool) -> _Sorted:
    begin = float(np.median(facts.starts)) if facts.starts.size else facts.span[0]
    odd = odd_in(unit, facts, begin)
    if odd:
        return _Sorted(facts, TEMPERATURE, unit, 0.4, odd)
    said = f"{unit.name} by its {where}" if where == "name" else f"{unit.name} by the {where}"
    return _Sorted(facts, TEMPERATURE, unit, 0.95 if thermal else 0.85, said)


def _by_range(facts: Facts, told: bool) -> _Sorted:
    """A temperature whose unit nothing says: by where the log begins."""
    low, high = facts.span
    starts = facts.starts
    begin = float(np.median(starts)) if starts.size else low
    if facts.values.size and low == high == 0.0 and not told:
        return _Sorted(facts, "", None, 0.8, "0 in all rows: no sensor is there; kept as it is")
    if facts.whole and 0.0 <= low < high <= _STATES and not told and not _SAYS_SO.search(names.apart(facts.named[0])):
        return _Sorted(facts, "", None, 0.8, f"whole numbers {low:g}..{high:g}: states; kept as it is")
    said = f"begins at {begin:.4g}, {low:.4g}..{high:.4g}"
    if max(abs(low), abs(high)) < _LEAST_REACHED and low != high:
        return _Sorted(facts, TEMPERATURE, unit_of("degC"), 0.4, f"{said}: no motor in degC; volts of a sensor?")
    if (
        not told
        and names.RESISTOR.search(facts.named[0])
        and begin - low > _FALLEN
        and high - begin < 0.2 * (begin - low)
    ):
        return _Sorted(facts, TEMPERATURE, unit_of("degC"), 0.4, f"{said}, and falls from there: a resistance?")
    if starts.size and starts.min() <= _COLD_C[1] and starts.max() > _FAR_C:
        said = f"begins at {starts.min():.4g} in one file and at {starts.max():.4g} in another: of one unit?"
        return _Sorted(facts, TEMPERATURE, unit_of("degC"), 0.4, said)
    celsius, kelvin = unit_of("degC"), unit_of("K")
    if facts.values.size and 260 <= begin <= 330 and low > 230 and not facts.whole:
        return _Sorted(facts, TEMPERATURE, kelvin, 0.8, f"{said}: K")
    if begin > 100 or (low < -60 and high > 500):
        return _Sorted(facts, TEMPERATURE, celsius, 0.3, f"{said}: no cold motor in degC, and nothing says the unit")
    if not _COLD_C[0] <= begin <= _COLD_C[1]:
        return _Sorted(facts, TEMPERATURE, celsius, 0.45, f"{said}: degC after it ran, or degF of a cold one")
    return _Sorted(facts, TEMPERATURE, celsius, 0.85 if told else 0.8, f"{said}: degC")


def _by_name(facts: Facts, base: str) -> _Sorted:
    alone = unit_of(base) if len(base) > 1 else None
    if alone is not None and alone.quantity in _CANONICAL:
        return _Sorted(facts, alone.quantity, alone, 0.9, f"in {alone.name} by its name")
    for quantity, unit in ((CURRENT, "A"), (VOLTAGE, "V")):
        reached = max(map(abs, facts.span))
        if _CANONICAL[quantity][1].fullmatch(base) and reached <= 100:
            return _Sorted(facts, quantity, unit_of(unit), 0.7, f"by its name; up to {reached:.4g}: {unit}")
    return _Sorted(facts, "", None, 0.8, _KEPT)


def _ambient(found: list[_Sorted], choices: Choices) -> tuple[str, bool]:
    """The column of the ambient's temperature, empty where there is none; and whether that is doubtful."""
    told = [name for name, new in choices.columns.items() if new in (AMBIENT, AMBIENT.removesuffix("_degC"))]
    if told:
        return told[0], False
    return ambient_of([e.facts for e in found if e.quantity == TEMPERATURE and e.facts.name not in choices.columns])


def _entry(found: _Sorted, choices: Choices, taken: set[str], ambient: bool, doubtful: bool) -> tuple[Entry, Guess]:
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
            confidence, why = _UNSAID, f"{why}; the ambient, or of a part"
            settle = f"--column {quoted(f'{facts.name}={AMBIENT}')} or {quoted(f'{facts.name}=NAME_degC')}"
        elif confidence <= _UNSAID:
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
    if not facts.whole or begin <= _WARM_C:
        return []
    found = [f"{part:g}degC" for part in _PARTS if _LEAST_PARTS_C <= begin * part <= _WARM_C]
    return [*found, *(["0.1K"] if _KELVIN[0] <= begin / 10.0 <= _KELVIN[1] else [])]


def _channel(found: _Sorted, base: str, taken: set[str]) -> tuple[str, str, float]:
    """Name and unit of what is no temperature; only what has a fixed name is converted."""
    unit = found.unit
    if unit is not None and unit.quantity in _CANONICAL:
        to, pattern = _CANONICAL[unit.quantity]
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
