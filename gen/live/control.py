"""What of a source a page can change, and what it may be set to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from gen.errors import InputError

_LONGEST = 200


@dataclass(frozen=True)
class Control:
    """Something of a source that the page can change.

    Parameters
    ----------
    name, label
        For programs and for people.
    form
        ``number`` and ``slider`` (from `low` to `high` in steps of `step`), ``choice`` (one of `options`) or ``text``.
    value
        What it is set to.
    """

    name: str
    label: str
    form: Literal["number", "slider", "choice", "text"]
    value: float | str
    low: float = 0.0
    high: float = 0.0
    step: float = 1.0
    options: tuple[str, ...] = ()


def checked(control: Control, value: Any) -> float | str:  # noqa: ANN401
    """Check a value that came from a page.

    Raises
    ------
    InputError
        With what was expected.
    """
    if control.form in ("number", "slider"):
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not control.low <= value <= control.high:
            raise InputError(f"{control.label}: found {value!r}, expected {control.low:g}..{control.high:g}")
        return float(value)
    if (
        not isinstance(value, str)
        or len(value) > _LONGEST
        or (control.form == "choice" and value not in control.options)
    ):
        expected = ", ".join(control.options) if control.form == "choice" else "a short text"
        raise InputError(f"{control.label}: found {str(value)[:60]!r}, expected {expected}")
    return value
