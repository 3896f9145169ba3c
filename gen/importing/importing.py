"""Logs to run files: read, decide, convert, write all or nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from gen.errors import InputError
from gen.files import check_writable, scratch, write_text
from gen.importing.convert import Splitting, convert, with_comments
from gen.importing.converted import Converted
from gen.importing.guessing.decide import NO_PART, Decided, RowForEach, decide, doubts
from gen.importing.guessing.guess_input import NO_INPUT
from gen.importing.guessing.guesses import Choices, quoted
from gen.importing.guessing.own_times import joined
from gen.importing.guessing.series import spread_out
from gen.importing.guessing.sheets import choice_of_sheets, logs_among
from gen.importing.guessing.times.compact_times import with_parted_times
from gen.importing.guessing.times.date_parts import with_dates
from gen.importing.guessing.times.day_times import with_days
from gen.importing.guessing.times.fractions import with_fractions
from gen.importing.guessing.times.halves import with_halves
from gen.importing.guessing.times.header_zones import with_zones
from gen.importing.mapping import Mapping, read_mapping
from gen.importing.provenance import commented_mapping, comments_of
from gen.importing.reading.sources import read_tables
from gen.importing.switches import switched
from gen.importing.table import Reading, Table
from gen.interruption import interruption
from gen.runs import Run, write_run


@dataclass(frozen=True)
class Plan:
    """What would be written, before anything is.

    Parameters
    ----------
    decided
        Of the tables of each header.
    known
        Whether a mapping file said it.
    """

    decided: Sequence[Decided]
    known: bool

    def check(self) -> None:
        """Refuse what is doubtful.

        Raises
        ------
        InputError
            With the file, and what would settle it.
        """
        for entry in self.decided:
            fault = doubts(entry)
            if fault is not None:
                raise fault


@dataclass(frozen=True)
class Written:
    """What was written.

    Parameters
    ----------
    files
        The run files.
    converted
        What was found in each table.
    mapping
        The mapping file, if it was written.
    """

    files: Sequence[Path]
    rows: Sequence[int]
    converted: Sequence[Converted]
    mapping: Path | None


def plan(files: Sequence[Path], choices: Choices, mapping: Path | None, progress: Callable[[str], None]) -> Plan:
    """Read logs and decide what their columns are.

    Parameters
    ----------
    files
        The logs.
    choices
        What the user says.
    mapping
        The mapping file; read if it exists.
    progress
        Told what is being done.

    Raises
    ------
    InputError
        With file and place.
    """
    known = read_mapping(mapping) if mapping is not None and mapping.exists() else None
    if known is not None:
        known = _with_options(known, choices)
    text = known.text if known is not None else None
    given = Reading(text.encoding, text.delimiter, text.decimal) if text is not None else Reading()
    given = replace(
        given, decimal=choices.decimal or given.decimal, sheet=choices.sheet or (text.sheet if text else "")
    )
    series = known.series if known is not None else choices.series
    tables: list[Table] = []
    for file in files:
        progress(f"reading {file.name}")
        tables += [_with_marks(table) for table in read_tables(file, given)]
    if series:
        progress("a column for each name")
        tables = [spread_out(table, replace(choices, series=series)) for table in tables]
    names = {choices.runs, known.runs if known is not None else ""}
    drive = known.input.column if known is not None else choices.drive
    tables = [switched(table, names, drive) for table in tables]
    progress("deciding")
    tables = logs_among(tables, choices, known)
    groups: dict[tuple[str, ...], list[Table]] = {}
    for table in tables:
        groups.setdefault(tuple(table.names), []).append(table)
    if mapping is not None and known is None and len(groups) > 1:
        first, second = (group[0] for group in list(groups.values())[:2])
        raise InputError(
            f"has other columns than {first.label}; expected the same in all files of one mapping"
            f"{choice_of_sheets(tables, second.file)}",
            file=second.label,
        )
    return Plan([_decided(group, tables, choices, known) for group in groups.values()], known is not None)


def _with_marks(table: Table) -> Table:
    """A table whose times are written as all others write them."""
    marked = with_zones(with_halves(with_dates(with_days(with_parted_times(table)))))
    return joined(with_fractions(marked))


def _decided(group: Sequence[Table], tables: Sequence[Table], choices: Choices, known: Mapping | None) -> Decided:
    """What one header's tables are; where that fails, with what other tables have to do with it."""
    try:
        return decide(group, choices, known)
    except RowForEach as error:
        raise InputError(
            f"{error.message}{_asked_then(group, choices, error.series)}", file=error.file, place=error.place
        ) from None
    except InputError as error:
        said = error.message
        if any(table.names != group[0].names and table.file != group[0].file for table in tables) and said.startswith(
            (NO_INPUT, NO_PART)
        ):
            said = (
                f"{said}; files with other columns are imported for themselves: what stands in another one has to be "
                "put beside it first, by times of one clock"
            )
        unsure = group[0].reading.unsure
        if unsure and not choices.decimal and said.startswith((NO_INPUT, NO_PART)):
            said += f"; the decimal mark is doubtful ({unsure}): --decimal , or --decimal ."
        said += choice_of_sheets(tables, group[0].file)
        raise InputError(said, file=error.file, place=error.place) from None


def _asked_then(group: Sequence[Table], choices: Choices, series: str) -> str:
    """What would be asked for next, were a column made of each name: all that has to be said stands in one line."""
    told = replace(choices, series=series)
    try:
        spread = switched(spread_out(group[0], told), {choices.runs}, choices.drive)
        fault = doubts(decide([spread], told, None))
    except InputError as error:
        fault = error
    if fault is None:
        return ""
    place = f"{fault.place}: " if fault.place and not fault.place.startswith("line") else ""
    return f". With --series {quoted(series)}: {place}{fault.message}"


def _with_options(known: Mapping, choices: Choices) -> Mapping:
    """What a mapping file says is corrected in the file: two places for one thing would contradict each other."""
    told = [
        option
        for option, value in (
            ("--time", choices.time),
            ("--input", choices.drive),
            ("--full-scale", choices.full_scale),
            ("--rest", choices.rest is not None),
            ("--drives", choices.machine),
            ("--column", choices.columns),
            ("--unit", choices.units),
            ("--decimal", choices.decimal),
            ("--runs", choices.runs),
            ("--series", choices.series),
            ("--zone", choices.zone),
            ("--sheet", choices.sheet),
        )
        if value
    ]
    if told:
        raise InputError("the mapping file exists and says it; expected it to be corrected there", place=told[0])
    if choices.duplicates:
        known = known.model_copy(update={"duplicates": choices.duplicates})
    return known.model_copy(update={"sort": True}) if choices.sort else known


def write(
    planned: Plan,
    out: Path,
    *,
    splitting: Splitting,
    mapping: Path | None,
    overwrite: bool,
    progress: Callable[[str], None],
) -> Written:
    """Convert all tables and write all runs, or nothing.

    Parameters
    ----------
    planned
        From :func:`plan`, checked.
    out
        The folder; made where it is missing.
    splitting
        Where to split.
    mapping
        The mapping file to write, if it is not there.
    overwrite
        Whether run files of the same names may be replaced.
    progress
        Told what is being done.

    Raises
    ------
    InputError
        With the file.
    """
    runs: dict[str, Run] = {}
    converted: list[Converted] = []
    for decided in planned.decided:
        for index, table in enumerate(decided.evidence.tables):
            progress(f"converting {table.label}")
            try:
                made = convert(decided.evidence, index, decided.mapping, splitting, decided.odd)
            except InputError as error:
                raise InputError(error.message, file=table.label, place=error.place) from None
            converted.append(made)
            for name, run in made.runs:
                runs[_fresh(_stem(table, name), runs)] = with_comments(run, comments_of(made, decided.mapping))
    if mapping is not None and not mapping.exists():
        written, text = mapping, commented_mapping(planned.decided[0])
    else:
        written, text = None, ""
    progress("writing")
    _check_targets([out / name for name in runs], out, overwrite, {made.table.file.resolve() for made in converted})
    if written is not None:
        check_writable(written)
    files = _write_all(runs, out, (written, text))
    return Written(files, [run.time_s.size for run in runs.values()], converted, written)


def _stem(table: Table, name: str) -> str:
    stem = table.file.name.removesuffix(".gz")
    stem = stem.rpartition(".")[0] or stem
    part = "".join(c if c.isalnum() or c in "-_." else "_" for c in table.part)
    return "_".join(filter(None, (stem, part, name)))


def _fresh(stem: str, taken: dict[str, Run]) -> str:
    """A file's name unlike those taken, also where capitals do not count."""
    folded = {name.casefold() for name in taken}
    names = (f"{stem}.csv", *(f"{stem}_{i}.csv" for i in range(2, len(folded) + 3)))
    return next(name for name in names if name.casefold() not in folded)


def _write_all(runs: dict[str, Run], out: Path, mapping: tuple[Path | None, str]) -> list[Path]:
    """Write beside, then rename: a folder that is new at once, into one that exists file by file."""
    folder = out.resolve()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with scratch(f".{folder.name}.", folder.parent) as staging:
            new = staging / "new"
            new.mkdir()
            for name, run in runs.items():
                write_run(new / name, run)
            with interruption():  # a moment, in which nothing may be cut off half-way
                _put(new, folder, list(runs), mapping)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", file=str(out)) from error
    return [out / name for name in runs]


def _put(new: Path, folder: Path, names: Sequence[str], mapping: tuple[Path | None, str]) -> None:
    """Put finished files where they belong, and the mapping beside them; no mapping where that fails."""
    try:
        if mapping[0] is not None:
            write_text(mapping[0], mapping[1])
        if folder.exists():
            for name in names:
                (new / name).replace(folder / name)
        else:
            new.rename(folder)
    except BaseException:
        if mapping[0] is not None:
            mapping[0].unlink(missing_ok=True)  # it was not there before
        raise


def _check_targets(targets: Sequence[Path], out: Path, overwrite: bool, read: set[Path]) -> None:
    if out.exists() and not out.is_dir():
        raise InputError("exists and is no folder; choose another --out", file=str(out))
    for target in targets:
        if target.resolve() in read:
            raise InputError("is read by this command and would be overwritten; choose another --out", file=str(target))
        if target.exists() and not overwrite:
            raise InputError("exists; expected another --out, or --overwrite", file=str(target))
