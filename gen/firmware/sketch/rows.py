"""The rows of the console's log, and the buffer that they leave from."""

from __future__ import annotations

import math
from typing import TypedDict

from gen.coefficients import Coefficients
from gen.coefficients.wiring import Wiring
from gen.firmware.sketch.sensors import ThermocoupleContext

LOOK_AHEAD = ("time_to_limit_s", "holdable_pwm")
"""Seconds for which no limit is reached at the PWM that is asked for; the largest |PWM| that can be held."""
_LINE_BYTES = 110
"""Longest line that is not a row (output.h)."""


class RowsContext(TypedDict):
    """The rows of the console's log and the buffer that they leave from."""

    row_samples: int
    row_every: str
    columns: list[str]
    row_bytes: int
    ring_bytes: int
    ambient_column: str


def rows_context(
    coefficients: Coefficients, wiring: Wiring, chips: list[ThermocoupleContext], *, protects: bool
) -> RowsContext:
    """Describe the rows of a wiring; `protects`: the board acts on something."""
    sample_time = coefficients.model.sample_time
    samples = max(1, round(wiring.row_every_s / sample_time))
    columns = _columns(coefficients, chips, wiring)
    columns += ["protection"] if protects else []
    columns += LOOK_AHEAD if coefficients.document.forecast is not None else ()
    longest = _row_bytes(columns)
    return {
        "row_samples": samples,
        "row_every": f"{samples * sample_time:g}",
        "columns": columns,
        "row_bytes": longest,
        "ring_bytes": 1 << math.ceil(math.log2(longest + max(longest, 2 * _LINE_BYTES))),
        "ambient_column": _ambient_column(coefficients),
    }


def _ambient_column(coefficients: Coefficients) -> str:
    return coefficients.model.ambient_channel or "ambient_degC"


def _columns(coefficients: Coefficients, chips: list[ThermocoupleContext], wiring: Wiring) -> list[str]:
    """The run file's columns, in the order in which the console prints a row."""
    wired = {chip["channel"] for chip in chips}
    names = coefficients.document.component_names
    columns = ["time_s", "pwm", *(f"{name}_degC" for name in names if name in wired)]
    columns += [_ambient_column(coefficients)] if "ambient" in wired else []
    columns += [channel.column for channel in wiring.channels]
    columns += coefficients.document.thermocouple_columns
    columns += ["speed_rpm"] if wiring.encoder else []
    columns += [f"{name}_model_degC" for name in names]
    columns += ["flags"]
    columns += ["sensors"] if chips else []
    columns += ["alarms"] if coefficients.document.alarms else []
    return columns


def _row_bytes(columns: list[str]) -> int:
    """Longest row: each field at its longest (thousandths of 32 bits, 16-bit numbers, 17 digits of sensors), commas."""
    longest = {"time_s": 14, "pwm": 4, "speed_rpm": 5, "flags": 5, "sensors": 17, "alarms": 5, "protection": 11}
    longest |= {"time_to_limit_s": 8, "holdable_pwm": 4}
    return sum(longest.get(column, 12) + 1 for column in columns) + 1
