"""The parts of dates in columns of their own (`Year | Month | Day | Hour | Minute | Second`) to timestamps.

Hours, minutes and seconds alone (`h | min | s`) become a time of day, minutes and seconds a number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gen.arrays import FloatArray
from gen.importing.guessing.names import slug
from gen.importing.numbers import parse
from gen.importing.table import Column, Counted, Table, texts_of

_PARTS = (
    ("year", "yyyy", "yr", "jahr", "annee", "anno", "ano", "jaar"),
    ("month", "mon", "mo", "monat", "mois", "mese", "mes", "maand"),
    ("day", "tag", "jour", "giorno", "dia", "dag", "day_of_month"),
    ("hour", "hours", "hr", "hh", "stunde", "heure", "ora", "hora", "uur"),
    ("minute", "minutes", "min", "mm", "minuto"),
    ("second", "seconds", "sec", "ss", "sekunde", "seconde", "secondo", "segundo"),
)
_DATE, _LEAST = 3, 5
"""Parts of a date; and how many there have to be in all: whole minutes need no seconds."""
_OF_A_DAY = ("h", "min", "s")
"""What hours, minutes and seconds are called, too, where all three are there."""
_RISING = 0.95
"""Of the steps of a time of day: it may go over midnight."""
_RANGES = ((1970, 2200), (1, 13), (1, 32), (0, 24), (0, 60), (0, 61))


def with_dates(table: Table) -> Table:
    """Give the parts of dates and times as one column of timestamps; a table without them stays as it is.

    Parameters
    ----------
    table
        As it was read.
    """
    found = [_called(table, words) for words in _PARTS]
    parts = [column for column in found[:_LEAST] if column is not None]
    if not any(found[:_DATE]):
        return _with_time_of_day(table)
    if len(parts) < _LEAST:
        return table
    parts += [column for column in found[_LEAST:] if column is not None]
    numbers = [_numbers(column, table.reading.decimal) for column in parts]
    if not all(_fits(values, low, high) for values, (low, high) in zip(numbers, _RANGES, strict=False)):
        return table
    stamps = [_stamp(row) for row in zip(*(values.tolist() for values in numbers), strict=True)]
    names = [column.name for column in parts]
    told = Counted(f"timestamp put together from {', '.join(names)}", len(stamps), f"column {names[0]}")
    left = [column for column in table.columns if column.name not in names]
    return replace(table, columns=[Column("timestamp", stamps), *left], counted=(*table.counted, told))


def _with_time_of_day(table: Table) -> Table:
    """Give hours, minutes and seconds that go on as one column, or minutes and seconds; else the table as it is."""
    found = [_called(table, (*words, short)) for words, short in zip(_PARTS[_DATE:], _OF_A_DAY, strict=True)]
    parts = [column for column in found if column is not None]
    if len(parts) < len(_OF_A_DAY):
        return _with_minutes(table, *parts) if found[0] is None and len(parts) == len(_OF_A_DAY) - 1 else table
    hour, minute, second = (_numbers(column, table.reading.decimal) for column in parts)
    fits = zip((hour, minute, second), _RANGES[_DATE:], strict=True)
    if not all(_fits(values, low, high) for values, (low, high) in fits):
        return table
    steps = np.diff(3600.0 * hour + 60.0 * minute + second)
    if not steps.size or (steps > 0.0).mean() < _RISING:
        return table
    rows = zip(hour.tolist(), minute.tolist(), second.tolist(), strict=True)
    clock = [f"{h:02.0f}:{m:02.0f}:{s:09.6f}" for h, m, s in rows]
    names = [column.name for column in parts]
    told = Counted(f"time of day put together from {', '.join(names)}", len(clock), f"column {names[0]}")
    left = [column for column in table.columns if column.name not in names]
    return replace(table, columns=[Column("clock", clock), *left], counted=(*table.counted, told))


def _with_minutes(table: Table, minutes: Column, seconds: Column) -> Table:
    """Give minutes and seconds that go on as one column of seconds; else the table as it is."""
    minute, second = (_numbers(column, table.reading.decimal) for column in (minutes, seconds))
    passed = 60.0 * minute + second
    whole = bool((minute == np.floor(minute)).all()) and _fits(second, *_RANGES[-1])
    if not whole or passed.size < _LEAST or not (np.diff(passed) > 0.0).mean() >= _RISING or minute[0] == minute[-1]:
        return table
    mark = table.reading.decimal or "."
    told = Counted(f"time put together from {minutes.name}, {seconds.name}", passed.size, f"column {minutes.name}")
    left = [column for column in table.columns if column.name not in (minutes.name, seconds.name)]
    texts = [f"{value:.6f}".replace(".", mark) for value in passed.tolist()]
    return replace(table, columns=[Column("time", texts, "s"), *left], counted=(*table.counted, told))


def _called(table: Table, words: Sequence[str]) -> Column | None:
    """The first column that is called by one of some words."""
    return next((column for column in table.columns if slug(column.name).casefold() in words), None)


def _numbers(column: Column, mark: str) -> FloatArray:
    return parse(texts_of(column), mark or ".").values


def _fits(values: FloatArray, low: int, high: int) -> bool:
    known = values[np.isfinite(values)]
    whole = high >= _RANGES[-1][1] or bool((known == np.floor(known)).all())
    return bool(known.size == values.size and whole and (known >= low).all() and (known < high).all())


def _stamp(row: Sequence[float]) -> str:
    year, month, day, hour, minute, *rest = row
    second = rest[0] if rest else 0.0
    return f"{year:04.0f}-{month:02.0f}-{day:02.0f}T{hour:02.0f}:{minute:02.0f}:{second:09.6f}"
