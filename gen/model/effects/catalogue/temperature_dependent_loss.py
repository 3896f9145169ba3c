"""Heating that changes with temperature."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Lanes, Moment, Parameters, Setting, Values, Variant


class TemperatureDependentLossParameters(Parameters):
    """Parameters."""

    coefficient_per_K: Annotated[
        float,
        Field(ge=-0.02, le=0.02, description="Relative change of the heating for each K of rise (copper: +0.0039)."),
    ]


class TemperatureDependentLoss(Effect):
    """Copper's resistance grows with temperature, a magnet's flux falls: the gain changes with the rise."""

    name = "temperature_dependent_loss"
    title = "heating (gain) that changes with temperature"
    equation = "E' = rate K/A(0) |PWM| alpha T_rise - rate E"
    parameters = TemperatureDependentLossParameters
    signature = "the error grows with the own temperature while the motor is driven, and not while it cools at PWM 0"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "radiation": "cool down from hot at PWM 0: only a loss acts there, no heating",
        "sensor_gain": "log a cool-down from hot at PWM 0: a sensor's gain shows there too",
        "schedule_error": "reach the same temperature at another speed",
    }

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        return [Variant({}, (Free("coefficient_per_K", 0.0005, -0.02, 0.02),))]

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return 0.0 * m.heat

    def per_rise(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return p["coefficient_per_K"] * m.heat
