"""Headers further down in a file: a logger that began anew writes its own, whose columns may be others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from gen.errors import InputError
from gen.importing.guessing.names import DUTY, PWM, TIME, is_thermal
from gen.importing.listing import listed
from gen.importing.reading.rows.kinds import is_data, is_head, is_number, padded
from gen.importing.reading.rows.named import names_above
from gen.importing.units import split_name

_NEAR = 5
"""Lines from a header to its first row, at most."""
_LEAST_NAMES = 2
_SHARED = 0.5
"""Of its names, by which a line is a header as the one above."""
_BY_NAMES = "header with {}, by which the rows below it are taken"

Key = tuple[str, str]
"""Name and unit of a column; columns without a name are numbered in the place of the unit."""


@dataclass(frozen=True)
class _Head:
    """Lines that name columns: the first of them, behind the last, cells of the row below, and what each column is."""

    begin: int
    end: int
    width: int
    names: list[str]
    units: list[str]

    @property
    def keys(self) -> list[Key]:
        """Of all columns."""
        return [(_plain(n), _plain(u)) if n.strip() else ("", str(i)) for i, (n, u) in enumerate(self.columns)]

    @property
    def said(self) -> list[Key]:
        """Of the columns that have a name."""
        return [key for key in self.keys if key[0]]

    @property
    def columns(self) -> list[tuple[str, str]]:
        """Name and unit of each column, as they stand there."""
        return list(zip(self.names, self.units, strict=True))

    def shown(self, keys: set[Key]) -> str:
        """Columns as the file calls them."""
        pairs = zip(self.keys, self.columns, strict=True)
        return listed(f"{n.strip()} {u.strip()}".strip() for key, (n, u) in pairs if key in keys)


def under_one_head(rows: list[list[str]], numbers: Sequence[int], word: str) -> tuple[list[list[str]], dict[int, str]]:
    """Rows as the first header names them, where later ones have its columns in another order, or more, or fewer.

    Parameters
    ----------
    rows, numbers
        Cells, and the line of each.
    word
        What the file's lines are called.

    Returns
    -------
    rows, told
        As many rows as there were, and of those that are none what they are. Without such a header they stay.

    Raises
    ------
    InputError
        Without a file name, with the place: a later header has columns of other names or units.
    """
    heads = _related(list(_heads(rows)), len(rows))
    if all(head.keys == heads[0].keys for head in heads[1:]):
        return rows, {}
    for before, head in pairwise(heads):
        _check(before, head, numbers, word)
    union = list(dict.fromkeys(key for head in heads for key in head.said))
    if any(_fills_unnamed(head, rows[head.end : end]) for head, end in _parts(heads, len(rows))):
        union += list(dict.fromkeys(key for head in heads for key in head.keys if not key[0]))
    return _mapped(rows, heads, union)


def _mapped(
    rows: Sequence[list[str]], heads: Sequence[_Head], union: Sequence[Key]
) -> tuple[list[list[str]], dict[int, str]]:
    """Rows with the cells of all columns, below a first header that names them."""
    made, told, first = list(rows), dict[int, str](), heads[0]
    for head, end in _parts(heads, len(rows)):
        no_row = f"line that is no row of {head.width} columns"
        if head is not first:
            told |= dict.fromkeys(range(head.begin, head.end), no_row)
            told[head.begin] = _told(head, first)
        place = {key: i for i, key in enumerate(head.keys)}
        order = [place.get(key, -1) for key in union]
        for i in range(head.end, end):
            if len(rows[i]) == head.width:
                made[i] = [rows[i][k] if k >= 0 else "" for k in order]
            else:
                told[i] = no_row
    shown = {key: column for head in reversed(heads) for key, column in zip(head.keys, head.columns, strict=True)}
    made[first.begin : first.end] = [[shown[key][0] for key in union]] * (first.end - first.begin)
    if any(shown[key][1] for key in union):
        made[first.end - 1] = [shown[key][1] for key in union]
    return made, told


def _told(head: _Head, first: _Head) -> str:
    if head.keys == first.keys:
        return "repeated header"
    same = {*head.said} == {*first.said}
    return _BY_NAMES.format("its columns in another order" if same else "more or fewer columns")


def _heads(rows: Sequence[list[str]]) -> Iterator[_Head]:
    """Lines that may name columns, with a row of numbers soon below them."""
    block: list[int] = []
    for i, row in enumerate(rows):
        if _may_name(row):
            block = [*block, i] if block and block[-1] == i - 1 else [i]
        elif block and is_data(row, len(row)):
            head = _head(rows, block, len(row))
            block = []
            if head is not None:
                yield head
        elif block and i - block[-1] >= _NEAR:
            block = []


def _head(rows: Sequence[list[str]], block: Sequence[int], width: int) -> _Head | None:
    names, units = names_above([rows[i] for i in block], width, [])
    if not names:
        return None
    begin = next((i for i in block if padded(rows[i], width) == names), block[-1])
    head = _Head(begin, block[-1] + 1, width, names, units)
    return head if len(head.said) >= _LEAST_NAMES else None


def _may_name(row: Sequence[str]) -> bool:
    first = row[0].lstrip()[:1] if row else "-"
    if first.isdigit() or first in ("+", "-", ".") or 2 * sum(cell[:1].isdigit() for cell in row) > len(row):
        return False  # as nearly all lines, at once
    return is_head(row) and not any(map(is_number, row))


def _related(heads: Sequence[_Head], rows: int) -> list[_Head]:
    """Those of one table: that of a log with the most rows below it, and those that name columns as it does."""
    if len(heads) < 2:
        return list(heads)
    lengths = {head.begin: end - head.end for head, end in _parts(heads, rows)}
    logs = [head for head in heads if _is_log(head, set())]
    longest = max(logs or heads, key=lambda head: lengths[head.begin])
    found = [head for head in heads if head is longest or _names_alike(head, longest)]
    units = {name: unit for name, unit in found[0].said if unit}
    return [found[0], *(head if any(head.units) else _with_units(head, units) for head in found[1:])]


def _names_alike(head: _Head, other: _Head) -> bool:
    """Whether a header names columns of another one; or a time, and beside it what a log of a motor holds."""
    here, there = ({_base(name) for name in one.names} - {""} for one in (head, other))
    times = {name for name in here | there if TIME.fullmatch(name)}
    if head.width == other.width and _base(head.names[0]) == _base(other.names[0]):
        return True
    if head.width != other.width and there & times and not here & times:
        return False  # what was measured of all of a log, below or above it
    shared, fewer = (here & there) - times, min(here - times, there - times, key=len)
    return (bool(shared) and len(shared) >= _SHARED * len(fewer)) or _is_log(head, there)


def _is_log(head: _Head, others: set[str]) -> bool:
    known = [name for name in head.names if _is_known(name) or _base(name) in others]
    return bool(TIME.fullmatch(_base(head.names[0]))) and len(known) > max(1.0, _SHARED * len(head.said))


def _is_known(name: str) -> bool:
    return split_name(name)[1] is not None or bool(PWM.search(name) or DUTY.search(name)) or is_thermal(name)


def _with_units(head: _Head, units: dict[str, str]) -> _Head:
    """A header without units, below which they are those of the first."""
    return replace(head, units=[units.get(_plain(name), "") for name in head.names])


def _check(before: _Head, head: _Head, numbers: Sequence[int], word: str) -> None:
    """Refuse columns of other names or units; some that came or went are those that a header has more, or fewer."""
    here, there = {*head.said}, {*before.said}
    twice = len(here) < len(head.said) or len(there) < len(before.said)
    if head.keys == before.keys or (not twice and (here <= there or there <= here)):
        return
    new, old = (head.shown(here - there), before.shown(there - here)) if here - there and there - here else ("", "")
    said = f"names {new}, where that of {word} {numbers[before.begin]} names {old}" if new else "repeats names"
    raise InputError(
        f"a header that {said}; expected one table: put the lines from there on into a file of their own",
        place=f"{word} {numbers[head.begin]}",
    )


def _parts(heads: Sequence[_Head], rows: int) -> Iterator[tuple[_Head, int]]:
    """Each header, and where its rows end."""
    return zip(heads, [*(head.begin for head in heads[1:]), rows], strict=True)


def _fills_unnamed(head: _Head, rows: Sequence[list[str]]) -> bool:
    unnamed = [i for i, key in enumerate(head.keys) if not key[0]]
    return any(row[i].strip() for row in rows if len(row) == head.width for i in unnamed)


def _base(name: str) -> str:
    return split_name(name)[0].strip().casefold()


def _plain(text: str) -> str:
    return " ".join(text.split()).casefold()
