"""`gen simulate`: the exact solution or the board's reference simulator on a run file."""

from __future__ import annotations

from typing import Literal

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.model.exact import ExactSolution
from gen.model.extended import ExtendedSolution
from gen.model.network import Network
from gen.model.network_solution import NetworkSolution
from gen.reference.board import record_type, reference_of, state_names
from gen.replay import Inputs, check_inputs, inputs_of
from gen.runs import Run

Start = Literal["auto", "ambient", "measured"]

#: A time this close below a grid point, in samples, counts as on it (decimal times are not exact in binary).
_ON_GRID = 1e-6


def simulate_run(
    coefficients: Coefficients,
    run: Run,
    arithmetic: Literal["exact", "fixed", "float"],
    start: Start,
    file: str,
) -> dict[str, FloatArray | IntArray]:
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
        from the measured one where there is one. Derivatives start at zero, and a network's hidden nodes where they
        would rest between the others and the ambient.
    file
        The run file's name for messages.

    Returns
    -------
    dict
        ``time_s``, ``<component>_degC``, and for fixed and float the raw state words.

    Raises
    ------
    InputError
        If no ambient is known, a column that the model reads is missing, or `measured` is asked for where nothing was
        measured.
    """
    inputs = inputs_of(coefficients, run, file, as_declared=False)
    check_inputs(coefficients, inputs.channels, inputs.measured_ambient is not None, file)
    rise = {name: _initial_rise(name, inputs, start, file) for name in coefficients.model.component_names}
    columns: dict[str, FloatArray | IntArray] = {"time_s": run.time_s}
    if arithmetic == "exact":
        shown = _exact(coefficients, run, inputs, rise, start)
        return columns | {f"{name}_degC": values for name, values in shown.items()}
    if coefficients.model.network is not None:
        rise = _shown_at_start(coefficients.model.network, inputs, rise, start)
    board, words = _on_board(coefficients, arithmetic, run, inputs, rise)
    for name, values in board.items():
        columns[f"{name}_degC"] = values + inputs.ambient
    return columns | words


def _exact(
    coefficients: Coefficients, run: Run, inputs: Inputs, rise: dict[str, float], start: Start
) -> dict[str, FloatArray]:
    """Temperatures by component, degC."""
    model = coefficients.model
    if model.network is not None:
        # Where nothing was measured a node starts at ambient, and its reading then shows the sensor's offset.
        measured = {} if start == "ambient" else inputs.first_rise
        first = {name: value + float(inputs.ambient[0]) for name, value in measured.items()}
        return NetworkSolution(model).simulate_times(run.time_s, run.pwm, inputs.ambient, inputs.channels, first)
    if coefficients.effects:
        return ExtendedSolution(model, coefficients.effects).simulate_times(
            run.time_s, run.pwm, inputs.ambient, _sensed(inputs), inputs.channels, rise
        )
    solved = ExactSolution(model).over_ambient(run.time_s, run.pwm, inputs.ambient, rise)
    return {name: values + inputs.ambient for name, values in solved.items()}


def _shown_at_start(network: Network, inputs: Inputs, rise: dict[str, float], start: Start) -> dict[str, float]:
    """What each sensor shows over the ambient: its errors, where nothing was measured and the node is at ambient."""
    measured = {} if start == "ambient" else inputs.first_rise
    room = float(inputs.ambient[0])
    sensors = {node.name: node.sensor for node in network.sensed if node.sensor is not None}
    shown = {name: s.offset + s.gain_error * (room - float(s.base(room))) for name, s in sensors.items()}
    return {name: value if name in measured else shown[name] for name, value in rise.items()}


def _on_board(
    coefficients: Coefficients, arithmetic: Arithmetic, run: Run, inputs: Inputs, rise: dict[str, float]
) -> tuple[dict[str, FloatArray], dict[str, IntArray]]:
    program = lower(coefficients, arithmetic, "table")
    samples = (run.time_s - run.time_s[0]) / program.model.sample_time
    grid = np.floor(samples + _ON_GRID).astype(np.int64)
    length = int(grid[-1])
    acting = np.searchsorted(samples, np.arange(length + 1) + _ON_GRID, side="right") - 1
    told = _told(inputs, program)
    # On the board rises count from what it measures.
    over = 0.0 if told is None else float(inputs.ambient[0] - told[0, 0] / 1000.0)
    starts = {name: [round((value + over) * 1000.0)] for name, value in rise.items()}
    model = reference_of(program, starts, None if told is None else told[:, :1])
    wanted = set(grid.tolist())
    kept: dict[int, tuple[FloatArray, np.void]] = {}
    holds_temperatures = program.network is not None or program.ambient is not None
    for step in range(length + 1):
        if told is not None and program.network is not None:
            # A gain of the rise shows a temperature by the ambient at its own time.
            model.set_channels(told[:, acting[step] : acting[step] + 1])
        if step in wanted:
            # Temperatures are what is held, whatever the ambient was when they were reached.
            shown = model.readings if holds_temperatures else model.rises
            kept[step] = (shown[:, 0], model.state_record()[0])
        if step < length:
            if told is not None and program.network is None:
                model.set_channels(told[:, acting[step] : acting[step] + 1])
            model.step(run.pwm[acting[step] : acting[step] + 1])
    rises = np.array([kept[int(step)][0] for step in grid])
    records = np.array([kept[int(step)][1] for step in grid], dtype=record_type(program))
    names = state_names(program)
    words = {name: records[name].astype(np.int64) for name in names}
    if holds_temperatures:
        rises = rises - inputs.ambient[:, None]
    elif told is not None:
        rises = rises + (told[0] / 1000.0 - inputs.ambient)[:, None]
    return {name: rises[:, i] for i, name in enumerate(program.model.component_names)}, words


def _told(inputs: Inputs, program: Program) -> IntArray | None:
    """What the board is told at every row, in thousandths; the measured ambient first."""
    if not program.channels:
        return None
    columns = [_sensed(inputs), *(inputs.channels[channel.column] for channel in program.channels[1:])]
    return np.rint(np.array(columns) * 1000.0).astype(np.int64)


def _sensed(inputs: Inputs) -> FloatArray:
    """The measured ambient; where there is none the one that rises count from."""
    return inputs.ambient if inputs.measured_ambient is None else inputs.measured_ambient


def _initial_rise(name: str, inputs: Inputs, start: Start, file: str) -> float:
    if start == "ambient":
        return 0.0
    if start == "measured" and name not in inputs.first_rise:
        raise InputError("holds no measured temperature to start from", file=file, place=f"column {name}_degC")
    return inputs.first_rise.get(name, 0.0)
