"""The two ways in which a command may fail in front of its user."""

from __future__ import annotations


class InputError(Exception):
    """Bad input or usage: one clear message, exit status 2.

    Parameters
    ----------
    message
        What was found and what was expected.
    file
        The file that holds the fault, as the user named it.
    place
        The place in that file: a JSON path (``$.components[0].gain``) or ``line 7, column brush_degC``.
    """

    def __init__(self, message: str, *, file: str | None = None, place: str | None = None) -> None:
        self.message = message
        self.file = file
        self.place = place
        super().__init__(": ".join(part for part in (file, place, message) if part))


class CheckFailed(Exception):
    """The check that was asked for fails (a mismatch, a bound exceeded): exit status 1."""
