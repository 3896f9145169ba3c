"""Which column is the time, and its unit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.errors import InputError
from gen.importing import clock
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import CERTAIN, Choices, Guess, quoted
from gen.importing.guessing.names import BUSY, CHARGED, LATE, OF_A_STEP, TIME, WORKED
from gen.importing.guessing.times.time_unit import EARLIEST_S, epoch_of, unit_of_time
from gen.importing.guessing.times.written_times import date_order_of, hours_or_minutes
from gen.importing.listing import listed
from gen.importing.local import is_zone
from gen.importing.mapping import DATED, TimeForm
from gen.importing.numbers import plain_number
from gen.importing.units import TIME as TIME_QUANTITY
from gen.importing.units import unit_of

_FORMS = "times such as 2026-04-03T23:30:00, 3.4.2026 23:30, 3 Apr 2026 23:30:00, 23:30:00, 1h30m00s, or numbers"
_KINDS = {"instant": "timestamp", "clock": "time of day", "minutes": "mm:ss"}
_PLAIN = {"t", "ts", "s", "time", "times", "zeit", "timestamp", "zeitstempel", "elapsed", "seconds", "millis", "ms"}
"""Names of a time that need nothing beside them."""
_EITHER = 0.5
_RATIOS = tuple(x for r in (1.0, 60.0, 3600.0, 1e3, 1e6, 1e9) for x in (r, 1.0 / r))
_SAME_LENGTH = 0.05
_EVEN = 0.8
"""Of the steps."""
_MOST_BACK = 0.2
"""Of the steps of a time: where more of them go back, rows are not in its order."""
_COARSE_S = 2.0
"""By which timestamps of whole seconds may be off at both ends."""


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
    return _form(evidence, *_found(evidence, choices))


def _found(evidence: Evidence, choices: Choices) -> tuple[list[str], Choices, float, str]:
    facts = [entry for name, entry in evidence.facts.items() if choices.columns.get(name, "time_s") == "time_s"]
    numbers = [entry for entry in facts if entry.kind == "number" and _rises(entry)]
    instants = [entry for entry in facts if entry.kind == "instant"]
    known = [entry for entry in numbers if _timed(entry) and entry.named[1] is not None]
    known = [entry for entry in known if not any(_contradicts(entry, instant) for instant in instants)]
    known = [entry for entry in known if not (instants and WORKED.search(entry.named[0]))]
    known = [entry for entry in known if not OF_A_STEP.search(entry.named[0])] or known
    if known:
        best = next((entry for entry in known if TIME.fullmatch(entry.named[0].casefold())), known[0])
        return [best.name], choices, 0.95, "by its name and unit; it rises"
    dates = [entry for entry in facts if entry.kind == "date"]
    clocks = [entry for entry in facts if entry.kind in ("clock", "minutes")]
    taken = [entry for entry in numbers if _named_so(entry) and not LATE.search(entry.name) and epoch_of(entry)]
    if instants and not (taken and all(LATE.search(entry.name) for entry in instants)):
        best = min(instants, key=lambda entry: (_stands(entry), bool(LATE.search(entry.name))))
        return [best.name], choices, 0.95, f"timestamps such as {_example(best)}"
    named = [entry for entry in numbers if _named_so(entry) and not entry.in_degrees]
    named.sort(key=lambda entry: entry.named[0] == "T")  # beside `t`, a temperature that rises evenly
    if dates and clocks:
        return (
            [dates[0].name, clocks[0].name],
            choices,
            0.95,
            f"a date and a time: {_example(dates[0])}{_parted(clocks[0])}",
        )
    if any(not BUSY.search(entry.named[0]) for entry in named):
        return _one_of(named, choices)
    if clocks:
        return [clocks[0].name], choices, 0.85, f"times such as {_example(clocks[0])}{_parted(clocks[0])}"
    unnamed = [entry for entry in numbers if entry.name.startswith("column_")]
    if unnamed:
        since = [entry for entry in unnamed if epoch_of(entry)]
        best = (since or unnamed)[0]
        return [best.name], choices, 0.7, "" if since else "the first column that rises all the way"
    words = next((entry for entry in facts if entry.kind == "text" and _called_so(entry)), None)
    if words is not None:
        raise InputError(
            f'found "{_example(words)}", expected {_FORMS}; or --time SECONDS for the interval of the rows',
            place=_first(evidence, words),
        )
    table = evidence.tables[0]
    stands = next((entry for entry in facts if entry.kind == "number" and _called_so(entry)), None)
    if stands is not None and not stands.in_degrees and stands.span[1] >= EARLIEST_S:
        back = np.flatnonzero(stands.steps < 0)
        if back.size > _MOST_BACK * stands.steps.size:
            raise InputError(
                f"goes back {back.size} times in {stands.values.size} rows; expected --time {quoted(stands.name)} "
                "--sort, which puts rows in the order of their times, or another --time COLUMN",
                place=_first(evidence, stands),
            )
        raise InputError(
            f"does not go on ({stands.span[0]:g}..{stands.span[1]:g}): were its last digits lost, as in a spreadsheet? "
            "expected --time SECONDS for the interval of the rows, or another --time COLUMN",
            place=_first(evidence, stands),
        )
    raise InputError(
        f"no column is a time among {listed(evidence.facts)}; expected --time COLUMN, or --time SECONDS for the "
        f"interval of its rows{f'; better, {table.untimed}' if table.untimed else ''}",
        place=table.place(0),
    )


def _one_of(named: list[Facts], choices: Choices) -> tuple[list[str], Choices, float, str]:
    """The first of the columns that say time; doubtful where another runs otherwise: a processor's time, a print's."""
    plain = [entry for entry in named if entry.named[0].casefold() in _PLAIN]
    if plain or len(named) == 1:
        return [(plain or named)[0].name], choices, 0.85, "by its name; it rises"
    first, *others = named
    other = next((entry for entry in others if not _alike(first, entry)), None)
    if other is None:
        return [first.name], choices, 0.85, "by its name; it rises"
    lasts = ", ".join(f"{entry.name} by {entry.span[1] - entry.span[0]:g}" for entry in (first, other))
    return [first.name], choices, _EITHER, f"{lasts}: either may be the time"


def _length(entry: Facts) -> float:
    low, high = np.percentile(entry.values, (5, 95))  # the first row may be stale
    return float(high - low)


def _alike(one: Facts, other: Facts) -> bool:
    """Whether two columns last equally long, in whatever units."""
    ratio = _length(one) / max(_length(other), 1e-12)
    return any(abs(ratio * scale - 1.0) < _SAME_LENGTH for scale in _RATIOS)


def _contradicts(entry: Facts, instants: Facts) -> bool:
    """Whether a time in a unit lasts otherwise than timestamps say: WinCC's `Time_ms` counts millionths of days."""
    unit, cells = entry.named[1], instants.columns[0].cells
    values = entry.parsed[0].values
    if unit is None or not isinstance(cells, list):
        return False
    time, _ = clock.seconds(clock.instants(cells, clock.date_order(cells)[0]))
    both = np.flatnonzero(np.isfinite(time) & np.isfinite(values))
    if both.size < 2 or not time[both].max() > time[both].min():
        return False
    lasts, said = np.ptp(time[both]), np.ptp(values[both]) * unit.scale
    return bool(abs(said - lasts) > max(_SAME_LENGTH * lasts, _COARSE_S))


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
        shown = f' such as "{_example(entry)}"' if entry.kind == "text" else ""
        raise InputError(f"holds {entry.kind}{shown}, expected {_FORMS}", place=_first(evidence, entry))
    name, sure, reason = unit_of_time(entry, choices)
    form = TimeForm(columns=names, unit=name)
    settle = f"--unit {quoted(f'{entry.name}=s')}, =ms, =min, =h or =d"
    if confidence == _EITHER:
        settle = "--time COLUMN, of those that rise"
    return form, [
        Guess(subject, f"time in {name}", min(confidence, sure), "; ".join(filter(None, (why, reason))), settle)
    ]


def _timed(entry: Facts) -> bool:
    base, unit, _ = entry.named
    alone = unit_of(base) if unit is None else unit
    if CHARGED.search(base):
        return False
    return (
        bool(TIME.fullmatch(base.casefold()) or base.casefold() in ("t", ""))
        and (unit is None or unit.quantity == TIME_QUANTITY)
    ) or (alone is not None and alone.quantity == TIME_QUANTITY)


def _called_so(entry: Facts) -> bool:
    return bool(TIME.fullmatch(entry.named[0].casefold()))


def _first(evidence: Evidence, entry: Facts) -> str:
    """Where a column holds something first."""
    cells = entry.columns[0].cells
    row = next((k for k, cell in enumerate(cells) if cell), 0) if isinstance(cells, list) else 0
    return evidence.tables[0].place(row, entry.name)


def _named_so(entry: Facts) -> bool:
    """Whether a name says time: of `T` only where its steps are even, for temperatures are called so, too."""
    base = entry.named[0]
    return _called_so(entry) and not CHARGED.search(base) and (base != "T" or _is_even(entry))


def _is_even(entry: Facts) -> bool:
    usual = float(np.median(entry.steps)) if entry.steps.size else 0.0
    return usual > 0 and bool((np.abs(entry.steps - usual) <= _SAME_LENGTH * usual).mean() >= _EVEN)


def _rises(entry: Facts) -> bool:
    """Whether it rises nearly always: loggers repeat times, and begin anew."""
    steps = entry.steps
    if not steps.size:
        return entry.values.size > 0
    return bool((steps >= 0).mean() > 1.0 - _MOST_BACK and (steps > 0).mean() > 0.04)


def _stands(entry: Facts) -> bool:
    """Whether a column says one instant in all rows of each table: when a file or a query was begun."""
    return all(len(set(map(str, column.cells))) < 2 < len(column.cells) for column in entry.columns)


def _parted(entry: Facts) -> str:
    """What is said of times that look like dates."""
    return ", hours.minutes.seconds" if clock.dotted(entry.texts) else ""


def _example(entry: Facts) -> str:
    cells = entry.columns[0].cells
    return next((cell for cell in cells if cell), "") if isinstance(cells, list) else str(cells[0])[:23]
