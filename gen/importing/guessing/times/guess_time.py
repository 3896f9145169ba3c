"""The time of a log: which columns, in what form and unit."""

from __future__ import annotations

from dataclasses import replace

from gen.errors import InputError
from gen.importing import clock
from gen.importing.guessing.evidence import Evidence
from gen.importing.guessing.guesses import CERTAIN, Choices, Guess, quoted
from gen.importing.guessing.times.find_time import EITHER, FORMS, example, find_time, first_cell
from gen.importing.guessing.times.time_unit import unit_of_time
from gen.importing.guessing.times.written_times import date_order_of, hours_or_minutes
from gen.importing.listing import listed
from gen.importing.local import is_zone
from gen.importing.mapping import DATED, TimeForm
from gen.importing.numbers import plain_number

_KINDS = {"instant": "timestamp", "clock": "time of day", "minutes": "mm:ss"}


def decide_time(evidence: Evidence, choices: Choices) -> tuple[TimeForm, list[Guess]]:
    """Find the time.

    Parameters
    ----------
    evidence
        The columns.
    choices
        What the user says.

    Raises
    ------
    InputError
        Without a file name: what was said is no column; or no column can be the time.
    """
    form, guesses = _decided(evidence, choices)
    if not choices.zone:
        return form, guesses
    if not is_zone(choices.zone):
        raise InputError(f'found "{choices.zone}", expected a time zone such as Europe/Berlin', place="--zone")
    if not form.columns or form.unit not in DATED:
        raise InputError(f"the time is a {form.unit}; expected dates with times, which a zone needs", place="--zone")
    told = replace(guesses[0], taken=f"{guesses[0].taken}, of {choices.zone}")
    return form.model_copy(update={"zone": choices.zone}), [told, *guesses[1:]]


def _decided(evidence: Evidence, choices: Choices) -> tuple[TimeForm, list[Guess]]:
    facts = evidence.facts
    if choices.time:
        names = [choices.time] if choices.time in facts else [part.strip() for part in choices.time.split(",")]
        interval = plain_number(choices.time)
        if interval is not None and choices.time not in facts:
            if interval <= 0:
                raise InputError(f"found {choices.time}, expected an interval above 0 s", place="--time")
            return TimeForm(interval_s=interval), [Guess("time", f"rows every {interval:g} s", CERTAIN, "--time")]
        for name in names:
            if name not in facts:
                raise InputError(
                    f'found "{name}", expected a column ({listed(facts)}) or an interval in s', place="--time"
                )
        return _form(evidence, names[:2], choices, CERTAIN, "--time")
    found = find_time(evidence, choices)
    return _form(evidence, found.names, choices, found.confidence, found.why)


def _form(
    evidence: Evidence, names: list[str], choices: Choices, confidence: float, why: str
) -> tuple[TimeForm, list[Guess]]:
    chosen = [evidence.facts[name] for name in names]
    subject = ", ".join(names)
    if len(chosen) == 2 or chosen[0].kind in _KINDS or chosen[0].kind == "date":
        cells = chosen[0].texts
        order, sure, reason = date_order_of(evidence, cells, names[0]) if cells else ("ymd", CERTAIN, "")
        told = choices.units.get(names[0], "")
        if told in ("dmy", "mdy", "ymd"):
            order, sure, reason = told, CERTAIN, "--unit"
        if len(chosen) == 1 and chosen[0].kind == "date":
            raise InputError("holds dates without times; expected a time, too", place=f"column {names[0]}")
        if len(chosen) == 1 and chosen[0].kind == "minutes":
            return hours_or_minutes(chosen[0], told, confidence, why)
        unit = "date and time" if len(chosen) == 2 else _KINDS[chosen[0].kind]
        form = TimeForm.model_validate({"columns": names, "unit": unit, "order": order})
        taken = unit if order == "ymd" else f"{unit}, {order}"
        other = "ymd" if reason == clock.DAY_OR_YEAR else "mdy"
        settle = f"--unit {quoted(f'{names[0]}=dmy')} or {quoted(f'{names[0]}={other}')}"
        return form, [
            Guess(subject, f"time: {taken}", min(confidence, sure), "; ".join(filter(None, (why, reason))), settle)
        ]
    entry = chosen[0]
    if entry.kind != "number":
        shown = f' such as "{example(entry)}"' if entry.kind == "text" else ""
        raise InputError(f"holds {entry.kind}{shown}, expected {FORMS}", place=first_cell(evidence, entry))
    name, sure, reason = unit_of_time(entry, choices)
    form = TimeForm(columns=names, unit=name)
    settle = f"--unit {quoted(f'{entry.name}=s')}, =ms, =min, =h or =d"
    if confidence == EITHER:
        settle = "--time COLUMN, of those that rise"
    return form, [
        Guess(subject, f"time in {name}", min(confidence, sure), "; ".join(filter(None, (why, reason))), settle)
    ]
