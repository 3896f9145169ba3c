"""What functions are called with: a wrong argument is told as a wrong file is, before any work."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from numbers import Integral
from pathlib import Path

from gen.errors import InputError


def one_of(name: str, value: object, allowed: Collection[str]) -> None:
    """Refuse a word that is none of those allowed.

    Raises
    ------
    InputError
        With what was found and what was expected.
    """
    if not isinstance(value, str) or value not in allowed:
        raise InputError(f"{name}: found {value!r}, expected {', '.join(map(repr, allowed))}")


def within(name: str, value: object, low: float, high: float) -> None:
    """Refuse what is no finite number from `low` to `high`.

    Raises
    ------
    InputError
        With what was found and what was expected.
    """
    good = isinstance(value, (int, float)) and math.isfinite(value) and low <= value <= high
    if not good:
        raise InputError(f"{name}: found {value!r}, expected a number from {low:g} to {high:g}")


def whole(name: str, value: object, low: int, high: int) -> None:
    """Refuse what is no whole number from `low` to `high`.

    Raises
    ------
    InputError
        With what was found and what was expected.
    """
    if not isinstance(value, Integral) or isinstance(value, bool) or not low <= int(value) <= high:
        raise InputError(f"{name}: found {value!r}, expected a whole number from {low} to {high}")


def a_path(name: str, value: object) -> Path:
    """The path that was given.

    Raises
    ------
    InputError
        If it is none.
    """
    if not isinstance(value, (str, Path)):
        raise InputError(f"{name}: found {_kind(value)}, expected a path")
    return Path(value)


def several(name: str, runs: object) -> Sequence[object]:
    """The runs that were given, one at least.

    Raises
    ------
    InputError
        If it is no list of runs, or an empty one.
    """
    if not isinstance(runs, (list, tuple)):
        raise InputError(f"{name}: found {_kind(runs)}, expected a list of runs")
    if not runs:
        raise InputError(f"{name}: found no run, expected at least one")
    return runs


def _kind(value: object) -> str:
    return "a str" if isinstance(value, str) else f"a {type(value).__name__}"
