"""Whether a run's counts stand for what the model's do."""

from __future__ import annotations

from collections.abc import Mapping
from math import isclose

from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.runs.drive import COMMENT, FULL_COUNTS, drive_of


def check_meaning(coefficients: Coefficients, comments: Mapping[str, str], file: str) -> None:
    """Refuse a run of which the input was scaled otherwise: it would look like another motor.

    A run, or a coefficient file, that says nothing contradicts nothing.

    Parameters
    ----------
    coefficients
        Its input says what the counts stand for.
    comments
        The run file's.
    file
        The run file's name for messages.

    Raises
    ------
    InputError
        With what both say.
    """
    declared, found = coefficients.document.input, drive_of(comments)
    told = declared.stands_for
    if told is None or found is None:
        return
    full_scale = found.full_scale * declared.full_scale / FULL_COUNTS
    if found.unit == told.unit and isclose(full_scale, told.full_scale, rel_tol=1e-4):
        return
    raise InputError(
        f"found {found.text()}; expected as in the coefficient file's $.input.stands_for, {declared.meaning}",
        file=file,
        place=f"comment {COMMENT}",
    )
