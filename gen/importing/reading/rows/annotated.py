"""InfluxDB's annotated CSV: tables one below the other, each with a header, whose columns may differ."""

from __future__ import annotations

from collections.abc import Sequence

_HEAD = ["", "result", "table"]


def of_one_head(rows: Sequence[list[str]], numbers: Sequence[int]) -> tuple[list[list[str]], list[int]]:
    """Rows below one header that has all columns; those of other files stay as they are.

    Parameters
    ----------
    rows, numbers
        Cells, and the line of each.
    """
    heads = [row for row in rows if row[:3] == _HEAD]
    names = list(dict.fromkeys(name for row in heads for name in row))
    if not heads or all(row == heads[0] for row in heads):
        return list(rows), list(numbers)
    made, places = [names], [numbers[0]]
    head: list[str] = []
    for row, number in zip(rows, numbers, strict=True):
        if row[:3] == _HEAD:
            head = row
        elif head and len(row) == len(head):
            told = dict(zip(head, row, strict=True))
            made.append([told.get(name, "") for name in names])
            places.append(number)
        else:
            made.append(row)
            places.append(number)
    return made, places
