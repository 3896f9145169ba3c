"""What drove the machine in a set of runs, for the coefficient file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from gen.coefficients.document import Input, StandsFor
from gen.errors import InputError
from gen.runs import Run
from gen.runs.drive import COMMENT, FULL_COUNTS, MACHINE_COMMENT, MACHINES, Drive, drive_of


def input_entry(runs: Iterable[tuple[str, Run]], full_scale: int, nominal_speed_rpm: float) -> Input:
    """The coefficient file's input, with what its counts stand for where the runs say so.

    Parameters
    ----------
    runs
        By path.
    full_scale, nominal_speed_rpm
        The count that is 100 %, and the speed there.

    Raises
    ------
    InputError
        As :func:`common_drive`.
    """
    drive = common_drive(runs)
    return Input(
        name="pwm",
        full_scale=full_scale,
        nominal_speed_rpm=nominal_speed_rpm,
        stands_for=None if drive is None or drive.is_pwm else _stands_for(drive, full_scale),
    )


def common_drive(runs: Iterable[tuple[str, Run]]) -> Drive | None:
    """What all runs that say what drove them agree on; None where none does.

    Raises
    ------
    InputError
        For a run that says another quantity, rest, or full scale, than one before it.
    """
    return agreed((path, run.comments) for path, run in runs)


def agreed(comments: Iterable[tuple[str, Mapping[str, str]]]) -> Drive | None:
    """The same from the runs' comments alone, by path."""
    first: tuple[str, Drive] | None = None
    for path, said in comments:
        found = drive_of(said)
        if found is None:
            continue
        if first is None:
            first = path, found
        before, drive = first
        if not found.agrees(drive):
            raise InputError(
                f"found {found.text()}; expected one input for all runs, and {before} has {drive.text()}"
                f"{found.remedy(drive)}",
                file=path,
                place=f"comment {COMMENT}",
            )
    return None if first is None else first[1]


def machine_of(runs: Iterable[tuple[str, Run]]) -> str:
    """What the input drives, by the runs that say it; nothing where none does.

    Parameters
    ----------
    runs
        By path.

    Returns
    -------
    str
        One of `MACHINES`, or nothing.

    Raises
    ------
    InputError
        For a run that says something else, or another machine than one before it.
    """
    first: tuple[str, str] | None = None
    for path, run in runs:
        said = run.comments.get(MACHINE_COMMENT, "").strip()
        if not said:
            continue
        if said not in MACHINES:
            message = f'found "{said}", expected {" or ".join(MACHINES)}'
            raise InputError(message, file=path, place=f"comment {MACHINE_COMMENT}")
        first = first or (path, said)
        if said != first[1]:
            message = f"found {said}; expected one machine for all runs, and {first[0]} has a {first[1]}"
            raise InputError(message, file=path, place=f"comment {MACHINE_COMMENT}")
    return "" if first is None else first[1]


def _stands_for(drive: Drive, full_scale: int) -> StandsFor:
    value = drive.rest + (drive.full_scale - drive.rest) * full_scale / FULL_COUNTS
    return StandsFor(
        quantity=drive.quantity, unit=drive.unit, full_scale=float(f"{value:.6g}"), rest=drive.rest or None
    )
