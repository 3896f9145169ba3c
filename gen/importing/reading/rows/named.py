"""Names and units of columns, by the lines above the first row."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gen.errors import InputError
from gen.importing.listing import listed
from gen.importing.reading.rows.cells import DELIMITERS
from gen.importing.reading.rows.channels import LABVIEWS_TIMES
from gen.importing.reading.rows.heads import (
    STATISTIC,
    is_label,
    is_units,
    labelled_head,
    with_groups,
    with_statistic,
)
from gen.importing.reading.rows.kinds import is_head, padded
from gen.importing.units import unit_of

_LAST = 4
"""Lines above the first row, among which names and units stand."""
_COMMENTS = re.compile(r"(?:comments?|notes?|remarks?|kommentare?|bemerkung(?:en)?|commentaires?)?", re.IGNORECASE)
"""A name of a column that rows need not have: of LabVIEW's files."""


def names_above(before: Sequence[list[str]], width: int, comments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Names and units of columns; no names where there is no header.

    A header may lack the last name, or have one more: a column of comments that no row has (LabVIEW's files).

    Parameters
    ----------
    before
        Lines above the first row.
    width
        Of a row.
    comments
        The comment lines.
    """
    labelled = labelled_head(before, width)
    heads = [padded(row, width) for row in _heads(before, width)]
    if labelled is not None and (not heads or is_label(heads[-1][0])):
        return labelled
    if len(heads) > 1 and sum(1 for cell in heads[-1] if STATISTIC.fullmatch(cell.strip())) > 1:
        return _under_names(heads)
    if len(heads) > 1 and is_units(heads[-1], heads[-2]) and not is_units(heads[-2]):
        return with_groups(heads[-2], heads[-3] if len(heads) > 2 else []), heads[-1]
    if heads:
        described = len(heads) > 1 and heads[-2][0].startswith(("X_", "Y_"))  # channels, in LabVIEW's files
        grouped = len(heads) > 1 and heads[-1][0].strip() != LABVIEWS_TIMES and not described
        return with_groups(heads[-1], heads[-2] if grouped else []), [""] * width
    return _in_comments(comments, width)


def _in_comments(comments: Sequence[str], width: int) -> tuple[list[str], list[str]]:
    """Names of the last comment that can name them (`numpy.savetxt`), or with units below them (`nvidia-smi dmon`)."""
    found: list[list[str]] = []
    for text in reversed(comments):
        row = _of_names(text, width)
        if found and row and is_units(found[0], row) and not is_units(row):
            return row, found[0]
        if found:
            break
        found += [row] if row else []
    return found[0] if found else [], [""] * width


def _of_names(text: str, width: int) -> list[str]:
    """A comment's cells, where they may name the columns; none where they can't."""
    for delimiter in DELIMITERS:
        row = text.split() if delimiter == " " else text.split(delimiter)
        if width > 1 and len(row) == width and is_head(row) and ":" not in row[0]:
            return [cell.strip() for cell in row]
    return []


def lacks_a_name(before: Sequence[list[str]], width: int) -> bool:
    """Whether a header has one name less than a row has fields; an empty last one is a name.

    Parameters
    ----------
    before
        Lines above the first row.
    width
        Of a row.
    """
    heads = _heads(before, width)
    return bool(heads) and all(len(row) < width for row in heads)


def check_surplus(before: Sequence[list[str]], numbers: Sequence[int], width: int, word: str) -> None:
    """Refuse a header with a name that is of no field, and may stand anywhere: names behind it are of other columns.

    Parameters
    ----------
    before, numbers
        Lines above the first row, and the place of each.
    width
        Of a row.
    word
        What a place is called.

    Raises
    ------
    InputError
        Without a file name.
    """
    at = [i for i in range(max(len(before) - _LAST, 0), len(before)) if _may_name(before[i], width)]
    used = at[-2:] if len(at) > 1 and is_units(before[at[-1]], before[at[-2]]) else at[-1:]
    for i in used:
        names = [name.strip() for name in before[i]]
        if len(names) > width and not _COMMENTS.fullmatch(names[-1]):
            raise InputError(
                f"found {len(names)} names ({listed(names)}) above rows of {width} fields; expected one for each: "
                "put a name that holds the mark between columns in quotes, or take the surplus one out",
                place=f"{word} {numbers[i]}",
            )


def _heads(before: Sequence[list[str]], width: int) -> list[list[str]]:
    return [row for row in before[-_LAST:] if _may_name(row, width)]


def _may_name(row: Sequence[str], width: int) -> bool:
    return abs(len(row) - width) <= 1 and is_head(row)


def _under_names(heads: Sequence[list[str]]) -> tuple[list[str], list[str]]:
    """Names and units where the last line only says which value of an interval a column holds: `Min`, `Max`."""
    *above, last = heads
    names = next((row for row in reversed(above) if not is_units(row)), [""] * len(last))
    units = next((row for row in reversed(above) if is_units(row)), [""] * len(last))
    made = [
        with_statistic(name.strip(), cell) if STATISTIC.fullmatch(cell.strip()) else cell or name
        for name, cell in zip(names, last, strict=True)
    ]
    return made, [unit if unit_of(unit) else "" for unit in units]
