"""Whether a run's counts stand for what the model's do."""

from __future__ import annotations

from collections.abc import Mapping
from math import isclose

from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.runs.drive import COMMENT, FULL_COUNTS, Drive, drive_of


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
    # What 255 counts of the file mean: a run's full scale is 255 always.
    rest = told.rest or 0.0
    meant = rest + (told.full_scale - rest) * FULL_COUNTS / declared.full_scale
    close = found.full_scale if isclose(meant, found.full_scale, rel_tol=1e-4) else meant
    expected = Drive(told.quantity, told.unit, close, rest=rest)
    if found.agrees(expected):
        return
    raise InputError(
        f"found {found.text()}; expected as in the coefficient file's $.input.stands_for, {declared.meaning}"
        f"{found.remedy(expected)}",
        file=file,
        place=f"comment {COMMENT}",
    )
