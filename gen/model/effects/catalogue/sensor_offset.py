"""A sensor that reads too high or too low by the same everywhere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Lanes, Parameters, Setting, Values, Variant


class SensorOffsetParameters(Parameters):
    """Parameters."""

    offset_K: Annotated[float, Field(ge=-30.0, le=30.0, description="Reading minus temperature.")]


class SensorOffset(Effect):
    """A constant error of one sensor."""

    name = "sensor_offset"
    title = "a sensor that is off by a constant"
    equation = "reading = T + offset"
    parameters = SensorOffsetParameters
    signature = "the reading differs from ambient by the same in every run, also when the motor has been cold for long"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "ambient": "log a night at rest with the ambient sensor beside the others",
        "sensor_gain": "log one steady state cold and one hot",
        "drift": "repeat the run on another day",
    }
    heats = False
    tolerance_K = 1.1  # MAX6675 with type K as in the study, +/-1.1 degC

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        return [Variant({}, (Free("offset_K", 0.5, -30.0, 30.0),))]

    def calibrated(self, error_K: float) -> dict[str, float]:  # noqa: D102
        return {"offset_K": error_K}

    def start(self, p: Values, rise: Lanes, ambient: Lanes, measured_ambient: Lanes) -> Lanes:  # noqa: D102
        return -p["offset_K"]

    def reading(  # noqa: D102
        self, p: Values, temperature: Lanes, ambient: Lanes, measured_ambient: Lanes, elapsed: Lanes
    ) -> Lanes:
        return temperature + p["offset_K"]
