"""Which kind of model a file holds, for what cannot take every kind."""

from __future__ import annotations

from gen.coefficients.reader import Coefficients
from gen.errors import InputError


def transfer_functions_only(coefficients: Coefficients, what: str, file: str | None = None) -> None:
    """Refuse a network.

    Parameters
    ----------
    coefficients
        The file.
    what
        What takes transfer functions only, as its user names it, as "gen refine".
    file
        The file's name for the message; None for a model that was made in memory.

    Raises
    ------
    InputError
        If the file holds a network.
    """
    if coefficients.model.network is not None:
        raise InputError(
            f"{what} takes transfer functions only, and this is a network (docs/format.md)",
            file=file,
            place="$.network",
        )
