"""A sensor that follows slowly."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Lanes, Parameters, Setting, Values, Variant


class SensorLagParameters(Parameters):
    """Parameters."""

    lag_s: Annotated[float, Field(ge=1.0, le=3000.0, description="Time constant of the sensor, s.")]


class SensorLag(Effect):
    """A sensor behind paste or isolation."""

    name = "sensor_lag"
    title = "a sensor that follows slowly"
    equation = "reading' = (T - reading)/lag"
    parameters = SensorLagParameters
    signature = "the error is proportional to the temperature's slope, and gone in every steady state"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "hidden_node": "step PWM up and down within minutes: a sensor's lag is the same at every temperature",
        "schedule_error": "dip the sensor into warm water and log it",
    }
    heats = False

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        return [Variant({}, (Free("lag_s", 0.05 / setting.rate, 1.0, 3000.0, log=True),))]

    def lag(self, p: Values) -> Lanes:  # noqa: D102
        return p["lag_s"]
