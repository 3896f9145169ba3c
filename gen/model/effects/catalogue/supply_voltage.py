"""Another supply voltage than the one at which the model was identified."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Input, Lanes, Moment, Parameters, Setting, Values, Variant


class SupplyVoltageParameters(Parameters):
    """Parameters."""

    channel: Annotated[str, Field(description="Column with the supply voltage in V.")] = "voltage_V"
    sensitivity: Annotated[
        float, Field(ge=-3.0, le=3.0, description="Share s of the heating that follows the voltage squared.")
    ] = 1.0
    nominal_V: Annotated[float, Field(gt=0.0, le=1000.0, description="Voltage V0 of the identification.")]


class SupplyVoltage(Effect):
    """A PWM count means another voltage at the motor when the supply sags."""

    name = "supply_voltage"
    title = "dependence on the supply voltage"
    equation = "E' = s ((V/V0)^2 - 1) rate K/A(0) |PWM| - rate E"
    parameters = SupplyVoltageParameters
    inputs = (Input("channel", units=("_V",), quantity="supply voltage", neutral="nominal_V"),)
    signature = "the error follows the supply's voltage, at one and the same PWM"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "load_heating": "vary the load at constant supply voltage, and log both",
        "schedule_error": "repeat a speed at another supply voltage",
    }

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        made = []
        for channel in setting.ending("_V"):
            mean = setting.channels[channel]
            if mean > 0.5:
                nominal = Free("nominal_V", mean, 0.6 * mean, 1.6 * mean, log=True, role="reference")
                made.append(Variant({"channel": channel}, (Free("sensitivity", 0.7, -3.0, 3.0), nominal)))
        return made

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return p["sensitivity"] * ((m.channels[p["channel"]] / p["nominal_V"]) ** 2 - 1.0) * m.heat
