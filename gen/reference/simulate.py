"""`gen simulate`: the exact solution or the board's reference simulator on a run file."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.model.exact import ExactSolution
from gen.model.extended import ExtendedSolution
from gen.reference.lanes import state_fields
from gen.reference.model import ReferenceModel, record_type
from gen.runs import Run
from gen.runs.gaps import held_over_gaps

Array = NDArray[np.float64]
Start = Literal["auto", "ambient", "measured"]

#: A time this close below a grid point, in samples, counts as on it (decimal times are not exact in binary).
_ON_GRID = 1e-6


def simulate_run(
    coefficients: Coefficients,
    run: Run,
    arithmetic: Literal["exact", "fixed", "float"],
    start: Start,
    file: str,
) -> dict[str, NDArray[np.float64] | NDArray[np.int64]]:
    """Model temperatures at the run's own times.

    Parameters
    ----------
    coefficients, run
        The model and what drives it.
    arithmetic
        ``exact`` solves the differential equation; the others compute the board's words on its grid of Ts, which
        starts at the run's first row, and give the last grid value at times off the grid.
    start
        ``measured`` starts every component from its first measured temperature, ``ambient`` from ambient; ``auto``
        from the measured one where there is one. Derivatives start at zero.
    file
        The run file's name for messages.

    Returns
    -------
    dict
        ``time_s``, ``<component>_degC``, and for fixed and float the raw state words.

    Raises
    ------
    InputError
        If no ambient is known, or `measured` is asked for where nothing was measured.
    """
    ambient = _ambient(coefficients, run, file)
    rise = {name: _initial_rise(name, run, ambient, start, file) for name in coefficients.model.component_names}
    columns: dict[str, NDArray[np.float64] | NDArray[np.int64]] = {"time_s": run.time_s}
    if arithmetic == "exact" and coefficients.effects:
        shown = _extended(coefficients, run, ambient, rise, file)
        return columns | {f"{name}_degC": values for name, values in shown.items()}
    if arithmetic == "exact":
        solved = ExactSolution(coefficients.model).simulate_times(run.time_s, run.pwm, rise)
        for name, values in solved.items():
            columns[f"{name}_degC"] = values + ambient
        return columns
    board, words = _on_board(coefficients, arithmetic, run, rise, file)
    for name, values in board.items():
        columns[f"{name}_degC"] = values + ambient
    return columns | words


def _on_board(
    coefficients: Coefficients, arithmetic: Arithmetic, run: Run, rise: dict[str, float], file: str
) -> tuple[dict[str, Array], dict[str, NDArray[np.int64]]]:
    program = lower(coefficients, arithmetic, "table")
    samples = (run.time_s - run.time_s[0]) / program.model.sample_time
    grid = np.floor(samples + _ON_GRID).astype(np.int64)
    length = int(grid[-1])
    acting = np.searchsorted(samples, np.arange(length) + _ON_GRID, side="right") - 1
    ambient, told = _told(coefficients, run, program, file)
    over = 0.0 if told is None else float(ambient[0] - told[0, 0] / 1000.0)  # rises count from what the board measures
    starts = {name: [round((value + over) * 1000.0)] for name, value in rise.items()}
    model = ReferenceModel(program, starts, None if told is None else told[:, :1])
    wanted = set(grid.tolist())
    kept: dict[int, tuple[Array, np.void]] = {}
    for step in range(length + 1):
        if step in wanted:
            kept[step] = (model.rises[:, 0], model.state_record()[0])
        if step < length:
            if told is not None:
                model.set_channels(told[:, acting[step] : acting[step] + 1])
            model.step(run.pwm[acting[step] : acting[step] + 1])
    rises = np.array([kept[int(step)][0] for step in grid])
    records = np.array([kept[int(step)][1] for step in grid], dtype=record_type(program))
    names = [name for component in program.components for name, _ in state_fields(component)]
    words = {name: records[name].astype(np.int64) for name in names}
    if told is not None:
        rises = rises + (told[0] / 1000.0 - ambient)[:, None]
    return {name: rises[:, i] for i, name in enumerate(program.model.component_names)}, words


def _told(coefficients: Coefficients, run: Run, program: Program, file: str) -> tuple[Array, NDArray[np.int64] | None]:
    """The ambient that rises count from, and what the effects on the board are told at every row, in thousandths."""
    ambient = _ambient(coefficients, run, file)
    if program.effects is None:
        return ambient, None
    measured, extras = _columns(coefficients, run, ambient, file)
    columns = [measured, *(extras[channel.column] for channel in program.effects.channels[1:])]
    return ambient, np.rint(np.array(columns) * 1000.0).astype(np.int64)


def _ambient(coefficients: Coefficients, run: Run, file: str) -> Array:
    """Ambient at every row, in degC: the measured one held over its gaps, else the file's fixed one."""
    fixed = coefficients.model.ambient_fixed
    if fixed is not None and any(applied.effect.replaces_ambient for applied in coefficients.effects):
        return np.full(len(run.time_s), fixed)  # the measured one acts through the effect
    if run.ambient is None or np.all(np.isnan(run.ambient)):
        if fixed is None:
            column = coefficients.model.ambient_channel or "ambient_degC"
            raise InputError(
                f"the column {column} is missing, and the coefficient file has no fixed ambient",
                file=file,
                place="header",
            )
        return np.full(len(run.time_s), fixed)
    return held_over_gaps(run.ambient)


def _extended(
    coefficients: Coefficients, run: Run, ambient: Array, rise: dict[str, float], file: str
) -> dict[str, Array]:
    """The model with its effects, what each sensor shows in degC."""
    measured, channels = _columns(coefficients, run, ambient, file)
    return ExtendedSolution(coefficients.model, coefficients.effects).simulate_times(
        run.time_s, run.pwm, ambient, measured, channels, rise
    )


def _columns(coefficients: Coefficients, run: Run, ambient: Array, file: str) -> tuple[Array, dict[str, Array]]:
    """The measured ambient, and the extra columns, of which the effects need some."""
    measured = ambient if run.ambient is None or np.all(np.isnan(run.ambient)) else held_over_gaps(run.ambient)
    channels = {name: held_over_gaps(column) for name, column in run.extras.items() if not np.all(np.isnan(column))}
    for applied in coefficients.effects:
        missing = [column for column in applied.columns(coefficients.model.component_names) if column not in channels]
        if run.ambient is None:
            missing += [column for _, column in applied.effect.reads(applied.values, "ambient")]
        if missing:
            raise InputError(
                f'the effect "{applied.effect.name}" of {applied.component} needs the column {missing[0]}',
                file=file,
                place="header",
            )
    return measured, channels


def _initial_rise(name: str, run: Run, ambient: Array, start: Start, file: str) -> float:
    if start == "ambient":
        return 0.0
    measured = run.temps.get(name)
    known = np.flatnonzero(~np.isnan(measured)) if measured is not None else np.zeros(0, dtype=np.int64)
    if measured is None or not known.size:
        if start == "measured":
            raise InputError("holds no measured temperature to start from", file=file, place=f"column {name}_degC")
        return 0.0
    return float(measured[known[0]] - ambient[known[0]])
