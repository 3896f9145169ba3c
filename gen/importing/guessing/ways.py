"""Which way a motor turns, where a column beside its input says so."""

from __future__ import annotations

import numpy as np

from gen.errors import InputError
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.guesses import Choices, quoted
from gen.importing.guessing.names import BACKWARDS, NO_SIGN, SIGN
from gen.importing.switches import said_its_way

_FORWARD, _REVERSE = "forward", "reverse"
"""What `--unit COLUMN=` says of the larger of two numbers."""


def sign_of(evidence: Evidence, drive: Facts, reserved: set[str], choices: Choices) -> tuple[str, float | None]:
    """Find a column that says the direction, and the number in it that is backwards.

    Parameters
    ----------
    evidence
        The columns.
    drive
        The input's: where it is negative itself nothing else says its direction.
    reserved
        Columns that are something else.
    choices
        What the user says.

    Returns
    -------
    column, backwards
        No name where there is none; None where what is negative is backwards.

    Raises
    ------
    InputError
        Without a file name: nothing tells which of two numbers is backwards.
    """
    if drive.span[0] < 0.0:
        return "", None
    for entry in evidence.numbers:
        if entry.name in reserved or choices.columns.get(entry.name) == "" or NO_SIGN.search(entry.name):
            continue
        told = choices.units.get(entry.name, "")
        ways = _ways(entry, drive)
        if told in (_FORWARD, _REVERSE) and len(ways) == 2:
            return entry.name, max(ways) if told == _REVERSE else min(ways)
        named = SIGN.search(entry.name) or said_its_way(evidence.tables[0], entry.name)
        if named and set(np.unique(entry.values)) <= {-1.0, 0.0, 1.0} and entry.span[0] < 0.0:
            return entry.name, None
        if BACKWARDS.search(entry.name) and ways == [0.0, 1.0]:
            return entry.name, 1.0
        if SIGN.search(entry.name) and entry.name not in choices.columns and ways in ([0.0, 1.0], [1.0, 2.0]):
            one, other = (quoted(f"{entry.name}={way}") for way in (_FORWARD, _REVERSE))
            raise InputError(
                f"holds {ways[0]:g} and {ways[1]:g} where the motor is driven; expected --unit {one} (the larger one "
                f"is forwards) or --unit {other}, or --column {quoted(f'{entry.name}=')} where it is no direction",
                place=f"column {entry.name}",
            )
    return "", None


def _ways(entry: Facts, drive: Facts) -> list[float]:
    """What a column holds while the motor is driven, ascending."""
    pairs = zip(entry.parsed, drive.parsed, strict=True)
    found = np.concatenate([own.values[np.nan_to_num(driven.values) != 0.0] for own, driven in pairs])
    return [float(value) for value in np.unique(found[np.isfinite(found)])]
