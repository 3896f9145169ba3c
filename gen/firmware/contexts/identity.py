"""What every template may use: whose project it is."""

from __future__ import annotations

from typing import TypedDict

from gen.coefficients import Coefficients
from gen.coefficients.sample_time import milliseconds
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.program import Program
from gen.version import __version__

#: Used while no ambient is given or measured, in degC.
ROOM_degC = 25.0


class Identity(TypedDict):
    """Names, origin and the figures of the whole model.

    `ambient_mC` is in thousandths of a degree Celsius; `validity` and `domain` are the ends of ranges of |PWM|.
    `input_meaning` says what the counts stand for, where they are not a motor's PWM, and is empty else.
    """

    name: str
    NAME: str
    title: str
    version: str
    source_name: str
    sha256: str
    arithmetic: Arithmetic
    schedule: ScheduleKind
    sample_time: str
    sample_ms: int
    full_scale: int
    input_meaning: str
    ambient_mC: int
    validity: tuple[int, int]
    domain: tuple[int, int]


def identity(coefficients: Coefficients, program: Program, source_name: str) -> Identity:
    """Whose project it is.

    Parameters
    ----------
    coefficients, program
        What is emitted.
    source_name
        The coefficient file's name as comments show it.

    Raises
    ------
    InputError
        When the sample time is no whole number of milliseconds.
    """
    model = program.model
    return {
        "name": model.name,
        "NAME": model.name.upper(),
        "title": f"Thermal model of {model.name}",
        "version": __version__,
        "source_name": source_name,
        "sha256": coefficients.sha256,
        "arithmetic": program.arithmetic,
        "schedule": program.schedule,
        "sample_time": f"{model.sample_time:g}",
        "sample_ms": milliseconds(model.sample_time),
        "full_scale": model.full_scale,
        "input_meaning": coefficients.document.input.meaning,
        "ambient_mC": round((model.ambient_fixed if model.ambient_fixed is not None else ROOM_degC) * 1000.0),
        "validity": model.validity,
        "domain": model.domain_pwm,
    }
