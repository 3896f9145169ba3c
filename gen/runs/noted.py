"""What a run file's comments say of the whole run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite

import numpy as np

from gen.errors import InputError
from gen.runs.run import AMBIENT, Run

_POSSIBLE = (-273.15, 1000.0)
"""degC."""


def noted_ambient(run: Run, file: str) -> float | None:
    """The ambient that a comment ``# ambient_degC: 22`` notes, degC; None without one.

    Parameters
    ----------
    run
        The run.
    file
        Its name for messages.

    Raises
    ------
    InputError
        When what is noted is no temperature.
    """
    return noted_in(run.comments, file)


def noted_in(comments: Mapping[str, str], file: str) -> float | None:
    """As :func:`noted_ambient`, of a run's comments alone."""
    noted = comments.get(AMBIENT)
    if noted is None:
        return None
    try:
        value = float(noted)
    except ValueError:
        value = float("nan")
    if not (isfinite(value) and _POSSIBLE[0] <= value <= _POSSIBLE[1]):
        raise InputError(f'found "{noted}", expected a temperature in degC', file=file, place=f"# {AMBIENT}")
    return value


def with_noted_ambient(run: Run, file: str) -> Run:
    """Give a run whose ambient stands in a comment the same one at every row, where no column has it.

    Parameters
    ----------
    run
        The run.
    file
        Its name for messages.

    Raises
    ------
    InputError
        When what is noted is no temperature.
    """
    if run.ambient is not None and not np.all(np.isnan(run.ambient)):
        return run
    noted = noted_ambient(run, file)
    return run if noted is None else replace(run, ambient=np.full(run.time_s.size, noted))
