"""Loops over numbers that follow one on another, compiled where they stand (Numba)."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

from numba import njit

P = ParamSpec("P")
T = TypeVar("T")


def compiled(function: Callable[P, T]) -> Callable[P, T]:
    """Compile a function of arrays and numbers when it is first called, and keep the machine code for later processes.

    It is kept beside the source, or in the user's cache where that cannot be written to; nowhere, where neither can.
    """
    try:
        made = njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # no place to keep it
        made = njit(error_model="numpy")(function)
    return cast("Callable[P, T]", made)
