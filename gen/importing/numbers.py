"""Text to numbers, with a count of all that is none."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.importing.units import unit_of
from gen.runs.head import NUMBER

NAN_WORDS = frozenset(
    ["nan", "na", "n/a", "#n/a", "#na", "null", "none", "nil", "missing", "-", "--", "---", "?", "inf", "+inf", "-inf"]
)
_MINUS = str.maketrans(dict.fromkeys("\u2212\u2012\u2013\u2014\ufe63\uff0d", "-"))
"""Typeset minuses and dashes: of German and Norwegian settings, of what was copied out of a document."""
_PLAIN = str.maketrans("", "", "0123456789+-.eE \n")
_GROUPED = re.compile(r"(?<=\d)[ \u00a0\u202f\u2009'’](?=\d{3}(?!\d))")
_THOUSANDS_POINT = re.compile(r"(?<=\d)\.(?=\d{3}(?:\D|$))")
_THOUSANDS_COMMA = re.compile(r"(?<=\d),(?=\d{3}(?:\D|$))")
_SIGN_APART = re.compile(r"^([+-])\s+(?=[\d.,])")
"""Columns of one width: `+   23.4`."""
_AS_TEXT = re.compile(r"""(?:="([^"]*)"|'(?=[\d.,+-]))""")
"""So that a spreadsheet takes it as it is: `="22.5"`, `'22.5`."""
_OF_FORTRAN = re.compile(r"(?<=[\d.])[dD](?=[+-]\d+$)")
_LONGEST_UNIT = 20
_WITH_UNIT = re.compile(r"(\S*\d\.?)(?:\s*([^\d\s.,+-].{0,19})|\s+(1/(?:min|s)))")


@dataclass(frozen=True)
class Parsed:
    """A column of text as numbers.

    Parameters
    ----------
    values
        NaN where there is no number, shape (N,).
    empty, words, text
        Rows with nothing, with a word for "no number", with other text, shape (N,).
    units, unit_at
        What stands behind numbers, and which of them behind each, -1 where nothing does, shape (N,); None where nothing
        stands behind any.
    converted
        Rows whose unit was another than their column's, shape (N,); None where there is none.
    """

    values: FloatArray
    empty: BoolArray
    words: BoolArray
    text: BoolArray
    units: tuple[str, ...] = ()
    unit_at: IntArray | None = None
    converted: BoolArray | None = None

    @property
    def numeric(self) -> float:
        """Share of numbers among the rows that hold something other than a word for "no number"."""
        something = int((~self.empty & ~self.words).sum())
        return float(np.isfinite(self.values).sum()) / something if something else 0.0


def parse(cells: Sequence[str], decimal: str = ".") -> Parsed:
    """Read numbers; every one is rounded correctly, as Python's own ``float`` does.

    Parameters
    ----------
    cells
        Texts.
    decimal
        The decimal mark; the other one, spaces and apostrophes may part thousands.
    """
    none = np.zeros(len(cells), dtype=bool)
    bare, unit = _without_unit(cells)
    quick = _parse_fast(bare, decimal)
    if quick is not None:
        unit_at = np.zeros(len(cells), dtype=np.int64) if unit else None
        return Parsed(quick, np.isnan(quick), none, none.copy(), (unit,) if unit else (), unit_at)
    values = np.full(len(cells), np.nan)
    empty, words, text = none, none.copy(), none.copy()
    units: dict[str, int] = {}
    unit_at = np.full(len(cells), -1, dtype=np.int64)
    for i, cell in enumerate(cells):
        stripped = _signed(cell)
        if not stripped:
            empty[i] = True
        elif stripped.casefold() in NAN_WORDS:
            words[i] = True
        else:
            number, unit = _number(stripped, decimal)
            if number is None:
                text[i] = True
            else:
                values[i] = number
                if unit:
                    unit_at[i] = units.setdefault(unit, len(units))
    return Parsed(values, empty, words, text, tuple(units), unit_at if units else None)


def _without_unit(cells: Sequence[str]) -> tuple[Sequence[str], str]:
    """Cells without the unit that stands behind all of them, behind a space; as they are where one differs."""
    number, _, unit = (cells[0] if cells else "").partition(" ")
    behind = f" {unit}"
    if not number or len(unit) > _LONGEST_UNIT or not unit_of(unit) or not all(c.endswith(behind) for c in cells):
        return cells, ""
    bare = [cell[: -len(behind)] for cell in cells]
    return (bare, unit) if all(bare) else (cells, "")


def _signed(cell: str) -> str:
    """A cell without what stands around it, with a plain sign next to its number."""
    text = cell.strip().translate(_MINUS)
    if text[:1] in "='":
        text = _AS_TEXT.sub(r"\1", text)
    return _SIGN_APART.sub(r"\1", text)


def _parse_fast(cells: Sequence[str], decimal: str) -> FloatArray | None:
    joined = "\n".join(cells)
    if decimal == ",":
        if "." in joined:
            return None
        joined = joined.replace(",", ".")
    if joined.translate(_PLAIN) or joined.count("\n") != len(cells) - 1:
        return None
    texts = joined.split("\n")
    try:
        if " " not in joined and "" not in texts:
            values = np.fromiter(map(float, texts), dtype=np.float64, count=len(texts))
        else:
            missing = float("nan")
            values = np.array([float(text) if text.strip() else missing for text in texts])
    except ValueError:
        return None
    return None if np.isinf(values).any() else values


def _number(text: str, decimal: str) -> tuple[float | None, str]:
    plain = plain_number(text, decimal)
    if plain is not None:
        return plain, ""
    parted = _WITH_UNIT.fullmatch(text)
    unit = (parted[2] or parted[3]) if parted else ""
    if parted and unit_of(unit):
        return plain_number(parted[1], decimal), unit
    return None, ""


def plain_number(text: str, decimal: str = ".") -> float | None:
    """The number that a text is, or None; infinity is none."""
    if (decimal == "." or "." not in text) and NUMBER.fullmatch(text):
        value = float(text)
        return value if math.isfinite(value) else None
    if text.isalpha():
        return None
    plain = _OF_FORTRAN.sub("E", _GROUPED.sub("", _signed(text)))
    plain = _THOUSANDS_POINT.sub("", plain).replace(",", ".") if decimal == "," else _THOUSANDS_COMMA.sub("", plain)
    if not NUMBER.fullmatch(plain):
        return None
    value = float(plain)
    return value if np.isfinite(value) else None


_RARE = 0.02
"""Of a decimal mark over the other one: what damaged lines leave."""


def decimal_mark(cells: Iterable[str]) -> tuple[str, float, str]:
    """Guess the decimal mark of a file.

    Parameters
    ----------
    cells
        Texts from all of its columns.

    Returns
    -------
    mark, confidence, why
        The mark, how sure that is, 0..1, and why.
    """
    seen: dict[str, list[str]] = {}
    for cell in cells:
        text = _GROUPED.sub("", _signed(cell))
        match = _MARKED.fullmatch(text)
        if match and match.lastgroup:
            seen.setdefault(match.lastgroup, []).append(text)
    if "thousands_comma" in seen and "comma" not in seen:
        return ".", 0.95, f"commas part thousands: {seen['thousands_comma'][0]}"
    if "thousands_point" in seen and "point" not in seen:
        return ",", 0.95, f"points part thousands: {seen['thousands_point'][0]}"
    if "comma" in seen and "point" in seen:
        often, rare = sorted(("point", "comma"), key=lambda kind: -len(seen[kind]))
        if len(seen[rare]) > _RARE * len(seen[often]):
            return ".", 0.3, f"both occur: {seen['comma'][0]}, {seen['point'][0]}"
        del seen[rare]  # of damaged lines
    if "comma" in seen:
        return ",", 0.97, f"found {seen['comma'][0]}"
    if "point" in seen:
        return ".", 0.97, f"found {seen['point'][0]}"
    if "three_behind_comma" in seen:
        return ",", 0.4, f"{seen['three_behind_comma'][0]} may be a thousand or a decimal fraction"
    return ".", 0.9, "no decimal fraction found" if "three_behind_point" not in seen else "points only"


def thousands_or_fractions(columns: Iterable[Sequence[str]]) -> str:
    """Say what number's point may part thousands, in a file without any other decimal mark; nothing where none does.

    Who writes fractions to three digits writes `450.000`, and who leaves zeros away `1.5`: `450` or `0` beside `1.500`
    is of neither. Where thousands are parted, no whole number has four digits.

    Parameters
    ----------
    columns
        Texts of each.
    """
    for column in columns:
        texts = {_signed(cell) for cell in column if cell}
        pointed = sorted(text for text in texts if "." in text)
        if not pointed or not all(_THREE_BEHIND.fullmatch(text) for text in pointed):
            continue
        whole = max((text for text in texts if text.lstrip("+-").isdecimal()), key=len, default="")
        size = len(whole.lstrip("+-"))
        if size == _OF_A_THOUSAND or (0 < size < _OF_A_THOUSAND and any(text.endswith("0") for text in pointed)):
            return f"{pointed[0]} may be a thousand or a decimal fraction: {whole} is beside it"
    return ""


_OF_A_THOUSAND = 3
_THREE_BEHIND = re.compile(r"[+-]?[1-9]\d{0,2}\.\d{3}", re.ASCII)
_MARKS = {
    "thousands_comma": r"[+-]?\d{1,3}(?:,\d{3})+\.\d+|[+-]?\d{1,3}(?:,\d{3}){2,}",
    "thousands_point": r"[+-]?\d{1,3}(?:\.\d{3})+,\d+|[+-]?\d{1,3}(?:\.\d{3}){2,}",
    "three_behind_comma": r"[+-]?[1-9]\d{0,2},\d{3}",
    "three_behind_point": r"[+-]?[1-9]\d{0,2}\.\d{3}",
    "comma": r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?(?:\s*[^\d\s.,+-]\S{0,4})?",
    "point": r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?(?:\s*[^\d\s.,+-]\S{0,4})?",
}
_MARKED = re.compile("|".join(f"(?P<{kind}>{pattern})" for kind, pattern in _MARKS.items()), re.ASCII)
"""The first of them that fits."""
