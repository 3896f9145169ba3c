"""What a run file's comments say of the whole run."""

from __future__ import annotations

from math import isfinite

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
    noted = run.comments.get(AMBIENT)
    if noted is None:
        return None
    try:
        value = float(noted)
    except ValueError:
        value = float("nan")
    if not (isfinite(value) and _POSSIBLE[0] <= value <= _POSSIBLE[1]):
        raise InputError(f'found "{noted}", expected a temperature in degC', file=file, place=f"# {AMBIENT}")
    return value
