"""What drives a model along a run: ambient, channels and start, without gaps."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.model.network_parts import PWM
from gen.replay.meaning import check_meaning
from gen.runs import AMBIENT, Run, read_run, with_noted_ambient
from gen.runs.gaps import held_over_gaps


@dataclass(frozen=True, eq=False)
class Inputs:
    """What a model needs of a run beside its PWM; N rows, no NaN.

    Parameters
    ----------
    ambient
        What the model counts its rises from, degC, shape (N,).
    measured_ambient
        The measured ambient, degC, shape (N,), each gap held; None where none was measured.
    channels
        Extra columns that hold a value, by name, shape (N,) each, gaps held.
    first_rise
        First measured temperature of each measured component over the ambient at that row, K.
    """

    ambient: FloatArray
    measured_ambient: FloatArray | None
    channels: dict[str, FloatArray]
    first_rise: dict[str, float]


def ambient_column(coefficients: Coefficients) -> str:
    """The column that holds the ambient in this model's runs."""
    return coefficients.model.ambient_channel or AMBIENT


def read_for(coefficients: Coefficients, path: Path, *, most_rows: int | None = None) -> Run:
    """Read a run with the model's components and its ambient under their names.

    Parameters
    ----------
    coefficients
        Names them.
    path
        The run file.
    most_rows
        Thin a longer file to about as many.

    Raises
    ------
    InputError
        With file, line and column of the first fault; where the run's input stands for something else than the model's.
    """
    names = coefficients.model.component_names
    run = read_run(path, names, ambient=ambient_column(coefficients), most_rows=most_rows)
    check_meaning(coefficients, run.comments, str(path))
    return run if coefficients.model.ambient_fixed is not None else with_noted_ambient(run, str(path))


def _believed(coefficients: Coefficients, values: FloatArray) -> IntArray:
    """Rows from which a part may start: its readings in the model's range, all of them where none is."""
    low, high = coefficients.document.domain.temperature_degC
    inside = np.flatnonzero((values >= low) & (values <= high))
    return inside if inside.size else np.flatnonzero(np.isfinite(values))


def inputs_of(coefficients: Coefficients, run: Run, file: str, *, as_declared: bool = True) -> Inputs:
    """Make a run's columns a model's inputs.

    Parameters
    ----------
    coefficients
        The model with its effects.
    run
        Read with :func:`read_for`.
    file
        The run file's name for messages.
    as_declared
        Count from the measured ambient only where the coefficient file names its channel: then an effect can say what
        a fixed one misses. Else from the measured one wherever there is one, unless an effect brings it.

    Raises
    ------
    InputError
        If no ambient is known.
    """
    sensed = None if run.ambient is None or np.all(np.isnan(run.ambient)) else held_over_gaps(run.ambient)
    ambient = _counted_from(coefficients, run, sensed, as_declared, file)
    first_rise = {}
    for name, values in run.temps.items():
        known = _believed(coefficients, values)
        if known.size:
            first_rise[name] = float(values[known[0]] - ambient[known[0]])
    channels = {name: held_over_gaps(values) for name, values in run.extras.items() if not np.all(np.isnan(values))}
    network = coefficients.model.network
    if network is not None and any(channel.column == PWM for channel in network.channels):
        channels[PWM] = run.pwm.astype(np.float64)
    return Inputs(ambient, sensed, channels, first_rise)


def check_inputs(coefficients: Coefficients, channels: Collection[str], ambient: bool, file: str) -> None:
    """Find out whether a run has all that the model and its effects read.

    Parameters
    ----------
    coefficients
        The model with its effects.
    channels
        Extra columns of the run that hold a value.
    ambient
        Whether its ambient was measured.
    file
        The run file's name for messages.

    Raises
    ------
    InputError
        With the column that is missing, and the effect that reads it.
    """
    if coefficients.model.ambient_fixed is None and not ambient:
        raise _no_ambient(coefficients, file)
    network = coefficients.model.network
    for channel in network.channels if network is not None else ():
        if channel.column not in channels and channel.column != PWM:
            raise InputError(f"the network needs the column {channel.column}", file=file, place="header")
    for applied in coefficients.effects:
        missing = [column for column in applied.columns(coefficients.model.component_names) if column not in channels]
        if not ambient:
            missing += [column for _, column in applied.effect.reads(applied.values, "ambient")]
        if missing:
            raise InputError(
                f'the effect "{applied.effect.name}" of {applied.component} needs the column {missing[0]}',
                file=file,
                place="header",
            )


def _counted_from(
    coefficients: Coefficients, run: Run, sensed: FloatArray | None, as_declared: bool, file: str
) -> FloatArray:
    model = coefficients.model
    by_effect = any(applied.effect.replaces_ambient for applied in coefficients.effects)
    measured = model.ambient_channel is not None if as_declared else model.ambient_fixed is None or not by_effect
    if sensed is not None and measured:
        return sensed
    if model.ambient_fixed is None:
        raise _no_ambient(coefficients, file)
    return np.full(run.time_s.size, model.ambient_fixed)


def _no_ambient(coefficients: Coefficients, file: str) -> InputError:
    return InputError(
        f"the column {ambient_column(coefficients)} is missing, and the coefficient file has no fixed ambient; "
        f"expected the column, or a line # {AMBIENT}: 22",
        file=file,
        place="header",
    )
