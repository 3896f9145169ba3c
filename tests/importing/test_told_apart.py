"""What holds numbers, and which lines name theirs."""

from __future__ import annotations

import pytest

from gen.importing.numbers import parse
from gen.importing.pairs import is_keyed


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("T1:23.4 T2:25.1", True),
        ("> T1:23.4, T2:25.1", True),
        ("[7] T1=23.4 °C; T2=25.1 °C", True),
        ("the second motor was let go at 14:30, and nobody knows why that was, or who had asked for it", False),
        ("23.4,25.1", False),
    ],
)
def test_lines_name_their_numbers_where_little_else_stands_in_them(line: str, named: bool) -> None:
    assert is_keyed([line] * 10) is named


@pytest.mark.parametrize(
    ("cells", "share"),
    [
        (["1", "2.5", "-3e2"], 1.0),
        (["ok"] * 8 + ["1", "2"], 0.2),
        (["ok", "", "nan", "4", "", "n/a"], 0.5),  # what is empty, or a word for "no number", counts for neither
        (["", "nan"], 0.0),
    ],
)
def test_a_column_holds_numbers_by_their_share_of_what_it_says(cells: list[str], share: float) -> None:
    assert parse(cells).numeric == pytest.approx(share)
