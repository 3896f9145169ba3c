"""Loss that grows faster than the rise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Lanes, Moment, Parameters, Setting, Values, Variant

ZERO_C = 273.15


class RadiationParameters(Parameters):
    """Parameters."""

    loss_K_per_s_1e8K4: Annotated[
        float, Field(ge=0.0, le=1.0, description="Cooling k for each 1e8 K^4 of difference of T^4.")
    ]


class Radiation(Effect):
    """Radiated heat, over the linear loss that the poles hold."""

    name = "radiation"
    title = "loss that grows faster than the rise (radiation)"
    equation = "E' = -k ((T/100)^4 - (Ta/100)^4) - rate E,  T and Ta in kelvin"
    parameters = RadiationParameters
    signature = "the model is too warm where it is warmest, at every speed by the same curve over the temperature"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "temperature_dependent_loss": "cool down from hot at PWM 0: only a loss acts there, no heating",
        "sensor_gain": "log a cool-down from hot together with a reference sensor",
        "schedule_error": "reach the same temperature at another speed",
        "airflow": "repeat the hottest run with the fan off, and log its contact",
    }
    nonlinear = True

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        return [Variant({}, (Free("loss_K_per_s_1e8K4", 0.1 * setting.rate, 0.0, 1.0),))]

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        surroundings = (m.ambient + ZERO_C) / 100.0
        warm = surroundings + m.rise / 100.0
        loss = p["loss_K_per_s_1e8K4"] * (warm**4 - surroundings**4)
        return -loss - self.per_rise(p, m) * m.rise

    def per_rise(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        warm = (m.ambient + m.rise + ZERO_C) / 100.0
        return -p["loss_K_per_s_1e8K4"] * (0.04 * warm**3)
