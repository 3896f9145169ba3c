"""Lines above a table: which hold units, and which say by their first cell what they hold (`Tag`, `Unit`)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

from gen.importing.units import TIME, split_name, unit_of

STATISTIC = re.compile(r"(?:min|max|mean|avg|average|ave|last|inst|smp)\.?", re.IGNORECASE)
"""Which value of an interval a column holds; `Smp` is a sample, of Campbell's loggers."""
_NAMES = ("tag", "tag no.", "tag name", "name", "signal name", "label", "comment", "ch", "ch.", "channel", "kanal")
"""Which of such lines names the columns best, first of all."""
_UNITS = ("unit", "units", "einheit", "unité", "unità", "unidad")
_KINDS = ("kind", "data type")
_OTHERS = ("type", "mode", "range", "scaling", "input", "function")
_LEAST_PAIRED = 4
_LEAST_LABELS = 2
_LEAST_NAMED = 0.5
_LEAST_PARTED, _MOST_DECIMALS, _LEAST_DECIMALS = 3, 3, 5
"""Columns, digits behind a decimal comma, and how many different ones make a fraction of them."""
_JUMPING = 0.15
"""Of their range, by which such digits change from row to row on average."""
_SAY_LITTLE = {"t", "temp", "temp.", "temperature", "temperatur", "température", "temperatura", "value", "wert", "ist"}
"""Names that need the group that stands above them."""
_LONGEST = 20
"""Lines above the first row, at most, among which they stand."""

_UNITS_LISTED = re.compile(r"(?:units?|einheit(?:en)?|unit[ée]s?)\s*[:=]\s*(?P<list>\S.*)", re.IGNORECASE)


def labelled_head(before: Sequence[Sequence[str]], width: int) -> tuple[list[str], list[str]] | None:
    """Names and units of columns by lines such as `Tag | Winding | Casing` and `Unit | °C | °C`.

    Parameters
    ----------
    before
        Lines above the first row.
    width
        Of a row.

    Returns
    -------
    names, units
        The first column, of the times, is called so; or None without lines of names and of units.
    """
    rows: dict[str, list[str]] = {}
    for row in before[-_LONGEST:]:
        if abs(len(row) - width) <= 1 and row:
            rows.setdefault(row[0].strip().casefold(), [cell.strip() for cell in [*row, ""][:width]])
    units = next((rows[key] for key in _UNITS if key in rows), None)
    named = [rows[key] for key in _NAMES if key in rows and _is_filled(rows[key])]
    if units is None or not named or not any(map(unit_of, units[1:])):
        return None
    kinds = next((rows[key] for key in _KINDS if key in rows and any(map(STATISTIC.fullmatch, rows[key][1:]))), None)
    names = [next((row[i] for row in named if row[i]), "") for i in range(width)]
    if kinds is not None:
        names = [with_statistic(name, kind) for name, kind in zip(names, kinds, strict=True)]
    return ["time", *names[1:]], ["", *(unit if unit_of(unit) else "" for unit in units[1:])]


def with_statistic(name: str, kind: str) -> str:
    """A name with which value of an interval its column holds, where that says more than the name does.

    Parameters
    ----------
    name, kind
        As they stand above each other.
    """
    kind = kind.strip()
    if not STATISTIC.fullmatch(kind) or kind.casefold() == "smp" or name.casefold().endswith(kind.casefold()):
        return name
    return f"{name} {kind}".strip()


def paired_head(lines: Sequence[Sequence[str]], width: int) -> tuple[int, list[str], list[str]] | None:
    """Names and units of columns of times and values by turns, by lines such as `Name | Winding | Name | Duty`.

    Parameters
    ----------
    lines
        The first of a file.
    width
        Of a row.

    Returns
    -------
    at, names, units
        Behind which line rows may begin; or None without such a line.
    """
    if width < _LEAST_PAIRED or width % 2:
        return None
    paired = [(i, row) for i, row in enumerate(lines) if len(row) == width and len({*row[::2]}) == 1 and row[0].strip()]
    named = next((row for _, row in paired if row[0].strip().casefold() in _NAMES and all(row[1::2])), None)
    if named is None:
        return None
    last = max(i for i, row in paired if not row[0][:1].isdigit())
    said = (re.search(r"\[(\w+)\]", row[0]) for _, row in paired)
    of_times = next((match[1] for match in said if match and _is_time(match[1])), "")
    names = [name for channel in named[1::2] for name in ("time", channel.strip())]
    return last, names, [of_times, ""] * (width // 2)


def with_groups(names: Sequence[str], above: Sequence[str]) -> list[str]:
    """Names that say little, or stand more than once, with the group above: `Winding | | Room` over `T | max | T`.

    Parameters
    ----------
    names
        Of the columns; of an empty one what stands above it is the name.
    above
        The line above them, as long, or empty; a group stands above its first column, or above each.
    """
    bases = [split_name(name)[0].strip().casefold() for name in names]
    made, group = [], ""
    for name, base, cell in zip(names, bases, above or [""] * len(names), strict=True):
        group = cell.strip() or group
        says_little = base in _SAY_LITTLE or bool(STATISTIC.fullmatch(base)) or bases.count(base) > 1
        labels = re.search(r"[^\W\d_]{2}", group) and not unit_of(group) and group.casefold() != name.strip().casefold()
        named = f"{split_name(group)[0]} {name}" if says_little and labels else name
        made.append(named if name.strip() else cell)
    return made


def with_labels(names: Sequence[str], before: Sequence[Sequence[str]]) -> list[str]:
    """Names of columns with what a list of channels above says of them: `CH1,Winding,TEMP,TC_K`.

    Parameters
    ----------
    names
        Of the columns.
    before
        Lines above the first row.
    """
    lines = [[cell.strip() for cell in row] for row in before if len(row) > 1 and row[0].strip() in names]
    said = {row[0]: row[1] for row in lines if row[0] and re.search(r"[^\W\d_]", row[1]) and not unit_of(row[1])}
    if len(said) < _LEAST_LABELS or len(set(said.values())) < len(said) or len(lines) > len({row[0] for row in lines}):
        return list(names)
    return [f"{name} {said[name]}" if name in said else name for name in names]


def listed_units(before: Sequence[Sequence[str]], comments: Sequence[str], names: Sequence[str]) -> list[str]:
    """Units that a line above names or a comment lists, of each column: LabVIEW's `Y_Unit_Label`, `# units: s,degF`.

    Parameters
    ----------
    before
        Lines above the first row.
    comments
        The comment lines.
    names
        Of the columns.

    Returns
    -------
    list of str
        Empty where nothing does, or lists more or fewer than there are columns.
    """
    found: list[list[str]] = []
    for comment in comments:
        listed = _UNITS_LISTED.fullmatch(comment)
        units = re.split(r"[,;|\t]", listed["list"]) if listed else []
        found += [units] if len(units) == len(names) else []
    if names[:1] == ["X_Value"]:
        rows = [row for row in before if row and row[0].strip() == "Y_Unit_Label"]
        found += [["", *row[1:], *[""] * len(names)][: len(names)] for row in rows]
    known = next((units for units in found if any(map(unit_of, units))), [])
    return [unit.strip() if unit_of(unit) else "" for unit in known]


def parted_decimals(names: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    """A number whose decimal comma parted it in two columns, where a header lacks a name; empty where none did.

    Parameters
    ----------
    names, cells
        Of columns that a comma parts.
    """
    if len(names) < _LEAST_PARTED or names[-1].strip() or not any(map(str.strip, cells[-1])):
        return ""
    for whole, part in pairwise(cells):
        width = {len(cell) for cell in part}
        digits = all(map(str.isdigit, part)) and all(cell.lstrip("+-").isdigit() for cell in whole)
        if digits and len(width) == 1 and max(width) <= _MOST_DECIMALS and _jumps(list(map(int, part))):
            return f"{whole[0]},{part[0]}"
    return ""


def _jumps(numbers: Sequence[int]) -> bool:
    """Whether numbers go to and fro from row to row, as the last digits of what changes slowly do."""
    if len(set(numbers)) < _LEAST_DECIMALS:
        return False
    on_average = sum(abs(b - a) for a, b in pairwise(numbers)) / (len(numbers) - 1)
    return on_average >= _JUMPING * (max(numbers) - min(numbers))


def _is_time(text: str) -> bool:
    unit = unit_of(text)
    return unit is not None and unit.quantity == TIME


def is_label(cell: str) -> bool:
    """Whether a line's first cell says what the line holds.

    Parameters
    ----------
    cell
        The cell.
    """
    return cell.strip().casefold() in (*_NAMES, *_UNITS, *_KINDS, *_OTHERS)


def _is_filled(row: Sequence[str]) -> bool:
    return sum(map(bool, row[1:])) >= _LEAST_NAMED * max(len(row) - 1, 1)


def is_units(row: Sequence[str], above: Sequence[str] | None = None) -> bool:
    """Whether a line holds units: in more than half of its cells; below a line of names, where one comes back.

    Parameters
    ----------
    row
        The line.
    above
        The line above it, or None.
    """
    filled = [cell.strip() for cell in row if cell.strip()]
    known = [cell for cell in filled if unit_of(cell) or re.fullmatch(r"[\[(].*[\])]|-|hh:mm:ss.*", cell)]
    if filled and 2 * len(known) > len(filled):
        return True
    names = [cell.strip().casefold() for cell in above or () if cell.strip()]
    return len(set(known)) < len(known) and len(set(names)) == len(names) >= len(filled)
