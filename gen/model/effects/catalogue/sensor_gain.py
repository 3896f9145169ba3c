"""A sensor whose reading grows too steeply or too little."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from gen.model.effects.base import Effect, Free, Lanes, Parameters, Setting, Values, Variant


class SensorGainParameters(Parameters):
    """Parameters."""

    gain_error: Annotated[float, Field(ge=-0.5, le=0.5, description="Relative: reading is (1 + g) times.")]
    about: Annotated[
        Literal["ambient", "zero_degC"], Field(description="Where the reading is right: a cold junction, or 0 degC.")
    ] = "ambient"


class SensorGain(Effect):
    """A gain error, about the cold junction's temperature or about 0 degC."""

    name = "sensor_gain"
    title = "a sensor's gain error"
    equation = "reading = T0 + (1 + g) (T - T0),  T0 the ambient or 0 degC"
    parameters = SensorGainParameters
    signature = "the error is the same share of the rise at every speed, while heating and while cooling"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "schedule_error": "hold a reference sensor to the part: a gain that is wrong everywhere looks the same",
        "radiation": "log a cool-down from hot together with a reference sensor",
        "temperature_dependent_loss": "log a cool-down from hot at PWM 0: a sensor's gain shows there too",
        "sensor_offset": "log one steady state cold and one hot",
    }
    heats = False

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        free = (Free("gain_error", 0.02, -0.5, 0.5),)
        return [Variant({"about": "ambient"}, free), Variant({"about": "zero_degC"}, free)]

    def start(self, p: Values, rise: Lanes, ambient: Lanes, measured_ambient: Lanes) -> Lanes:  # noqa: D102
        g = p["gain_error"]
        above = rise if p["about"] == "ambient" else rise + ambient
        return -g / (1.0 + g) * above

    def reading(  # noqa: D102
        self, p: Values, temperature: Lanes, ambient: Lanes, measured_ambient: Lanes, elapsed: Lanes
    ) -> Lanes:
        zero = ambient if p["about"] == "ambient" else 0.0
        return temperature + p["gain_error"] * (temperature - zero)
