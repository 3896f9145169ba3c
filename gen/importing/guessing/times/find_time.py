"""Which of a log's columns is the time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gen.errors import InputError
from gen.importing import clock
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import Choices, quoted
from gen.importing.guessing.names import BUSY, CHARGED, LATE, OF_A_STEP, TIME, WORKED
from gen.importing.guessing.times.time_unit import EARLIEST_S, epoch_of
from gen.importing.listing import listed
from gen.importing.units import TIME as TIME_QUANTITY
from gen.importing.units import unit_of

FORMS = "times such as 2026-04-03T23:30:00, 3.4.2026 23:30, 3 Apr 2026 23:30:00, 23:30:00, 1h30m00s, or numbers"
EITHER = 0.5
"""How sure one of two columns is the time."""
_PLAIN = {"t", "ts", "s", "time", "times", "zeit", "timestamp", "zeitstempel", "elapsed", "seconds", "millis", "ms"}
_PLAIN |= {"stats"}
"""Names of a time that need nothing beside them; the last is what Klipper counts its lines by."""
_RATIOS = tuple(x for r in (1.0, 60.0, 3600.0, 1e3, 1e6, 1e9) for x in (r, 1.0 / r))
_SAME_LENGTH = 0.05
_EVEN = 0.8
"""Of the steps."""
_MOST_BACK = 0.2
"""Of the steps of a time: where more of them go back, rows are not in its order."""
_MORE = 1.2
"""Rows with one time, of those with another."""
_COARSE_S = 2.0
"""By which timestamps of whole seconds may be off at both ends."""


@dataclass(frozen=True)
class Found:
    """The columns that are the time, how sure that is, and why."""

    names: list[str]
    confidence: float
    why: str


class _Candidates:
    """The columns that nobody gave another name, by what they hold."""

    def __init__(self, evidence: Evidence, choices: Choices) -> None:
        named = choices.columns
        self.facts = [entry for name, entry in evidence.facts.items() if named.get(name, "time_s") == "time_s"]
        written = self.of("instant", "clock", "minutes")
        self.rising = _of_most_rows([entry for entry in self.of("number") if _rises(entry)], written)
        self.instants = _of_most_rows(self.of("instant"), written)
        self.clocks = self.of("clock", "minutes")

    def of(self, *kinds: str) -> list[Facts]:
        return [entry for entry in self.facts if entry.kind in kinds]


def find_time(evidence: Evidence, choices: Choices) -> Found:
    """Find the time: what says most of itself comes first.

    Parameters
    ----------
    evidence
        The columns.
    choices
        What the user says: columns with other names are no time.

    Raises
    ------
    InputError
        Without a file name: no column can be the time.
    """
    candidates = _Candidates(evidence, choices)
    for finder in _FINDERS:
        found = finder(candidates)
        if found is not None:
            return found
    raise _refusal(evidence, candidates)


def _with_unit(candidates: _Candidates) -> Found | None:
    """A number that rises, and says by its name and unit that it is a time."""
    instants = candidates.instants
    known = [entry for entry in candidates.rising if _timed(entry) and entry.named[1] is not None]
    known = [entry for entry in known if not any(_contradicts(entry, instant) for instant in instants)]
    known = [entry for entry in known if not (instants and WORKED.search(entry.named[0]))]
    known = [entry for entry in known if not OF_A_STEP.search(entry.named[0])] or known
    if not known:
        return None
    best = next((entry for entry in known if TIME.fullmatch(entry.named[0].casefold())), known[0])
    return Found([best.name], 0.95, "by its name and unit; it rises")


def _timestamps(candidates: _Candidates) -> Found | None:
    """Timestamps; not those of when a row was sent, where another column says when it was taken."""
    rising, instants = candidates.rising, candidates.instants
    taken = [entry for entry in rising if _named_so(entry) and not LATE.search(entry.name) and epoch_of(entry)]
    if not instants or (taken and all(LATE.search(entry.name) for entry in instants)):
        return None
    best = min(instants, key=lambda entry: (_stands(entry), bool(LATE.search(entry.name))))
    return Found([best.name], 0.95, f"timestamps such as {example(best)}")


def _date_and_time(candidates: _Candidates) -> Found | None:
    dates, clocks = candidates.of("date"), candidates.clocks
    if not (dates and clocks):
        return None
    return Found([dates[0].name, clocks[0].name], 0.95, f"a date and a time: {example(dates[0])}{_parted(clocks[0])}")


def _named(candidates: _Candidates) -> Found | None:
    """Of numbers that rise and are called a time the first; doubtful where another (a processor's) runs otherwise."""
    named = [entry for entry in candidates.rising if _named_so(entry) and not entry.in_degrees]
    named.sort(key=lambda entry: entry.named[0] == "T")  # beside `t`, a temperature that rises evenly
    if all(BUSY.search(entry.named[0]) for entry in named):
        return None
    plain = [entry for entry in named if entry.named[0].casefold() in _PLAIN]
    if plain or len(named) == 1:
        return Found([(plain or named)[0].name], 0.85, "by its name; it rises")
    first, *others = named
    other = next((entry for entry in others if not _alike(first, entry)), None)
    if other is None:
        return Found([first.name], 0.85, "by its name; it rises")
    lasts = ", ".join(f"{entry.name} by {entry.span[1] - entry.span[0]:g}" for entry in (first, other))
    return Found([first.name], EITHER, f"{lasts}: either may be the time")


def _times_of_day(candidates: _Candidates) -> Found | None:
    if not candidates.clocks:
        return None
    first = candidates.clocks[0]
    return Found([first.name], 0.85, f"times such as {example(first)}{_parted(first)}")


def _unnamed(candidates: _Candidates) -> Found | None:
    """The first number that rises, in files without a header."""
    unnamed = [entry for entry in candidates.rising if entry.name.startswith("column_")]
    if not unnamed:
        return None
    since = [entry for entry in unnamed if epoch_of(entry)]
    return Found([(since or unnamed)[0].name], 0.7, "" if since else "the first column that rises all the way")


_FINDERS: tuple[Callable[[_Candidates], Found | None], ...] = (
    _with_unit,
    _timestamps,
    _date_and_time,
    _named,
    _times_of_day,
    _unnamed,
)


def _refusal(evidence: Evidence, candidates: _Candidates) -> InputError:
    """Why no column is the time, and what to say then."""
    words = next((entry for entry in candidates.of("text") if _called_so(entry)), None)
    if words is not None:
        return InputError(
            f'found "{example(words)}", expected {FORMS}; or --time SECONDS for the interval of the rows',
            place=first_cell(evidence, words),
        )
    stands = next((entry for entry in candidates.of("number") if _called_so(entry)), None)
    if stands is not None and not stands.in_degrees and stands.span[1] >= EARLIEST_S:
        back = np.flatnonzero(stands.steps < 0)
        if back.size > _MOST_BACK * stands.steps.size:
            return InputError(
                f"goes back {back.size} times in {stands.values.size} rows; expected --time {quoted(stands.name)} "
                "--sort, which puts rows in the order of their times, or another --time COLUMN",
                place=first_cell(evidence, stands),
            )
        return InputError(
            f"does not go on ({stands.span[0]:g}..{stands.span[1]:g}): were its last digits lost, as in a spreadsheet? "
            "expected --time SECONDS for the interval of the rows, or another --time COLUMN",
            place=first_cell(evidence, stands),
        )
    table = evidence.tables[0]
    return InputError(
        f"no column is a time among {listed(evidence.facts)}; expected --time COLUMN, or --time SECONDS for the "
        f"interval of its rows{f'; better, {table.untimed}' if table.untimed else ''}",
        place=table.place(0),
    )


def first_cell(evidence: Evidence, entry: Facts) -> str:
    """Where a column holds something first."""
    cells = entry.columns[0].cells
    row = next((k for k, cell in enumerate(cells) if cell), 0) if isinstance(cells, list) else 0
    return evidence.tables[0].place(row, entry.name)


def example(entry: Facts) -> str:
    """Give its first cell that holds something, as it is written."""
    cells = entry.columns[0].cells
    return next((cell for cell in cells if cell), "") if isinstance(cells, list) else str(cells[0])[:23]


def _length(entry: Facts) -> float:
    low, high = np.percentile(entry.values, (5, 95))  # the first row may be stale
    return float(high - low)


def _alike(one: Facts, other: Facts) -> bool:
    """Whether two columns last equally long, in whatever units."""
    ratio = _length(one) / max(_length(other), 1e-12)
    return any(abs(ratio * scale - 1.0) < _SAME_LENGTH for scale in _RATIOS)


def _of_most_rows(entries: Sequence[Facts], written: Sequence[Facts]) -> list[Facts]:
    """Those beside which no other time stands in many more rows: lines have one, of which some say how long it runs."""
    most = max(map(_filled, written), default=0)
    return [entry for entry in entries if most <= _MORE * _filled(entry)]


def _filled(entry: Facts) -> int:
    """Rows of the first table in which a column holds something."""
    cells = entry.columns[0].cells
    return sum(1 for cell in cells if cell) if isinstance(cells, list) else len(cells)


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
