"""What a coefficient file and run files tell of the motor that a board is to be wired to."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from gen.coefficients import Coefficients
from gen.coefficients.names import name_fault
from gen.errors import InputError
from gen.model.dynamics import MAX_PWM
from gen.model.network_parts import PWM
from gen.replay import ambient_column, read_for
from gen.runs import AMBIENT, Run, read_run

SPEED = "speed_rpm"
CURRENT = "current_A"
_DEGREES = "_degC"
_BESIDE = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,25}_degC")

Range = tuple[float, float]


@dataclass(frozen=True)
class Motor:
    """What is known.

    Attributes
    ----------
    parts
        Names of the parts that the board is to watch.
    ambient
        Why the ambient is to be measured; None if nothing says so.
    beside
        Further temperatures by their columns (``gearbox_degC``), and why.
    channels
        Further channels by their columns: their range, None if nothing tells it, and why.
    speed
        Why the speed is to be measured, or None.
    speeds
        Lowest and highest |PWM| at which the motor was seen turning, or for which the model holds.
    full_scale
        The count that is 100 %.
    left_out
        Temperatures whose columns cannot be one of the board's.
    hours
        How long the logs are together.
    """

    parts: tuple[str, ...]
    ambient: str | None = None
    beside: dict[str, str] = field(default_factory=dict)
    channels: dict[str, tuple[Range | None, str]] = field(default_factory=dict)
    speed: str | None = None
    speeds: tuple[int, int] = (1, MAX_PWM)
    full_scale: int = MAX_PWM
    left_out: tuple[str, ...] = ()
    hours: float = 0.0


def of_model(coefficients: Coefficients) -> Motor:
    """What a coefficient file says: its parts, and what its model reads beside the PWM."""
    document, model = coefficients.document, coefficients.model
    reads: dict[str, tuple[Range | None, str]] = {}
    if model.network is not None:
        for channel in model.network.channels:
            if channel.column != PWM:
                reads[channel.column] = ((channel.low, channel.high), "a channel of the network")
    ambient = None if document.ambient.channel is None else "the model counts from the measured ambient"
    for applied in coefficients.effects:
        for column in applied.columns(model.component_names):
            reads.setdefault(column, (None, f'read by the effect "{applied.effect.name}" of {applied.component}'))
        if applied.effect.reads(applied.values, "ambient"):
            ambient = f'the effect "{applied.effect.name}" reads the ambient'
    low, high = document.validity.pwm
    return Motor(
        parts=tuple(model.component_names),
        ambient=ambient,
        beside={column: why for column, (_, why) in reads.items() if column.endswith(_DEGREES)},
        channels={column: found for column, found in reads.items() if not column.endswith(_DEGREES)},
        speeds=(min(max(low, 1), high), high),
        full_scale=document.input.full_scale,
    )


def of_runs(paths: Sequence[Path], coefficients: Coefficients | None) -> Motor:
    """What run files hold, and what a coefficient file says beside them.

    Parameters
    ----------
    paths
        At least one run file.
    coefficients
        Names the parts; without it every measured temperature is one.

    Raises
    ------
    InputError
        With file, line and column of what is wrong, or when the logs hold no temperature.
    """
    motor = Motor(()) if coefficients is None else of_model(coefficients)
    levels: set[int] = set()
    for path in paths:
        run = read_run(path) if coefficients is None else read_for(coefficients, path)
        motor = _with_run(motor, run, path, coefficients)
        levels |= set(np.unique(np.abs(run.pwm[run.pwm != 0])).tolist())
    if not motor.parts:
        raise InputError("no column with a temperature (PART_degC) holds a value", file=str(paths[0]), place="header")
    if coefficients is None and levels:
        motor = replace(motor, speeds=(min(levels), max(levels)))
    return motor


def _with_run(motor: Motor, run: Run, path: Path, coefficients: Coefficients | None) -> Motor:
    """The motor with what one more run shows of it."""
    parts, beside, channels = list(motor.parts), dict(motor.beside), dict(motor.channels)
    left_out = dict.fromkeys(motor.left_out)
    for name, values in run.temps.items():
        if np.isfinite(values).any() and name not in parts:
            if problem := name_fault(name):
                raise InputError(problem, file=str(path), place=f"column {name}{_DEGREES}")
            parts.append(name)
    for column, values in run.extras.items():
        known = values[np.isfinite(values)]
        if not known.size or _is_the_boards(column, run):
            continue
        seen = (float(known.min()), float(known.max()))
        if column in channels:
            channels[column] = (channels[column][0] or seen, channels[column][1])
        elif column == CURRENT and coefficients is None:
            channels[column] = (seen, "measured in the logs")
        elif _BESIDE.fullmatch(column):
            beside.setdefault(column, "measured in the logs; the model has no such part")
        elif column.endswith(_DEGREES):
            left_out[column] = None
    measured = run.ambient is not None and bool(np.isfinite(run.ambient).any())
    column = AMBIENT if coefficients is None else ambient_column(coefficients)
    return replace(
        motor,
        parts=tuple(parts),
        beside=beside,
        channels=channels,
        left_out=tuple(left_out),
        hours=motor.hours + float(run.time_s[-1] - run.time_s[0]) / 3600.0,
        ambient=motor.ambient or (f"the logs hold {column}" if measured else None),
        speed=motor.speed or (f"the logs hold {SPEED}" if SPEED in run.extras and SPEED not in channels else None),
    )


def _is_the_boards(column: str, run: Run) -> bool:
    """Whether a column is what a board's own model said."""
    return column.endswith(f"_model{_DEGREES}") and f"{column.removesuffix(f'_model{_DEGREES}')}" in run.temps
