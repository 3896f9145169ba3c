"""Channels of LabVIEW's files, each with a column of its own times before it: `X_Value | PWM | X_Value | Winding`."""

from __future__ import annotations

from collections.abc import Sequence

from gen.errors import InputError
from gen.importing.units import unit_of

LABVIEWS_TIMES = "X_Value"


def have_own_times(names: Sequence[str]) -> bool:
    """Whether names are those of such a file.

    Parameters
    ----------
    names
        Of the columns.
    """
    return names[0] == LABVIEWS_TIMES and list(names).count(LABVIEWS_TIMES) > 1


def units_by_channel(before: Sequence[Sequence[str]], names: Sequence[str]) -> list[str]:
    """Units of such columns: seconds of times, and what `Y_Unit_Label` lists, one for each channel, of the others.

    Parameters
    ----------
    before
        Lines above the first row.
    names
        Of the columns.

    Raises
    ------
    InputError
        Without a file name or place: channels begin at different times, from which each counts, or count no times.
    """
    said = {row[0].strip(): [cell.strip() for cell in row[1:]] for row in before if row}
    for what in ("Date", "Time"):
        begins = list(dict.fromkeys(filter(None, said.get(what, []))))
        if len(begins) > 1:
            raise InputError(
                f"its channels count from times of their own: {what} is {begins[0]} of one and {begins[1]} of another; "
                "expected one beginning: save it with X_Columns One"
            )
    other = next((text for text in said.get("X_Dimension", []) if text and text.casefold() != "time"), "")
    if other:
        raise InputError(f"found {other} in X_Value, expected times; save it with X_Dimension Time")
    listed = iter(said.get("Y_Unit_Label", []))
    units = ["s" if name == LABVIEWS_TIMES else next(listed, "") for name in names]
    return [unit if unit_of(unit) else "" for unit in units]
