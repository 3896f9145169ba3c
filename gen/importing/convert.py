"""Tables and a mapping to runs; whatever is no sample is counted, with the place of the first."""

from __future__ import annotations

from collections.abc import Mapping as Named
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.errors import InputError
from gen.importing import sequence
from gen.importing.converted import Converted, count_units_apart
from gen.importing.drive import drive_of
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.listing import listed
from gen.importing.local import goes_ahead_an_hour, told_reset
from gen.importing.mapping import DATED, Entry, Mapping
from gen.importing.means import means
from gen.importing.overflow import overflows
from gen.importing.table import Cells, Counted
from gen.importing.taken import suspect, warn_of_readings
from gen.importing.timing import ticks_of, timed
from gen.importing.units import split_name, unit_of
from gen.runs import AMBIENT, Run

_MOST_REPEATED = 0.1
_FEW_REPEATED = 5
_MOST_HELD = 0.05
"""Of the rows, up to which an input may be missing without a word, where it is never 0."""
_MOST_UNTIMED = 0.5
_MOST_BACKWARD = 0.5
"""Of the rows: a clock that begins anew at more of them runs backward."""
_CELSIUS = (-273.15, 5000.0)
_HIGHEST = 1e12
_DIGITS = 9
_DATED_ONLY = " (which needs dates with the times)"


@dataclass(frozen=True)
class Splitting:
    """Where a log becomes several runs.

    Parameters
    ----------
    at_all
        Whether at gaps and where the clock begins anew.
    gap_s
        From which interval on; None: ten usual intervals, and a minute at least.
    """

    at_all: bool = False
    gap_s: float | None = None


def convert(
    evidence: Evidence, index: int, mapping: Mapping, splitting: Splitting, odd: Named[float, str]
) -> Converted:
    """Make runs of one table.

    Parameters
    ----------
    evidence, index
        The table among those of its header.
    mapping
        What its columns are.
    splitting
        Where to split.
    odd
        Numbers in the input's column that are none of the input, and what they are.

    Raises
    ------
    InputError
        Without a file name: too much is no sample, the clock begins anew, the input exceeds its scale.
    """
    if mapping.sort:
        evidence, index = _in_order(evidence, index, mapping), 0
    table = evidence.tables[index]
    made = Converted(table, counted=list(table.counted))
    time, begun = timed(evidence, index, mapping.time, made)
    drive = drive_of(evidence, index, mapping.input, time, odd, made)
    labels = evidence.facts[mapping.runs].columns[index].cells if mapping.runs else None
    series = _labelled(np.arange(table.rows), labels)
    known = np.zeros(table.rows, dtype=bool)
    for _, own in series:
        known[own] = _known_from_the_first(drive[own])
    says = _saying(evidence, index, mapping)
    made.count("row with a time and nothing else, left out", np.flatnonzero(np.isfinite(time) & known & ~says), "")
    usable = np.isfinite(time) & known & says
    _left_out(usable, known, time, drive, mapping, made)
    channels = {
        entry.to: _channel(evidence.facts[entry.source], index, entry, mapping, made)
        for entry in mapping.column
        if entry.to
    }
    ticks = ticks_of(evidence, index, mapping)
    for label, own in series:
        stretch = own[usable[own]]
        if not stretch.size:
            continue
        # rows that are counted and not timed are counted anew in each run
        begin = time[stretch[0]] if mapping.time.interval_s is not None and labels is not None else 0.0
        order = sequence.order(time[stretch] - begin, stretch, mapping.duplicates or "first", ticks)
        _report(order, stretch, mapping, made)
        _spring(order, ticks, mapping, made)
        if mapping.duplicates == "mean" and order.repeated.size:
            drive = means(drive, order.kept, order.repeated)
            channels = {to: means(values, order.kept, order.repeated) for to, values in channels.items()}
        held = _held(drive, own)
        pieces = _pieces(order, splitting, ticks, made)
        for number, (first, end) in enumerate(pieces, start=1):
            kept = order.kept[first:end]
            name = "_".join(filter(None, (label, str(number) if len(pieces) > 1 else "")))
            run = _run(kept, order.time_s[first:end], held, channels, begun)
            made.runs.append((name, run))
    _check_told(made, mapping)
    warn_of_readings(channels, time, made)
    suspect(made, {entry.to: entry.unit for entry in mapping.column})
    return made


def _check_told(made: Converted, mapping: Mapping) -> None:
    """Refuse rows of which none tells a temperature: their time and their input are other rows' than the readings'."""
    names = [entry.source for entry in mapping.column if _is_part(entry.to)]
    if names and not any(np.isfinite(values).any() for _, run in made.runs for values in run.temps.values()):
        raise InputError(
            f"no row with a time and an input has a reading of {listed(names)}; "
            "expected another --time COLUMN, or one file of rows that have all of them",
            place=f"column {names[0]}",
        )


def _in_order(evidence: Evidence, index: int, mapping: Mapping) -> Evidence:
    """One table with its rows in the order of their times; those without a time behind all others."""
    table = evidence.tables[index]
    time, _ = timed(evidence, index, mapping.time, Converted(table))
    rows = np.argsort(time, kind="stable")
    moved = int((np.diff(rows) < 0).sum())
    if not moved:
        return Evidence([table])
    first = table.place(int(np.argmax(np.diff(rows) < 0)) + 1)
    counted = (*table.counted, Counted("place at which rows were put in the order of their times", moved, first))
    return Evidence([replace(table.of_rows(rows), counted=counted)])


def _saying(evidence: Evidence, index: int, mapping: Mapping) -> BoolArray:
    """Rows that hold something beside their time and their own number: events of a logger are rows as well."""
    names = [entry.source for entry in mapping.column if entry.to]
    says = np.full(evidence.tables[index].rows, bool(mapping.series))  # where a row is a reading of something
    for name in filter(None, (mapping.input.column, *names)):
        parsed = evidence.facts[name].parsed[index]
        steps = np.diff(parsed.values[np.isfinite(parsed.values)])
        counts_rows = steps.size and (steps > 0).all() and evidence.facts[name].whole
        if not counts_rows or name == mapping.input.column:
            says |= ~parsed.empty
    return says


def _known_from_the_first(drive: FloatArray) -> BoolArray:
    """Rows from the first known input on: it is held until the next."""
    known = np.isfinite(drive)
    return np.logical_or.accumulate(known)


def _held(drive: FloatArray, own: IntArray) -> FloatArray:
    """The input of one series where it is missing: that of its row before, of no other's; NaN before its first."""
    held = np.full(drive.size, np.nan)
    last = np.maximum.accumulate(np.where(np.isfinite(drive[own]), np.arange(own.size), -1))
    held[own] = np.where(last >= 0, drive[own][last], np.nan)
    return held


def _left_out(
    usable: BoolArray,
    known: BoolArray,
    time: FloatArray,
    drive: FloatArray,
    mapping: Mapping,
    made: Converted,
) -> None:
    missing = ~np.isfinite(drive)
    made.count("row before the first input, left out", np.flatnonzero(~known), mapping.input.column)
    held = np.flatnonzero(missing & usable)
    made.count("missing input, held from the row before", held, mapping.input.column)
    if held.size > _MOST_HELD * usable.sum() and not np.any(drive == 0.0):
        made.warnings.append(
            f"{made.table.label}: {mapping.input.column}: {held.size} of {int(usable.sum())} rows have none, and no "
            "row has 0: the last one is held; if an empty field means off, put 0 there first"
        )
    if usable.sum() < _MOST_UNTIMED * usable.size:
        what = ", ".join(mapping.time.columns) if np.isfinite(time).mean() < _MOST_UNTIMED else mapping.input.column
        raise InputError(
            f"{int((~usable).sum())} of {usable.size} rows have no time or no input; expected both in most",
            place=made.table.place(int(np.argmin(usable)), what),
        )


def _channel(facts: Facts, index: int, entry: Entry, mapping: Mapping, made: Converted) -> FloatArray:
    unit = unit_of(entry.unit) if entry.unit else None
    told = unit or split_name(entry.to)[1]  # what is kept as it is has its unit in its name
    parsed = facts.parsed_in(index, told)
    values = parsed.values.copy()
    if told is not None:
        count_units_apart(facts, parsed, told.name, made)
    made.count("text in a number's field, left empty", np.flatnonzero(parsed.text), facts.name)
    made.count('word for "no number", left empty', np.flatnonzero(parsed.words), facts.name)
    temperature = entry.to.endswith("_degC")
    kept = mapping.overflow == "keep"
    own = (unit.name if unit is not None else "degC") if temperature else ""
    for rows, value, words in overflows(values, temperature=own):
        made.count(f"{value:g} ({words}), {'kept' if kept else 'left empty'}", rows, facts.name)
        if not kept:
            values[rows] = np.nan
    if unit is not None and (unit.scale, unit.offset) != (1.0, 0.0):
        values = np.round(values * unit.scale + unit.offset, _DIGITS)
    low, high = _CELSIUS if temperature else (-_HIGHEST, _HIGHEST)
    beyond = np.flatnonzero((values < low) | (values > high))
    made.count(f"value outside of {low:g}..{high:g}, left empty", beyond, facts.name)
    values[beyond] = np.nan
    return np.asarray(values)


def _labelled(rows: IntArray, labels: Cells | None) -> list[tuple[str, IntArray]]:
    """Rows of each run by its label, in order of appearance."""
    if labels is None:
        return [("", rows)]
    found: dict[str, list[int]] = {}
    for row in rows.tolist():
        found.setdefault(_label(labels[row]), []).append(row)
    return [(label, np.array(stretch, dtype=np.int64)) for label, stretch in found.items()]


def _label(value: object) -> str:
    text = f"{value:g}" if isinstance(value, float) else str(value).strip()
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in text) or "none"


def _report(order: sequence.Order, stretch: IntArray, mapping: Mapping, made: Converted) -> None:
    """Count what is out of order; refuse where a rule would have to choose among many rows."""
    column = ", ".join(mapping.time.columns)
    if order.repeated.size > max(_MOST_REPEATED * stretch.size, _FEW_REPEATED) and not mapping.duplicates:
        raise InputError(
            f"{order.repeated.size} of {stretch.size} rows repeat the time of the row before; expected --duplicates "
            "spread (a clock that is too coarse), mean, first or last; or --runs COLUMN, where several series share "
            "the file",
            place=made.table.place(int(order.repeated[0]), column),
        )
    astray = np.sort(np.concatenate([order.late, order.jumped]))
    if astray.size > max(_MOST_REPEATED * stretch.size, _FEW_REPEATED):
        raise InputError(
            f"{astray.size} of {stretch.size} rows are not in the order of their times; expected --sort, which puts "
            "them there",
            place=made.table.place(int(astray[0]), column),
        )
    which = {"last": "the last row", "mean": "the mean of its rows"}.get(mapping.duplicates, "the first row")
    made.count(f"repeated time, {which} taken", order.repeated, column)
    made.count("time before that of an earlier row, left out", order.late, column)
    made.count("time far ahead in one row, left out", order.jumped, column)
    for row, name in order.wraps:
        made.count(f"{name} ran over, counted on", np.array([row]), column)


def _spring(order: sequence.Order, ticks: sequence.Ticks, mapping: Mapping, made: Converted) -> None:
    """Say where local times go ahead by an hour once: it may be that no hour passed."""
    ahead = goes_ahead_an_hour(order.time_s) if ticks.local else np.zeros(0, dtype=np.int64)
    if ahead.size == 1 and not order.resets.size:
        place = made.table.place(int(order.kept[ahead[0]]), ", ".join(mapping.time.columns))
        made.warnings.append(
            f"{made.table.label}: {place}: the clock goes ahead by an hour, as where summer time begins; if so: --zone "
            f"with the name of its time zone{_DATED_ONLY if mapping.time.unit not in DATED else ''}"
        )


def _pieces(
    order: sequence.Order, splitting: Splitting, ticks: sequence.Ticks, made: Converted
) -> list[tuple[int, int]]:
    """Begin and end of each run among the rows kept."""
    length = splitting.gap_s if splitting.gap_s is not None else sequence.gap_length(order.time_s)
    wide = sequence.gaps(order.time_s, order.resets, length)
    if order.resets.size > _MOST_BACKWARD * order.time_s.size:
        raise InputError(
            "rows stand in the order of falling times; expected --sort, which turns them round",
            place=made.table.place(int(order.kept[order.resets[0]])),
        )
    if order.resets.size and not splitting.at_all:
        at = int(order.resets[0])
        raise InputError(
            told_reset(order.time_s, at, local=ticks.local, single=order.resets.size == 1),
            place=made.table.place(int(order.kept[at])),
        )
    made.count("clock that begins anew: a run of its own", order.kept[order.resets])
    what = "a run of its own" if splitting.at_all else "no rows for longer, the input held"
    made.count(f"gap of more than {length:g} s: {what}", order.kept[wide])
    at_all = np.union1d(order.resets, wide) if splitting.at_all else np.zeros(0, dtype=np.int64)
    edges = [0, *at_all.tolist(), order.kept.size]
    return [(int(begin), int(end)) for begin, end in pairwise(edges) if end > begin]


def _run(kept: IntArray, time: FloatArray, drive: FloatArray, channels: dict[str, FloatArray], begun: str) -> Run:
    held = drive[kept]
    temps = {name.removesuffix("_degC"): values[kept] for name, values in channels.items() if _is_part(name)}
    extras = {name: values[kept] for name, values in channels.items() if not _is_part(name) and name != AMBIENT}
    comments = {"started": begun} if begun else {}
    return Run(
        time_s=time,
        pwm=np.asarray(np.sign(held) * np.floor(np.abs(held) + 0.5)).astype(np.int64),
        temps=temps,
        ambient=channels[AMBIENT][kept] if AMBIENT in channels else None,
        extras=extras,
        comments=comments,
    )


def _is_part(name: str) -> bool:
    return name.endswith("_degC") and name != AMBIENT


def with_comments(run: Run, comments: dict[str, str]) -> Run:
    """A run with further comments before its own."""
    return replace(run, comments={**comments, **run.comments})
