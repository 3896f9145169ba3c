"""A file that ends within a number: its logger was switched off, or a copy stopped half-way."""

from __future__ import annotations

from collections.abc import Sequence

from gen.importing.table import Counted

_LEAST = 50
"""Rows that show how many decimals a column always has: fewer may have as many by chance."""
_LOOKED_AT = 1000


def broken_off(rows: Sequence[Sequence[str]], good: Sequence[int], word: str, number: int) -> Counted | None:
    """Count the last row if its last number lacks decimals that all of those above it have.

    Parameters
    ----------
    rows
        Cells, of a file that does not end with the end of a line.
    good
        Which of them are rows, in order.
    word, number
        What the file's lines are called, and the last one's number.

    Returns
    -------
    counted
        None where nothing tells that the number is not whole: the last row is no row anyway, or the column's numbers
        are of any length.
    """
    if len(good) <= _LEAST or good[-1] != len(rows) - 1:
        return None
    usual = {_decimals(rows[i][-1]) for i in good[-_LOOKED_AT - 1 : -1]}
    if len(usual) != 1 or _decimals(rows[-1][-1]) >= usual.pop():
        return None
    return Counted("row whose last number breaks off, at the end of the file", 1, f"{word} {number}")


def _decimals(cell: str) -> int:
    """Digits behind the mark, a comma or a point, and the mark itself; 0 without one."""
    text = cell.strip()
    at = max(text.rfind("."), text.rfind(","))
    return len(text) - at if at >= 0 else 0
