"""What is told of temperatures that are taken as they stand, though something speaks against it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gen.arrays import FloatArray
from gen.errors import InputError
from gen.importing.converted import Converted
from gen.importing.stray import stray, too_warm
from gen.importing.suspicions import suspicions
from gen.importing.switched_units import switched_at

_FIRST = 5
"""Readings, by whose median a column begins."""


def suspect(made: Converted, units: Mapping[str, str]) -> None:
    """Say what is suspicious of runs, once for each column of a table, from the run that says it first.

    Parameters
    ----------
    made
        With its runs; told what was found.
    units
        What each column of the run files was told in.
    """
    told: set[str] = set()
    for _, run in made.runs:
        found = suspicions({f"{name}_degC": values for name, values in run.temps.items()}, run.ambient, units)
        for name, (said, unit) in found.items():
            if name not in told:
                told.add(name)
                made.warnings.append(f"{made.table.label}: {name}: {said}; if so: --unit {name}={unit}")


def warn_of_readings(channels: Mapping[str, FloatArray], time: FloatArray, made: Converted) -> None:
    """Tell of readings that are taken as they stand, though no motor has them; refuse those whose unit changes.

    Parameters
    ----------
    channels
        By the column of the run file, shape (n,).
    time
        Of the rows, s, NaN where they have none, shape (n,).
    made
        Told what was found.

    Raises
    ------
    InputError
        Without a file name, with the place: from there on all temperatures are in another unit.
    """
    temps = {name: np.where(np.isfinite(time), v, np.nan) for name, v in channels.items() if name.endswith("_degC")}
    switched = switched_at(temps, time)
    if switched is not None:
        raise InputError(
            f"all temperatures go on as what they were before in {switched[1]}; expected one unit: put the rows from "
            "there on into a file of their own, and say theirs with --unit",
            place=made.table.place(switched[0]),
        )
    for name, values in temps.items():
        found = stray(values)
        if found is not None:
            made.warnings.append(
                f"{made.table.label}: {name}: {found.count} x far from the readings before and behind, first "
                f"{found.value:g} degC at {made.table.place(found.row)}: an open sensor? taken as it stands"
            )
    known = {name: values[np.isfinite(values)] for name, values in temps.items()}
    starts = {name: float(np.median(values[:_FIRST])) for name, values in known.items() if values.size}
    for name in too_warm(starts):
        made.warnings.append(
            f"{made.table.label}: {name}: begins at {starts[name]:g} degC where others begin cold: no sensor there? "
            "taken as it stands; --column with an empty name leaves it out"
        )
