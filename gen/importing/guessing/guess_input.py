"""Which column drives the motor."""

from __future__ import annotations

import numpy as np

from gen.errors import InputError
from gen.importing.guessing.driving import drives, meaning
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import CERTAIN, Choices, Guess, quoted
from gen.importing.guessing.input_scale import OF_CONVERTERS, is_switch, pulse, scaled, spanned, worded
from gen.importing.guessing.names import COOLS, DUTY, HEATS, NO_DRIVE, PWM
from gen.importing.guessing.ways import sign_of
from gen.importing.listing import listed
from gen.importing.mapping import InputForm
from gen.importing.numbers import plain_number
from gen.importing.odd_inputs import errors_among, glitches_among
from gen.importing.switches import active_state
from gen.importing.units import SHARE
from gen.runs.drive import FULL_COUNTS

_MOST_OPTIONS = 8
"""Proposed in a message."""
NO_INPUT = "no column is a motor's PWM"
"""How the refusal of a log without an input begins."""
_GUESSED = "--full-scale is only the next round number that the log reaches: say what full drive is, if that is known"
"""What is said of a full scale that is proposed: of a log that never drives fully it is too low."""


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
        if counts is None or counts != round(counts) or abs(counts) > FULL_COUNTS:
            raise InputError(
                f'found "{choices.drive}", expected a column ({listed(evidence.facts)}) or whole counts -255..255 '
                "that all rows have",
                place="--input",
            )
        form = InputForm(counts=int(counts), drives=choices.machine)
        return form, [Guess("input", f"pwm = {int(counts)}", CERTAIN, "--input")]
    entry, confidence, why = _column(evidence, choices, reserved)
    entry, scale = scaled(_sound(entry), evidence, choices)
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
    if form.counts_of(np.array(reached)) > FULL_COUNTS + 0.5 and scale.confidence == CERTAIN:
        raise InputError(
            f"found {reached:g} {scale.unit}, more than its full scale of {scale.full:g}; expected "
            "--full-scale of at least that",
            place=f"column {entry.name}",
        )
    taken = (
        "pwm in counts"
        if (form.unit, form.rest, form.full_scale) == ("counts", 0.0, FULL_COUNTS)
        else f"pwm: {form.said}"
    )
    taken += f", sign of {sign}" if sign else ""
    taken += f", of a {choices.machine}" if choices.machine else ""
    shown = quoted(f"{entry.name}=percent")
    settle = f"--unit {shown}, =counts or =duty" if scale.full <= FULL_COUNTS else f"--full-scale {scale.full:g}"
    settle = f"--rest 1000 (or 1500) --full-scale 2000 of pulses in us, {settle} of counts" if pulse(entry) else settle
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
        found = [entry for entry in numbers if pattern.search(worded(entry)) and not NO_DRIVE.search(worded(entry))]
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
    if not COOLS.search(worded(entry)):
        return
    others = [it for it in drives(numbers) if HEATS.search(worded(it)) and not COOLS.search(worded(it))]
    if others:
        options = listed(map(_as_option, [*others[:_MOST_OPTIONS], entry]), " or ")
        raise InputError(
            f"is a fan's or a pump's by its name, and something else may heat; expected {options}",
            place=f"column {entry.name}",
        )


def _as_option(entry: Facts) -> str:
    return f"--input {quoted(entry.name)}{_full_scale(_plain(entry))}"


def _explained(entry: Facts, beside_others: bool) -> str:
    """The option that takes a column, and, where there are others, what it means to take this one."""
    said = meaning(entry) if beside_others else ""
    return f"{_as_option(entry)} ({said})" if said else _as_option(entry)


def _none(numbers: list[Facts], evidence: Evidence) -> str:
    driving = drives(numbers)
    said = NO_INPUT
    options = [_explained(entry, len(driving) > 1) for entry in driving[:_MOST_OPTIONS]]
    if options:
        proposed = " or ".join(options + _states(evidence))
        guessed = f"; {_GUESSED}" if any(map(_is_guessed, driving[:_MOST_OPTIONS])) else ""
        return f"{said}; expected what drives it, such as {proposed}{guessed}"
    if not numbers:
        return f"{said}, and none holds numbers; expected a table"
    names = listed(f"{entry.name} ({spanned(entry)})" for entry in numbers)
    switches = [f"--input {quoted(entry.name)}" for entry in numbers if is_switch(entry)] + _states(evidence)
    wanted = ", or ".join([*switches[:4], "--input COLUMN --full-scale X", "--input COUNTS for what all rows have"])
    return f"{said} among {names}; expected {wanted}"


def _states(evidence: Evidence) -> list[str]:
    """Columns of words of which one says that something is given power, and the others that it is not."""
    texts = [entry for entry in evidence.facts.values() if entry.kind == "text"]
    found = [(entry.name, active_state(entry.texts)) for entry in texts]
    return [f"--input {quoted(name)} (on: {states[0]}; off: {listed(states[1])})" for name, states in found if states]


def _full_scale(entry: Facts) -> str:
    unit = entry.named[1]
    known = unit.quantity == SHARE if unit is not None else is_switch(entry) or PWM.search(worded(entry))
    rest = " --rest 1000" if pulse(entry) else ""
    return "" if known else f"{rest} --full-scale {_round_up(entry):g}"


def _is_guessed(entry: Facts) -> bool:
    """Whether a full scale is proposed that the column neither says nor, as a converter's, holds."""
    plain = _plain(entry)
    return bool(_full_scale(plain)) and _round_up(plain) not in OF_CONVERTERS | {_LONGEST_US}


_LONGEST_US = 2000.0
"""A pulse that says all, us."""


def _round_up(entry: Facts) -> float:
    low, high = entry.span
    reached = max(abs(low), abs(high), 1e-9)
    if pulse(entry) and reached <= _LONGEST_US:
        return _LONGEST_US
    if entry.whole and reached in OF_CONVERTERS:
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
