"""What holds numbers, and which lines name theirs."""

from __future__ import annotations

import pytest

from gen.importing.numbers import parse
from gen.importing.reading.encoding import decode
from gen.importing.reading.pairs import is_keyed


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


@pytest.mark.parametrize(
    ("cell", "value"), [("+   23.4", 23.4), ("-  0,5", -0.5), ("+ 1.234,5", 1234.5), ("+  23.4 °C", 23.4)]
)
def test_spaces_between_sign_and_number_are_passed_over(cell: str, value: float) -> None:
    assert parse([cell], "," if "," in cell else ".").values.tolist() == [value]


@pytest.mark.parametrize(
    ("encoding", "text"),
    [
        ("cp932", "番号,日付 時間,巻線,ケース,室温,指令"),
        ("cp932", "時間,温度(℃)"),
        ("cp932", "T1(℃)"),
        ("cp1252", "Prüfstand;Gehäuse;Größe °C"),
        ("cp1252", "température (°C);boîtier;carcasse émaillée"),
        ("cp437", "Prüfstand;Gehäuse;Lüfter °C"),
        ("mac_roman", "Prüfstand;Gehäuse °C"),
        ("cp1252", "t;T (°C);±0,5 µs"),
    ],
)
def test_shift_jis_is_told_from_encodings_of_single_bytes(encoding: str, text: str) -> None:
    found, name, _ = decode(text.encode(encoding))
    assert (found, name) == (text, encoding)
