"""From the tables of one header to a mapping: what the user says, what the mapping file says, else a guess."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from collections.abc import Mapping as Named
from dataclasses import dataclass, field
from itertools import pairwise

from gen.errors import InputError
from gen.importing.drive import odd_of
from gen.importing.guessing.evidence import Evidence
from gen.importing.guessing.extreme_rows import extremes_by_turns
from gen.importing.guessing.guess_columns import decide_columns
from gen.importing.guessing.guess_input import NO_INPUT, decide_input
from gen.importing.guessing.guesses import CERTAIN, Choices, Guess, quoted
from gen.importing.guessing.input_scale import spanned
from gen.importing.guessing.names import RISE, RUNS
from gen.importing.guessing.parted import mixed
from gen.importing.guessing.series_columns import names_and_values
from gen.importing.guessing.suspicious import noted, suspicious
from gen.importing.guessing.timed_rows import of_timed_rows
from gen.importing.guessing.times.guess_time import decide_time
from gen.importing.listing import listed
from gen.importing.mapping import Entry, Mapping, TextForm
from gen.importing.reading.text import shown_delimiter
from gen.importing.table import Table
from gen.importing.units import unit_of

_MOST_RUNS = 1000
_LEAST_ROWS = 2
"""Of a run, on average."""
_MOST_NAMES = 4
"""Shown of a column of them."""
_LEAST_VALUES = 3
"""Different ones, of a column that moves."""
_MOST_SHOWN = 3
_OF_OPTIONS = {"--input", "--rest", "--full-scale", "--unit", "--column"}
"""Places of what the user said wrongly: nothing else is asked for beside that."""
NO_PART = "no column is a part's temperature"
"""How the refusal of a log without one begins."""


class RowForEach(InputError):
    """A table has a row for each reading of any sensor.

    Parameters
    ----------
    message
        What was found and what was expected.
    series
        What `--series` has to be told, or nothing.
    file, place
        As of any bad input.
    """

    def __init__(self, message: str, series: str, *, file: str | None = None, place: str | None = None) -> None:
        self.series = series
        super().__init__(message, file=file, place=place)


@dataclass(frozen=True)
class Decided:
    """What was decided of the tables of one header.

    Parameters
    ----------
    evidence
        The tables.
    mapping
        What their columns are.
    guesses
        How sure that is, and why.
    warnings
        What is suspicious of that, in a line each.
    odd
        Numbers in the input's column that are none of the input, and what they are.
    notes
        What is worth to know of it, in a line each.
    """

    evidence: Evidence
    mapping: Mapping
    guesses: Sequence[Guess]
    warnings: Sequence[str] = ()
    odd: Named[float, str] = field(default_factory=dict)
    notes: Sequence[str] = ()


def decide(tables: Sequence[Table], choices: Choices, known: Mapping | None) -> Decided:
    """Decide of tables with the same columns.

    Parameters
    ----------
    tables
        At least one.
    choices
        What the user says.
    known
        The mapping file's, or None.

    Raises
    ------
    InputError
        With the file: nothing can be the time, the input or a temperature, or what was said does not fit.
    """
    evidence = Evidence(tables)
    try:
        _check_choices(evidence, choices)
        decided = _by_mapping(evidence, known) if known is not None else _by_guess(evidence, choices)
        _check_entries(decided.mapping, evidence)
    except RowForEach as error:
        raise RowForEach(error.message, error.series, file=tables[0].label, place=error.place) from None
    except InputError as error:
        raise InputError(error.message, file=error.file or tables[0].label, place=error.place) from None
    return decided


def doubts(decided: Decided) -> InputError | None:
    """What may not be taken without being asked, in one line; None where all is sure enough."""
    asked = _asked(decided.guesses)
    return InputError(f"doubtful: {asked}", file=decided.evidence.tables[0].label) if asked else None


def _asked(guesses: Sequence[Guess]) -> str:
    """What is doubtful, each with what settles it; empty where nothing is."""
    open_ones = [guess for guess in guesses if guess.doubtful]
    return listed(
        (f"{guess.subject}: {guess.taken}? {guess.why}; settle it by {guess.settle}" for guess in open_ones), " | "
    )


def _check_choices(evidence: Evidence, choices: Choices) -> None:
    found = listed(evidence.facts)
    for name in choices.columns:
        if name not in evidence.facts:
            raise InputError(f'found "{name}", expected one of the columns {found}', place="--column")
    for name in choices.units:
        if name not in {*evidence.facts, *choices.columns.values(), "pwm", "time_s"} and not name.endswith("_degC"):
            raise InputError(f'found "{name}", expected one of the columns {found}', place="--unit")
    if choices.runs and choices.runs not in evidence.facts:
        raise InputError(f'found "{choices.runs}", expected one of the columns {found}', place="--runs")


def _by_guess(evidence: Evidence, choices: Choices) -> Decided:
    guesses = _of_text(evidence, choices)
    runs = choices.runs or _runs(evidence)
    if runs:
        confidence = CERTAIN if choices.runs else 0.9
        why = "--runs" if choices.runs else "by its name; each value in rows of its own"
        guesses.append(Guess(runs, "a run for each value", confidence, why))
    _check_wide(evidence, {*choices.columns, runs})
    reserved = {runs} - {""}
    time, said = decide_time(evidence, choices)
    guesses += said
    everything, evidence = evidence, of_timed_rows(evidence, time, in_order=choices.sort)
    try:
        drive, said = decide_input(evidence, choices, reserved | set(time.columns))
    except InputError as error:
        raise _with_more(error, evidence, choices, reserved | set(time.columns), guesses) from None
    guesses += said
    used = {*reserved, *time.columns, drive.column, drive.sign} - {""}
    entries, said = decide_columns(evidence, _by_old_names(evidence, choices), used)
    guesses += said
    _check_mixed(evidence, entries, {*choices.columns, runs, drive.column})
    turns = None if choices.duplicates else extremes_by_turns(evidence, time.columns)
    guesses += [turns] if turns else []
    form = evidence.tables[0].reading
    mapping = Mapping(
        text=TextForm.model_validate(
            {
                "encoding": form.encoding,
                "delimiter": form.delimiter,
                "decimal": form.decimal if form.encoding else "",
                "sheet": choices.sheet,
            }
        ),
        time=time,
        input=drive,
        runs=runs,
        duplicates="mean" if turns else choices.duplicates,  # type: ignore[arg-type]
        sort=choices.sort or bool(choices.series),
        series=choices.series,
        column=entries,
    )
    found = suspicious(evidence, mapping, choices)
    return Decided(everything, mapping, guesses, found, odd_of(evidence, mapping), noted(evidence, mapping))


def _with_more(
    error: InputError, evidence: Evidence, choices: Choices, used: set[str], before: Sequence[Guess]
) -> InputError:
    """Where the input has to be said: ask for all else that has to be at once, a temperature and what is doubtful."""
    if error.place in _OF_OPTIONS:
        return error
    entries, said = decide_columns(evidence, _by_old_names(evidence, choices), {*used, choices.drive} - {""})
    missing = _no_part(entries, evidence) if error.message.startswith(NO_INPUT) else ""
    doubtful = _asked([*before, *said])
    more = "".join(f"; and {text}" for text in (missing, doubtful and f"doubtful: {doubtful}") if text)
    return InputError(f"{error.message}{more}", file=error.file, place=error.place)


def _check_wide(evidence: Evidence, told: Collection[str]) -> None:
    """Refuse a table with a row for each sensor: a column of names that alternate beside one of values."""
    found = names_and_values(evidence, told)
    if found is not None:
        name, said = found
        raise RowForEach(
            f"{_row_for_each(evidence, name)}; expected --series {quoted(said)}, which gives each a column of its own, "
            f"or --column {quoted(f'{name}=')} where it is none",
            said,
            place=f"column {name}",
        )


def _check_mixed(evidence: Evidence, entries: Sequence[Entry], told: Collection[str]) -> None:
    """Refuse a temperature that holds the readings of several sensors, which a column of names tells apart."""
    found = mixed(evidence, entries, told)
    if found is not None:
        name, column, said = found
        raise InputError(
            f"{_row_for_each(evidence, name)}, between which {column} goes to and fro; expected --series "
            f"{quoted(said)}, which gives each columns of its own, or --column {quoted(f'{name}=')} where it is none",
            place=f"column {name}",
        )


def _row_for_each(evidence: Evidence, name: str) -> str:
    names = sorted(set(evidence.facts[name].texts))
    return f"has a row for each of {', '.join(names[:_MOST_NAMES])}{' ..' if len(names) > _MOST_NAMES else ''}"


def _by_old_names(evidence: Evidence, choices: Choices) -> Choices:
    """Units may be given by the run file's name, which warnings speak of: they are looked up by the log's."""
    told = {name: unit for name, unit in choices.units.items() if name not in evidence.facts}
    if not told:
        return choices
    plain = Choices(columns=choices.columns, units={n: u for n, u in choices.units.items() if n in evidence.facts})
    entries, _ = decide_columns(evidence, plain, set())
    olds = {entry.to: entry.source for entry in entries if entry.to}
    units = dict(plain.units)
    for name, unit in told.items():
        if name in ("pwm", "time_s"):
            continue
        if name not in olds:
            raise InputError(f'found "{name}", expected one of the columns {listed(evidence.facts)}', place="--unit")
        units[olds[name]] = unit
    return Choices(columns=choices.columns, units=units)


def _of_text(evidence: Evidence, choices: Choices) -> list[Guess]:
    reading = evidence.tables[0].reading
    guesses = []
    for key, shown in (("encoding", reading.encoding), ("delimiter", shown_delimiter(reading.delimiter))):
        if shown and key in reading.why:
            guesses.append(Guess(key, shown, 0.95, reading.why[key]))
    unsure = [table.reading.unsure for table in evidence.tables]
    if choices.decimal:
        guesses.append(Guess("decimal mark", choices.decimal, CERTAIN, "--decimal"))
    elif unsure and all(unsure):
        guesses.append(Guess("decimal mark", reading.decimal, 0.4, unsure[0], "--decimal , or --decimal ."))
    elif "decimal" in reading.why:
        guesses.append(Guess("decimal mark", reading.decimal, 0.95, reading.why["decimal"]))
    return guesses


def _runs(evidence: Evidence) -> str:
    """A column of texts or whole numbers, each in rows of its own, that says by its name that it parts runs."""
    for name, facts in evidence.facts.items():
        if not RUNS.fullmatch(name.casefold()) or (
            facts.kind != "text" and not (facts.kind == "number" and facts.whole)
        ):
            continue
        values: Sequence[object] = facts.texts if facts.kind == "text" else facts.values.tolist()
        changes = sum(1 for before, after in pairwise(values) if before != after) + 1
        # a number that counts rows is none
        if 1 < len(set(values)) == changes <= min(_MOST_RUNS, len(values) // _LEAST_ROWS):
            return name
    return ""


def _by_mapping(evidence: Evidence, known: Mapping) -> Decided:
    wanted = known.used | {entry.source for entry in known.column}
    missing = sorted(wanted - set(evidence.facts))
    if missing:
        raise InputError(f'has no column "{missing[0]}", which the mapping names; found {listed(evidence.facts)}')
    new = [name for name in evidence.facts if name not in wanted]
    if new:
        raise InputError(
            f'the mapping says nothing of the column "{new[0]}"; expected [[column]] with from = "{new[0]}", and '
            'to = "" to leave it out'
        )
    said = "in the mapping"
    time = ", ".join(known.time.columns) or "time"
    unit = known.time.unit if known.time.columns else f"rows every {known.time.interval_s:g} s"
    guesses = [Guess(time, f"time: {unit}", CERTAIN, said)]
    scale = f"pwm: {known.input.said}" if known.input.column else ""
    guesses.append(Guess(known.input.column or "input", scale or f"pwm = {known.input.counts}", CERTAIN, said))
    for entry in known.column:
        shown = f"{entry.to}, from {entry.unit}" if entry.unit and not entry.to.endswith(entry.unit) else entry.to
        guesses.append(Guess(entry.source, shown or "left out", CERTAIN, said))
    for name in known.used:
        if evidence.facts[name].kind == "text" and name != known.runs:
            raise InputError("holds text, expected numbers or times", place=f"column {name}")
    return Decided(evidence, known, guesses, odd=odd_of(of_timed_rows(evidence, known.time), known))


def _check_entries(mapping: Mapping, evidence: Evidence) -> None:
    """Every name once, each a name that a run file can have; and a temperature among them."""
    given = Counter(entry.to for entry in mapping.column if entry.to)
    for name, count in given.items():
        if count > 1 or name in ("time_s", "pwm"):
            raise InputError(f'"{name}" would be there twice; expected another name', place=f"--column ..={name}")
        if set(name) & set(',"#\n\r') or name != name.strip() or not name.isprintable():
            raise InputError(f"{name!r} cannot be a run file's column", place="--column")
    _check_units(mapping.column)
    missing = _no_part(mapping.column, evidence)
    if missing:
        raise InputError(missing)


def _no_part(entries: Sequence[Entry], evidence: Evidence) -> str:
    """What to say where no column is a part's temperature; nothing where one is."""
    if any(entry.to.endswith("_degC") and entry.to != "ambient_degC" for entry in entries):
        return ""
    rises = [entry.source for entry in entries if entry.to and RISE.search(entry.source)]
    said = f"; {rises[0]} is a rise, to which the ambient has to be added first" if rises else ""
    return f"{NO_PART}{said}; expected --column OLD=NAME_degC{_likeliest(entries, evidence)}"


def _likeliest(entries: Sequence[Entry], evidence: Evidence) -> str:
    """Which columns hold what temperatures may be: numbers that move, from where a log may begin."""
    parts = [entry.source for entry in entries if entry.to != "ambient_degC" and not RISE.search(entry.source)]
    left = [facts for name in parts if (facts := evidence.facts[name]).kind == "number"]
    left = [f for f in left if not (f.whole and (f.steps > 0).all())]  # a number of the row
    left = [f for f in left if f.named[1] is None or f.in_degrees]
    fit = [f for f in left if len(set(f.values.tolist())) > _LEAST_VALUES and f.span[0] > -50.0 and f.span[1] < 2000.0]
    named = ", or ".join(f"--column {quoted(f'{f.name}=winding_degC')} ({spanned(f)})" for f in fit[:_MOST_SHOWN])
    return f", such as {named}" if named else ""


def _check_units(entries: Sequence[Entry]) -> None:
    for entry in entries:
        unit = unit_of(entry.unit) if entry.unit else None
        if entry.unit and unit is None:
            raise InputError(
                f'found the unit "{entry.unit}", expected one that is known', place=f"column {entry.source}"
            )
        if entry.to.endswith("_degC") and unit is not None and unit.quantity != "temperature":
            raise InputError(f"found {entry.unit}, expected degC, degF or K", place=f"column {entry.source}")
