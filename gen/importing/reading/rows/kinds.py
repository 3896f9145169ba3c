"""What a line of cells is: a row of numbers, or one that names columns."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gen.importing.clock import is_time
from gen.importing.guessing.names import TIME
from gen.importing.numbers import NAN_WORDS, plain_number
from gen.importing.units import unit_of

_RULE = re.compile(r"[-=_*~]{2,}")
"""What stands between a header and its rows, where somebody reads them."""


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, a time, or a number with its unit.

    Parameters
    ----------
    cell
        The cell.
    """
    text = cell.strip()
    return (
        plain_number(text) is not None
        or plain_number(text, ",") is not None
        or is_time(text)
        or (text[:1].isdigit() and unit_of(re.sub(r"^[\d.,]+\s*", "", text)) is not None)
    )


def is_data(row: Sequence[str], width: int) -> bool:
    """Whether a line is a row of numbers.

    Parameters
    ----------
    row
        Its cells.
    width
        How many a row has.
    """
    if len(row) != width or _numbers_channels(row):
        return False
    filled = [cell for cell in row if cell.strip() and cell.strip().casefold() not in NAN_WORDS]
    return bool(filled) and 2 * sum(map(is_number, filled)) >= len(filled)


def _numbers_channels(row: Sequence[str]) -> bool:
    """Whether a header calls its channels by whole numbers behind a time: `time,101,102`."""
    first, *others = (cell.strip() for cell in row)
    return bool(TIME.fullmatch(first.casefold())) and all(cell.isdigit() for cell in others)


def is_reading(row: Sequence[str], width: int) -> bool:
    """Whether a line is a row with a time and a number among words: which device's sensor, in what unit.

    Parameters
    ----------
    row
        Its cells.
    width
        How many a row has.
    """
    return len(row) == width and sum(map(is_number, row)) > 1 and any(is_time(cell.strip()) for cell in row)


def is_head(row: Sequence[str]) -> bool:
    """Whether a line may name columns: it is filled, and holds no number.

    Parameters
    ----------
    row
        Its cells.
    """
    if _numbers_channels(row):
        return True
    filled = [cell for cell in row if cell.strip()]
    if all(_RULE.fullmatch(cell.strip()) for cell in filled):
        return False
    return 2 * len(filled) > len(row) and not any(plain_number(cell.strip()) is not None for cell in filled)


def padded(row: list[str], width: int) -> list[str]:
    """A line's cells, as many as a row has.

    Parameters
    ----------
    row
        Its cells.
    width
        How many a row has.
    """
    return [*row, *[""] * (width - len(row))][:width]
