"""Which column drives the motor, and what of it is 255 counts."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace

import numpy as np

from gen.errors import InputError
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import CERTAIN, Choices, Guess, quoted
from gen.importing.guessing.names import COOLS, DRIVES, DUTY, HEATS, NO_DRIVE, PWM, WANTED, apart
from gen.importing.guessing.ways import sign_of
from gen.importing.listing import listed
from gen.importing.mapping import InputForm
from gen.importing.numbers import plain_number
from gen.importing.odd_inputs import errors_among, glitches_among
from gen.importing.switches import active_state
from gen.importing.units import COUNTS, SHARE, Unit, unit_of
from gen.importing.units import DUTY as DUTY_SHARE

FULL = 255
_FULL_COUNTS = {127.0, 255.0, 511.0, 1023.0, 2047.0, 4095.0, 8191.0, 16383.0, 32767.0, 65535.0}
"""Whole numbers that reach one of these are counts of a converter or timer."""
_ROUND = {100.0, 1000.0, 10_000.0}
_EITHER = 0.5
_MOST_OPTIONS = 4
"""Proposed in a message."""
NO_INPUT = "no column is a motor's PWM"
"""How the refusal of a log without an input begins."""


@dataclass(frozen=True)
class _Scale:
    unit: str
    full: float
    confidence: float
    why: str


_PULSE_US = (800.0, 2200.0)
_BITS = re.compile(r"(?<!\d)(?P<bits>8|9|1[0-6])[ _-]?bits?(?![a-z])", re.IGNORECASE)
_RANGED = re.compile(
    r"(?<![\d.])0 ?(?:-|\.\.\.?|…|to) ?(?P<low>[1-9]\d{2,4})(?![\d.])|/ ?(?P<over>[1-9]\d{2,4})(?![\d.])"
)
_INVERTED = re.compile(r"(?<![a-z])(?:inverted|invert|active[ _-]?low)(?![a-z])", re.IGNORECASE)


def decide_input(evidence: Evidence, choices: Choices, reserved: set[str]) -> tuple[InputForm, list[Guess]]:
    """Find the input and its scale.

    Parameters
    ----------
    evidence
        The columns.
    choices
        What the user says.
    reserved
        Columns that the time is made of.

    Raises
    ------
    InputError
        Without a file name: what was said is no column, or does not fit what it holds; or no column is a PWM.
    """
    if choices.drive and choices.drive not in evidence.facts:
        counts = plain_number(choices.drive)
        if counts is None or counts != round(counts) or abs(counts) > FULL:
            raise InputError(
                f'found "{choices.drive}", expected a column ({listed(evidence.facts)}) or whole counts -255..255 '
                "that all rows have",
                place="--input",
            )
        form = InputForm(counts=int(counts), drives=choices.machine)
        return form, [Guess("input", f"pwm = {int(counts)}", CERTAIN, "--input")]
    entry, confidence, why = _column(evidence, choices, reserved)
    entry, scale = _scaled(_sound(entry), evidence, choices)
    sign, backwards = sign_of(evidence, entry, reserved | {entry.name}, choices)
    rest = choices.rest or 0.0
    if rest >= scale.full:
        raise InputError(
            f"found {rest:g}, expected less than the full scale of {scale.full:g} {scale.unit}", place="--rest"
        )
    form = InputForm(
        column=entry.name,
        unit=scale.unit,
        full_scale=scale.full,
        rest=rest,
        sign=sign,
        backwards=backwards,
        drives=choices.machine,
    )
    reached = max(abs(value - rest) for value in entry.span) + rest
    if form.counts_of(np.array(reached)) > FULL + 0.5 and scale.confidence == CERTAIN:
        raise InputError(
            f"found {reached:g} {scale.unit}, more than its full scale of {scale.full:g}; expected "
            "--full-scale of at least that",
            place=f"column {entry.name}",
        )
    taken = "pwm in counts" if (form.unit, form.rest, form.full_scale) == ("counts", 0.0, FULL) else f"pwm: {form.said}"
    taken += f", sign of {sign}" if sign else ""
    taken += f", of a {choices.machine}" if choices.machine else ""
    shown = quoted(f"{entry.name}=percent")
    settle = f"--unit {shown}, =counts or =duty" if scale.full <= FULL else f"--full-scale {scale.full:g}"
    settle = f"--rest 1000 (or 1500) --full-scale 2000 of pulses in us, {settle} of counts" if _pulse(entry) else settle
    return form, [
        Guess(entry.name, taken, min(confidence, scale.confidence), "; ".join(filter(None, (why, scale.why))), settle)
    ]


def _column(evidence: Evidence, choices: Choices, reserved: set[str]) -> tuple[Facts, float, str]:
    if choices.drive:
        entry = evidence.facts[choices.drive]
        if entry.kind != "number":
            raise InputError(f"holds {entry.kind}, expected numbers", place=f"column {entry.name}")
        return entry, CERTAIN, "--input"
    renamed = [name for name, new in choices.columns.items() if new == "pwm"]
    left = {name for name, new in choices.columns.items() if new != "pwm"}
    numbers = [entry for entry in evidence.numbers if entry.name not in reserved | left]
    for entry in numbers:
        if entry.name in renamed:
            return entry, CERTAIN, "--column"
    for pattern, confidence in ((PWM, 0.95), (DUTY, 0.85)):
        found = [entry for entry in numbers if pattern.search(_worded(entry)) and not NO_DRIVE.search(_worded(entry))]
        exact = [entry for entry in found if entry.named[0].casefold() in ("pwm", "duty")]
        if len(found) > 1 and len(exact) != 1:
            names = listed((f"--input {quoted(entry.name)}" for entry in found), " or ")
            raise InputError(
                f"{len(found)} columns may be the input; expected {names}", place=evidence.tables[0].place(0)
            )
        if found:
            _check_alone((exact or found)[0], numbers)
            return (exact or found)[0], confidence, "by its name"
    raise InputError(_none(numbers, evidence), place=evidence.tables[0].place(0))


def _check_alone(entry: Facts, numbers: list[Facts]) -> None:
    """Ask where the only duty is a fan's, and something else may heat."""
    if not COOLS.search(_worded(entry)):
        return
    others = [it for it in _drives(numbers) if HEATS.search(_worded(it)) and not COOLS.search(_worded(it))]
    if others:
        options = listed(map(_as_option, [*others[:_MOST_OPTIONS], entry]), " or ")
        raise InputError(
            f"is a fan's or a pump's by its name, and something else may heat; expected {options}",
            place=f"column {entry.name}",
        )


def _drives(numbers: list[Facts]) -> list[Facts]:
    """Columns that may drive it by their names."""
    drives = [entry for entry in numbers if DRIVES.search(_worded(entry)) and entry.span != (0.0, 0.0)]
    drives = [entry for entry in drives if not entry.in_degrees]
    return [entry for entry in drives if not WANTED.search(_worded(entry))] or drives  # what was wanted heats nothing


def _as_option(entry: Facts) -> str:
    return f"--input {quoted(entry.name)}{_full_scale(_plain(entry))}"


def _none(numbers: list[Facts], evidence: Evidence) -> str:
    drives = _drives(numbers)
    said = NO_INPUT
    options = list(map(_as_option, drives[:_MOST_OPTIONS]))
    if options:
        return f"{said}; expected what drives it, such as {' or '.join(options + _states(evidence))}"
    if not numbers:
        return f"{said}, and none holds numbers; expected a table"
    names = listed(f"{entry.name} ({spanned(entry)})" for entry in numbers)
    switches = [f"--input {quoted(entry.name)}" for entry in numbers if _switch(entry)] + _states(evidence)
    wanted = ", or ".join([*switches[:4], "--input COLUMN --full-scale X", "--input COUNTS for what all rows have"])
    return f"{said} among {names}; expected {wanted}"


def _states(evidence: Evidence) -> list[str]:
    """Columns of words of which one says that something is given power, and the others that it is not."""
    texts = [entry for entry in evidence.facts.values() if entry.kind == "text"]
    found = [(entry.name, active_state(entry.texts)) for entry in texts]
    return [f"--input {quoted(name)} (on: {states[0]}; off: {listed(states[1])})" for name, states in found if states]


def _worded(entry: Facts) -> str:
    """A column's name with its words apart, and with accents that are letters of their own joined to those below."""
    return apart(unicodedata.normalize("NFC", entry.name))


def spanned(entry: Facts) -> str:
    """From where to where a column's numbers go."""
    low, high = entry.span
    return f"{low:g}" if low == high else f"{low:g}..{high:g}"


def _full_scale(entry: Facts) -> str:
    unit = entry.named[1]
    known = unit.quantity == SHARE if unit is not None else _switch(entry) or PWM.search(_worded(entry))
    return "" if known else f" --full-scale {_round_up(entry):g}"


def _switch(entry: Facts) -> bool:
    """Whether a column holds 0 and 1, and nothing else."""
    return entry.whole and entry.span == (0.0, 1.0)


def _round_up(entry: Facts) -> float:
    low, high = entry.span
    reached = max(abs(low), abs(high), 1e-9)
    if entry.whole and reached in _FULL_COUNTS:
        return reached
    power = 10.0 ** np.floor(np.log10(reached))
    return float(next(m for m in (1.0, 2.0, 5.0, 10.0) if m * power >= reached) * power)


def _sound(entry: Facts) -> Facts:
    """A column without numbers that stand for an error."""
    return entry.without(errors_among(entry.values))


def _plain(entry: Facts) -> Facts:
    """A column without those, and without single readings far beyond all others."""
    sound = _sound(entry)
    return sound.without(glitches_among(sound.values))


def _scaled(entry: Facts, evidence: Evidence, choices: Choices) -> tuple[Facts, _Scale]:
    """The readings that are believed, and their scale; doubtful where a reading or three would make it another."""
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


def _scale(entry: Facts, evidence: Evidence, choices: Choices) -> _Scale:
    low, high = entry.span
    reached = max(abs(low), abs(high))
    base, unit, _ = entry.named
    told = choices.units.get(entry.name) or choices.units.get("pwm")
    if told:
        unit = unit_of(told) or Unit("other", told, told)
    if choices.full_scale is None and not told and (by_name := _said_full(entry, reached)) is not None:
        return by_name
    if choices.full_scale is not None:
        return _Scale(unit.name if unit else _bare(entry), choices.full_scale, CERTAIN, "--full-scale")
    if unit is not None and unit.quantity in (SHARE, COUNTS):
        full = 100.0 / unit.scale if unit.quantity == SHARE else FULL / unit.scale
        sure = CERTAIN if told else 0.95
        if unit.quantity == SHARE and not told and full > 1.0 and 0 < reached <= 1.0:
            said = f"in {unit.name} by its name, but {low:g}..{reached:g}, as a share of 1"
            return _Scale(DUTY_SHARE.name, 1.0, _EITHER, said)
        if reached > full * (1 + 0.5 / FULL) and not told:  # else it is refused, with its full scale
            return _Scale(
                unit.name, float(_full_counts(reached)), 0.3, f"{reached:g} is more than {full:g} {unit.name}"
            )
        return _Scale(unit.name, full, sure, "--unit" if told else f"in {unit.name} by its name")
    if unit is None and _switch(entry):
        return _Scale(_bare(entry), 1.0, 0.9, "nothing but 0 and 1: 1 is on")
    if unit is not None or (choices.drive and not PWM.search(_worded(entry)) and not DUTY.search(_worded(entry))):
        shown = f" {unit.name}" if unit else ""
        raise InputError(
            f"found {low:g}..{high:g}{shown}; expected --full-scale, the value that is 255 counts{_pulse(entry)}",
            place=f"column {entry.name}",
        )
    return _by_range(entry, base, reached, evidence)


def _said_full(entry: Facts, reached: float) -> _Scale | None:
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
            f"is inverted by its name; expected the input: put {full or _full_counts(reached):g} - x in its place",
            place=f"column {entry.name}",
        )
    if full not in _FULL_COUNTS | _ROUND or reached > full * (1 + 0.5 / FULL):
        return None
    return _Scale("counts", full, 0.95, f"0 to {full:g} by its name")


def _pulse(entry: Facts) -> str:
    """What is said of numbers that may be a servo's or a speed controller's pulses, which are not 0 at rest."""
    low, high = entry.span
    if low < _PULSE_US[0] or high > _PULSE_US[1]:
        return ""
    return "; if these are a servo's pulses in us, --rest 1000 (or 1500) and --full-scale 2000"


def _by_range(entry: Facts, base: str, reached: float, evidence: Evidence) -> _Scale:
    own = "time_s" in evidence.facts and entry.name == "pwm"
    if own and entry.whole and reached <= FULL:
        return _Scale(
            "counts", FULL, 0.75 if reached <= 100 else 0.95, f"a run file's own column, whole, up to {reached:g}"
        )
    if reached > FULL:
        return _Scale("counts", float(_full_counts(reached)), 0.3, f"reaches {reached:g}, more than 255 counts")
    if reached > 100:
        return _Scale("counts", FULL, 0.9 if entry.whole else 0.7, f"reaches {reached:g}: counts of 255")
    if not entry.whole and reached <= 1.0:
        return _Scale("duty", 1.0, 0.85, f"fractions up to {reached:g}: a share of 1")
    if not entry.whole and PWM.search(_worded(entry)):
        return _Scale("percent", 100.0, _EITHER, f"fractions up to {reached:g} may be percent or means of counts")
    if not entry.whole:
        return _Scale("percent", 100.0, 0.7, f"fractions up to {reached:g}: percent")
    if reached == 0:
        return _Scale("counts", FULL, 0.9, "0 in all rows")
    if DUTY.search(base):
        return _Scale("percent", 100.0, 0.7 if reached > 1 else 0.4, f"a duty cycle up to {reached:g}")
    return _Scale("counts", FULL, 0.4, f"whole numbers up to {reached:g} may be counts of 255 or percent")


def _bare(entry: Facts) -> str:
    return "counts" if PWM.search(entry.name) else "of its own unit"


def _full_counts(reached: float) -> int:
    return next((2**bits - 1 for bits in (8, 10, 12, 14, 16) if reached <= 2**bits), int(np.ceil(reached)))
