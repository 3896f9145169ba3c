"""What of an input is 255 counts: by its unit, by what its name says, else by how far it goes."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace

import numpy as np

from gen.errors import InputError
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import CERTAIN, Choices, quoted
from gen.importing.guessing.names import DUTY, PWM, apart
from gen.importing.odd_inputs import glitches_among
from gen.importing.units import COUNTS, SHARE, Unit, unit_of
from gen.importing.units import DUTY as DUTY_SHARE
from gen.runs.drive import COMMENT, FULL_COUNTS, OWN_UNIT
from gen.runs.drive import COUNTS as COUNTS_UNIT

OF_CONVERTERS = {127.0, 255.0, 511.0, 1023.0, 2047.0, 4095.0, 8191.0, 16383.0, 32767.0, 65535.0}
"""Whole numbers that reach one of these are counts of a converter or timer."""
_PERCENT = 100.0
_ROUND = {100.0, 1000.0, 10_000.0}
_EITHER = 0.5
_PULSE_US = (800.0, 2200.0)
_BITS = re.compile(r"(?<!\d)(?P<bits>8|9|1[0-6])[ _-]?bits?(?![a-z])", re.IGNORECASE)
_RANGED = re.compile(
    r"(?<![\d.])0 ?(?:-|\.\.\.?|…|to) ?(?P<low>[1-9]\d{2,4})(?![\d.])|/ ?(?P<over>[1-9]\d{2,4})(?![\d.])"
)
_INVERTED = re.compile(r"(?<![a-z])(?:inverted|invert|active[ _-]?low)(?![a-z])", re.IGNORECASE)


@dataclass(frozen=True)
class InputScale:
    """What 255 counts are.

    Parameters
    ----------
    unit, full
        The value that becomes 255 counts, and its unit.
    confidence, why
        How sure that is, and by what.
    """

    unit: str
    full: float
    confidence: float
    why: str


def worded(entry: Facts) -> str:
    """A column's name with its words apart, and with accents that are letters of their own joined to those below."""
    return apart(unicodedata.normalize("NFC", entry.name))


def spanned(entry: Facts) -> str:
    """From where to where a column's numbers go."""
    low, high = entry.span
    return f"{low:g}" if low == high else f"{low:g}..{high:g}"


def is_switch(entry: Facts) -> bool:
    """Whether a column holds 0 and 1, and nothing else."""
    return entry.whole and entry.span == (0.0, 1.0)


def scaled(entry: Facts, evidence: Evidence, choices: Choices) -> tuple[Facts, InputScale]:
    """Give the readings that are believed, and their scale; doubtful where a reading or three would make it another.

    Parameters
    ----------
    entry
        The input's column.
    evidence
        With all others.
    choices
        What the user says.

    Raises
    ------
    InputError
        Without a file name: nothing tells the scale, or the name says that the input is inverted.
    """
    glitches = glitches_among(entry.values)
    plain = entry.without(glitches)
    scale = _scale(plain, evidence, choices)
    if not glitches:
        return entry, scale
    try:
        other = _scale(entry, evidence, choices)
    except InputError:
        other = None
    if other is not None and (other.unit, other.full) == (scale.unit, scale.full):
        return (entry if max(map(abs, entry.span)) <= scale.full else plain), scale
    place = _place_of(entry, glitches[0], evidence)
    far = f"{glitches[0]:g} ({place}) is far beyond all others, {spanned(plain)}"
    sure = scale.confidence if scale.confidence == CERTAIN or "by its name" in scale.why else _EITHER
    return plain, replace(scale, confidence=sure, why=f"{scale.why}; {far}")


def _place_of(entry: Facts, value: float, evidence: Evidence) -> str:
    for table, parsed in zip(evidence.tables, entry.parsed, strict=True):
        rows = np.flatnonzero(parsed.values == value)
        if rows.size:
            return table.place(int(rows[0]))
    return ""


def _scale(entry: Facts, evidence: Evidence, choices: Choices) -> InputScale:
    low, high = entry.span
    reached = max(abs(low), abs(high))
    base, unit, _ = entry.named
    told = choices.units.get(entry.name) or choices.units.get("pwm")
    if told:
        unit = unit_of(told) or Unit("other", told, told)
    if choices.full_scale is None and not told and (by_name := _said_full(entry, reached)) is not None:
        return by_name
    if choices.full_scale is not None:
        said = "--full-scale"
        if unit is None and _bare(entry) == OWN_UNIT and entry.whole and choices.full_scale in OF_CONVERTERS:
            said += f"; if these are counts: --unit {quoted(f'{entry.name}=counts')}"
        return InputScale(unit.name if unit else _bare(entry), choices.full_scale, CERTAIN, said)
    if unit is not None and unit.quantity in (SHARE, COUNTS):
        full = 100.0 / unit.scale if unit.quantity == SHARE else FULL_COUNTS / unit.scale
        sure = CERTAIN if told else 0.95
        if unit.quantity == SHARE and not told and full > 1.0 and 0 < reached <= 1.0:
            said = f"in {unit.name} by its name, but {low:g}..{reached:g}, as a share of 1"
            return InputScale(DUTY_SHARE.name, 1.0, _EITHER, said)
        if reached > full * (1 + 0.5 / FULL_COUNTS) and not told:  # else it is refused, with its full scale
            return InputScale(
                unit.name, float(_full_counts(reached)), 0.3, f"{reached:g} is more than {full:g} {unit.name}"
            )
        return InputScale(unit.name, full, sure, "--unit" if told else f"in {unit.name} by its name")
    if unit is None and is_switch(entry):
        return InputScale(_bare(entry), 1.0, 0.9, "nothing but 0 and 1: 1 is on")
    if unit is not None or (choices.drive and not PWM.search(worded(entry)) and not DUTY.search(worded(entry))):
        shown = f" {unit.name}" if unit else ""
        raise InputError(
            f"found {low:g}..{high:g}{shown}; expected --full-scale, the value that is 255 counts{pulse(entry)}",
            place=f"column {entry.name}",
        )
    return _by_range(entry, base, reached, evidence)


def _said_full(entry: Facts, reached: float) -> InputScale | None:
    """The full scale that a name says beside a PWM: `PWM 10bit`, `PWM [0-1023]`, `PWM/1023`; None where it says none.

    Raises
    ------
    InputError
        Without a file name: the name says that the input is inverted.
    """
    text = f"{entry.name} {entry.columns[0].unit}"
    found = _BITS.search(text)
    full = 2.0 ** int(found["bits"]) - 1.0 if found else None
    ranged = _RANGED.search(text)
    full = float(ranged["low"] or ranged["over"]) if full is None and ranged else full
    if _INVERTED.search(text):
        raise InputError(
            f"is inverted by its name; expected the input: put {full or _full_counts(reached):g} - x in its "
            "place, under another name",
            place=f"column {entry.name}",
        )
    if full not in OF_CONVERTERS | _ROUND or reached > full * (1 + 0.5 / FULL_COUNTS):
        return None
    return InputScale("counts", full, 0.95, f"0 to {full:g} by its name")


def pulse(entry: Facts) -> str:
    """What is said of numbers that may be a servo's or a speed controller's pulses, which are not 0 at rest."""
    low, high = entry.span
    if low < _PULSE_US[0] or high > _PULSE_US[1]:
        return ""
    return "; if these are a servo's pulses in us, --rest 1000 (or 1500) and --full-scale 2000"


def _by_range(entry: Facts, base: str, reached: float, evidence: Evidence) -> InputScale:
    own = "time_s" in evidence.facts and entry.name == "pwm"
    if own and entry.whole and reached == _PERCENT and not _written_by_gen(evidence):
        said = f"whole numbers up to exactly {reached:g}: as likely percent as counts of 255"
        return InputScale("counts", FULL_COUNTS, _EITHER, said)
    if own and entry.whole and reached <= FULL_COUNTS:
        return InputScale(
            "counts",
            FULL_COUNTS,
            0.75 if reached <= 100 else 0.95,
            f"a run file's own column, whole, up to {reached:g}",
        )
    if reached > FULL_COUNTS:
        return InputScale("counts", float(_full_counts(reached)), 0.3, f"reaches {reached:g}, more than 255 counts")
    if reached > 100:
        return InputScale("counts", FULL_COUNTS, 0.9 if entry.whole else 0.7, f"reaches {reached:g}: counts of 255")
    if not entry.whole and reached <= 1.0:
        return InputScale("duty", 1.0, 0.85, f"fractions up to {reached:g}: a share of 1")
    if not entry.whole and PWM.search(worded(entry)):
        return InputScale("percent", 100.0, _EITHER, f"fractions up to {reached:g} may be percent or means of counts")
    if not entry.whole:
        return InputScale("percent", 100.0, 0.7, f"fractions up to {reached:g}: percent")
    if reached == 0:
        return InputScale("counts", FULL_COUNTS, 0.9, "0 in all rows")
    if DUTY.search(base):
        return InputScale("percent", 100.0, 0.7 if reached > 1 else 0.4, f"a duty cycle up to {reached:g}")
    return InputScale("counts", FULL_COUNTS, 0.4, f"whole numbers up to {reached:g} may be counts of 255 or percent")


def _written_by_gen(evidence: Evidence) -> bool:
    """Whether these are run files that say of themselves what their counts are."""
    return all(COMMENT in table.comments for table in evidence.tables)


def _bare(entry: Facts) -> str:
    return COUNTS_UNIT if PWM.search(entry.name) else OWN_UNIT


def _full_counts(reached: float) -> int:
    return next((2**bits - 1 for bits in (8, 10, 12, 14, 16) if reached <= 2**bits), int(np.ceil(reached)))
