"""The quantity and the unit of a column: by what its name, its unit, where it begins and how far it goes say."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from gen.errors import InputError
from gen.importing.guessing import names
from gen.importing.guessing.counters import counts_rows, never_falls, that_falls
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import CERTAIN, Choices
from gen.importing.guessing.odd_units import odd_in
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

CANONICAL = {
    CURRENT: ("current_A", names.CURRENT),
    VOLTAGE: ("voltage_V", names.VOLTAGE),
    SPEED: ("speed_rpm", names.SPEED),
}
"""Quantities whose columns have one name, and what they are called."""
UNSAID = 0.5
"""How sure it is that a column named after a part is its temperature."""
KEPT = "kept as it is"
WARM_C = 100.0
"""degC at which a log of a motor that ran may begin."""
_COLD_C = (-40.0, 45.0)
"""degC at which a log may begin."""
_FAR_C = 150.0
_FEW_VALUES = 3
_STATES = 5.0
"""Up to which whole numbers are rather what something does than degrees."""
_LEAST_BOUND = 5
"""Rows, for a number that is the same in all of them to be a limit."""
_SLOW = 0.7
_ALIKE_K = 8.0
"""How far apart sensors of one motor begin at most."""
_SAYS_SO = re.compile(r"(?i)temp|th?ermo|°")
_LEAST_REACHED, _FALLEN, _LEAST_BEGUN_C = 5.0, 3.0, 8.0
_LETTER = re.compile(r".*[_ ][A-Za-z]")


@dataclass(frozen=True)
class Sorted:
    """What a column is taken for.

    Attributes
    ----------
    facts
        The column.
    quantity
        As units have it; nothing for what has none.
    unit
        Of its numbers, or None.
    confidence
        0..1.
    why
        What says so.
    """

    facts: Facts
    quantity: str
    unit: Unit | None
    confidence: float
    why: str


def sorted_out(facts: Facts, evidence: Evidence, choices: Choices) -> Sorted:
    """Give the quantity and the unit of a column.

    Parameters
    ----------
    facts
        The column.
    evidence
        All of them.
    choices
        What the user says.

    Raises
    ------
    InputError
        Without a file name, for a unit that is none.
    """
    base, unit, where = facts.named
    base = names.apart(base)
    told = choices.units.get(facts.name) or choices.units.get(choices.columns.get(facts.name) or facts.name)
    if told:
        unit = unit_of(told)
        if unit is None:
            raise InputError(f'found the unit "{told}", expected degC, degF, K, A, mA, V, rpm ..', place="--unit")
        return Sorted(facts, unit.quantity, unit, CERTAIN, f"{unit.name} by --unit")
    if facts.kind != "number":
        return Sorted(facts, "", None, 0.9, f"holds {facts.kind}")
    if unit is not None and where == "name" and _one_of_letters(facts.name, evidence):
        unit = None
    if unit in (DEGC, DEGF) and names.CHARGE.fullmatch(base) and facts.name not in choices.columns:
        return Sorted(facts, "", None, 0.8, "a charge or a capacity by its name, in coulomb or farad; kept as it is")
    target = choices.columns.get(facts.name, "")
    if names.WANTED.search(base) and not target:
        return Sorted(facts, "", unit, 0.8, "a wanted or modelled value by its name")
    in_degrees = unit is not None and unit.quantity == TEMPERATURE
    if names.ASKED.search(base) and not target and (in_degrees or (unit is None and _thermal(facts, base))):
        return Sorted(facts, "", unit, 0.8, "a wanted value by its name")
    if unit is not None and in_degrees:
        said = "" if target else _no_temperature(base) or _bound(facts, base, evidence)
        if said:
            return Sorted(facts, "", unit, 0.8, said)
        return _by_unit(facts, unit, where, _thermal(facts, base))
    written = "" if unit is not None or target or not _thermal(facts, base) else facts.written_unit
    if is_foreign(written):
        return Sorted(facts, "", None, 0.8, f"in {written}, which is no unit of a temperature; kept as it is")
    if is_any_degree(written):
        return replace(_by_range(facts, False), confidence=0.5, why=f"in {written}, of an angle or of a temperature")
    if unit is None and not target and _thermal(facts, base) and (bound := _bound(facts, base, evidence)):
        return Sorted(facts, "", None, 0.8, bound)
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
        return unless_it_counts(_by_range(facts, False) if plain else _of_a_part(facts), evidence)
    if unit is not None:
        return Sorted(facts, unit.quantity, unit, 0.9, f"in {unit.name} by its {where}")
    if names.are_terms(facts.name, evidence.facts) and not target:
        return Sorted(facts, "", None, 0.8, "a controller's term by its name and those beside it; kept as it is")
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


def _of_a_part(facts: Facts) -> Sorted:
    """A part's name with a word that nobody knows: `motor_dither`; or a symbol alone: `Tw`."""
    low, high = facts.span
    begin = float(np.median(facts.starts)) if facts.starts.size else low
    if low < _COLD_C[0] or not _COLD_C[0] <= begin <= WARM_C or len(np.unique(facts.values)) <= _FEW_VALUES:
        return Sorted(facts, "", None, 0.8, KEPT)
    named = "called as one" if names.SYMBOL.fullmatch(facts.named[0]) or facts.named[0] == "T" else "named after a part"
    said = f"{named}, {low:.4g}..{high:.4g}, and nothing says that it is a temperature"
    return Sorted(facts, TEMPERATURE, unit_of("degC"), UNSAID, said)


def unless_it_counts(found: Sorted, evidence: Evidence) -> Sorted:
    """Give a temperature by little of its name, unless it rises as none does.

    Parameters
    ----------
    found
        What the column was taken for.
    evidence
        All columns.
    """
    facts = found.facts
    if found.quantity != TEMPERATURE:
        return found
    counter = counts_rows(facts)
    if counter:
        return Sorted(facts, "", None, 0.8, f"{counter}; kept as it is")
    if not never_falls(facts):
        return found
    others = [entry for entry in evidence.numbers if entry is not facts and _is_temperature(entry)]
    others = [entry for entry in others if not _bound(entry, names.apart(entry.named[0]), evidence)]
    falling = that_falls(others)
    if not falling:
        return found if found.confidence <= UNSAID else replace(found, why=f"{found.why}; it never falls")
    said = f"{found.why}; it never falls, though {falling} does"
    apart = abs(_start_degC(facts, found.unit) - float(np.median([_start_degC(entry) for entry in others])))
    if apart <= _ALIKE_K:  # what is heavy, or far from the heat, still warms while the others cool
        return replace(found, confidence=min(found.confidence, _SLOW), why=said)
    said += f", and begins {apart:.4g} K from the others: an energy or an odometer?"
    return replace(found, confidence=min(found.confidence, UNSAID), why=said)


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
    return any(pattern.fullmatch(base) for _, pattern in CANONICAL.values()) and not re.search(r"(?i)temp|thermo", base)


def _by_unit(facts: Facts, unit: Unit, where: str, thermal: bool) -> Sorted:
    begin = float(np.median(facts.starts)) if facts.starts.size else facts.span[0]
    odd = odd_in(unit, facts, begin)
    if odd:
        return Sorted(facts, TEMPERATURE, unit, 0.4, odd)
    said = f"{unit.name} by its {where}" if where == "name" else f"{unit.name} by the {where}"
    return Sorted(facts, TEMPERATURE, unit, 0.95 if thermal else 0.85, said)


def _by_range(facts: Facts, told: bool) -> Sorted:
    """A temperature whose unit nothing says: by where the log begins."""
    low, high = facts.span
    starts = facts.starts
    begin = float(np.median(starts)) if starts.size else low
    if facts.values.size and low == high == 0.0 and not told:
        return Sorted(facts, "", None, 0.8, "0 in all rows: no sensor is there; kept as it is")
    if facts.whole and 0.0 <= low < high <= _STATES and not told and not _SAYS_SO.search(names.apart(facts.named[0])):
        return Sorted(facts, "", None, 0.8, f"whole numbers {low:g}..{high:g}: states; kept as it is")
    said = f"begins at {begin:.4g}, {low:.4g}..{high:.4g}"
    if max(abs(low), abs(high)) < _LEAST_REACHED and low != high:
        return Sorted(facts, TEMPERATURE, unit_of("degC"), 0.4, f"{said}: no motor in degC; volts of a sensor?")
    if (
        not told
        and names.RESISTOR.search(facts.named[0])
        and begin - low > _FALLEN
        and high - begin < 0.2 * (begin - low)
    ):
        return Sorted(facts, TEMPERATURE, unit_of("degC"), 0.4, f"{said}, and falls from there: a resistance?")
    if starts.size and starts.min() <= _COLD_C[1] and starts.max() > _FAR_C:
        said = f"begins at {starts.min():.4g} in one file and at {starts.max():.4g} in another: of one unit?"
        return Sorted(facts, TEMPERATURE, unit_of("degC"), 0.4, said)
    celsius, kelvin = unit_of("degC"), unit_of("K")
    if facts.values.size and 260 <= begin <= 330 and low > 230 and not facts.whole:
        return Sorted(facts, TEMPERATURE, kelvin, 0.8, f"{said}: K")
    if begin > 100 or (low < -60 and high > 500):
        return Sorted(facts, TEMPERATURE, celsius, 0.3, f"{said}: no cold motor in degC, and nothing says the unit")
    if not _COLD_C[0] <= begin <= _COLD_C[1]:
        return Sorted(facts, TEMPERATURE, celsius, 0.45, f"{said}: degC after it ran, or degF of a cold one")
    return Sorted(facts, TEMPERATURE, celsius, 0.85 if told else 0.8, f"{said}: degC")


def _by_name(facts: Facts, base: str) -> Sorted:
    alone = unit_of(base) if len(base) > 1 else None
    if alone is not None and alone.quantity in CANONICAL:
        return Sorted(facts, alone.quantity, alone, 0.9, f"in {alone.name} by its name")
    for quantity, unit in ((CURRENT, "A"), (VOLTAGE, "V")):
        reached = max(map(abs, facts.span))
        if CANONICAL[quantity][1].fullmatch(base) and reached <= 100:
            return Sorted(facts, quantity, unit_of(unit), 0.7, f"by its name; up to {reached:.4g}: {unit}")
    return Sorted(facts, "", None, 0.8, KEPT)
