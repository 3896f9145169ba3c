"""Columns of a switch, a relay or a thermostat: ON and OFF, in words, are 1 and 0; and of states, as an input."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import replace

from gen.importing.guessing.names import DRIVES, DUTY, NO_SIGN, PWM, SIGN
from gen.importing.listing import listed
from gen.importing.numbers import NAN_WORDS
from gen.importing.table import Column, Counted, Table

_WORDS = (
    ("on", "off"),
    ("true", "false"),
    ("ein", "aus"),
    ("an", "aus"),
    ("marche", "arrêt"),
    ("acceso", "spento"),
    ("encendido", "apagado"),
    ("ligado", "desligado"),
    ("aan", "uit"),
)
_WAYS = (
    ("cw", "ccw"),
    ("cw", "acw"),
    ("clockwise", "counterclockwise"),
    ("clockwise", "counter-clockwise"),
    ("clockwise", "anticlockwise"),
    ("forward", "reverse"),
    ("forward", "backward"),
    ("forwards", "backwards"),
    ("fwd", "rev"),
    ("fwd", "bwd"),
    ("rechts", "links"),
    ("vor", "zurück"),
    ("vorwärts", "rückwärts"),
)
"""Which way a motor turns: the first one is that of a positive input."""
_WAYS_BY_NAME = (
    *_WAYS,
    ("f", "r"),
    ("f", "b"),
    ("right", "left"),
    ("positive", "negative"),
    ("pos", "neg"),
    ("plus", "minus"),
    ("+", "-"),
    ("up", "down"),
)
"""The same where the column's name says that it is a direction."""
_ACTIVE = (
    "on heat heats heating run runs running active energized energised ein an heizen heizt heizung läuft betrieb aktiv "
    "marche chauffe chauffage acceso riscalda encendido calienta ligado aan verwarmen"
)
_RESTING = (
    "off idle cool cools cooling stop stopped stops standby stand-by wait waiting waits rest rests resting pause "
    "paused inactive finished ended aus kühlen kühlt kühlung steht stillstand halt warten inaktiv arrêt repos attente "
    "refroidit spento fermo attesa apagado parado espera desligado uit koelen"
)
"""What says that something is given power, and that it is not. A fault, a hold and what is ready say neither."""
_NO_WAY = f"{_RESTING} brake braking coast coasting none neutral n"
"""What says beside a direction that a motor does not turn."""
_TURNING = "direction of {}, taken for 1 or -1"
_BETWEEN = re.compile(r"[\s_:=]+")
_MOST_STATES = 8
NOTHING = NAN_WORDS | {"", "unavailable", "unknown"}
_SAMPLE = 50
"""Cells whose other texts rule all words out."""


def numbers_of(cells: Sequence[str]) -> list[str] | None:
    """Give ``1`` for on and ``0`` for off, nothing where nothing is said; None where anything else stands.

    Parameters
    ----------
    cells
        Texts.
    """
    return _either(cells, _WORDS, "0") or _either(_ends(cells), _WORDS, "0")


def active_state(cells: Sequence[str]) -> tuple[str, list[str]] | None:
    """The only state of a few in which something is given power, and the others; None where that is not plain.

    Parameters
    ----------
    cells
        Texts: ``HEATING``, ``COOLING``, ``IDLE``.
    """
    said = _few(cells)
    words = dict(zip(said, _ends(said), strict=True))
    active = [state for state, word in words.items() if word.casefold() in _ACTIVE.split()]
    others = [state for state, word in words.items() if word.casefold() in _RESTING.split()]
    if len(active) != 1 or not others or len(others) + 1 < len(said):
        return None
    return active[0], others


def _few(cells: Sequence[str]) -> list[str]:
    """The few different texts of a column, in order; nothing where there are many."""
    if len(set(cells[:_SAMPLE])) > _MOST_STATES:
        return []
    said = [text for text in dict.fromkeys(map(str.strip, cells)) if text.casefold() not in NOTHING]
    return said if len(said) <= _MOST_STATES else []


def _ends(cells: Sequence[str]) -> list[str]:
    """Cells without the words that all of them begin with: ``heater on``, ``heater off``; as they are where many."""
    said = _few(cells)
    paths = [_BETWEEN.split(text) for text in said]
    shared = 0
    while len(paths) > 1 and all(len(path) > shared + 1 and path[shared] == paths[0][shared] for path in paths):
        shared += 1
    if not shared:
        return list(cells)
    ends = {text: " ".join(path[shared:]) for text, path in zip(said, paths, strict=True)}
    return [ends.get(cell.strip(), cell) for cell in cells]


def _either(
    cells: Sequence[str], words: Sequence[tuple[str, str]], other: str, neither: Collection[str] = ()
) -> list[str] | None:
    """``1`` for the first of a pair of words, what the second stands for, ``0`` for neither; None for anything else."""
    nothing = NOTHING - {word for pair in words for word in pair}
    first = {cell.strip().casefold() for cell in cells[:_SAMPLE]} - nothing - set(neither)
    if not any(first <= set(pair) for pair in words):
        return None
    folded = [cell.strip().casefold() for cell in cells]
    said = set(folded) - nothing - set(neither)
    for one, second in words:
        if said and said <= {one, second}:
            meant = {one: "1", second: other} | dict.fromkeys(neither, "0")
            return [meant.get(cell, "") for cell in folded]
    return None


def _turning(column: Column, words: Sequence[str]) -> list[str] | None:
    """``1`` and ``-1`` for the ways that a motor turns, ``0`` where it does not; None for a column of anything else."""
    if SIGN.search(column.name):
        return _either(words, _WAYS_BY_NAME, "-1", _NO_WAY.split())
    return _either(words, _WAYS, "-1", _NO_WAY.split()) if not NO_SIGN.search(column.name) else None


def said_its_way(table: Table, name: str) -> bool:
    """Whether a table that was `switched` had words for the ways that a motor turns in a column."""
    return any(found.what == _TURNING.format(name) for found in table.counted)


def _resting(column: Column, words: Sequence[str], drive: str) -> list[str] | None:
    """Numbers of an input with ``0`` where a word says that it is off; None where no word does."""
    said = f"{column.name} {column.unit}"
    if column.name != drive and not (PWM.search(said) or DUTY.search(said) or DRIVES.search(said)):
        return None
    texts = {cell.strip().casefold() for cell in words if not cell[:1].isdigit()}
    off = texts & {*_RESTING.split(), "false"}
    if not off or not any(cell[:1].isdigit() for cell in words):
        return None
    return ["0" if cell.strip().casefold() in off else cell for cell in words]


def switched(table: Table, but: Collection[str] = (), drive: str = "") -> Table:
    """Give a table whose columns of on and off hold 1 and 0, those of directions 1 and -1, and inputs 0 for off.

    All of it is counted.

    Parameters
    ----------
    table
        As it was read.
    but
        Columns to leave alone.
    drive
        The column that was said to be the input, which may hold states.
    """
    counted, columns = list(table.counted), []
    for column in table.columns:
        words = column.cells if isinstance(column.cells, list) and column.name not in but else []
        found = numbers_of(words) if words else None
        what = f"on or off of {column.name}, taken for 1 or 0"
        states = active_state(words) if words and found is None and column.name == drive else None
        if states is not None:
            found = ["1" if cell.strip() == states[0] else "0" if cell.strip() in states[1] else "" for cell in words]
            what = f"state of {column.name}: {states[0]} taken for 1, {listed(states[1])} for 0"
        if words and found is None:
            found = _turning(column, words)
            what = _TURNING.format(column.name)
        count = sum(1 for cell in found or () if cell)
        if words and found is None:
            found = _resting(column, words, drive)
            what = f"word for off in {column.name}, taken for 0"
            count = sum(1 for cell, made in zip(words, found or words, strict=True) if cell != made)
        if found is not None:
            counted.append(Counted(what, count, f"column {column.name}"))
        columns.append(column if found is None else Column(column.name, found, column.unit))
    return replace(table, columns=columns, counted=tuple(counted))
