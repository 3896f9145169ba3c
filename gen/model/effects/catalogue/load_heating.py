"""Copper losses of a measured current."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Input, Lanes, Moment, Parameters, Setting, Tau, Values, Variant


class LoadHeatingParameters(Parameters):
    """Parameters."""

    channel: Annotated[str, Field(description="Column with the current in A.")] = "current_A"
    heating_K_per_s_A2: Annotated[float, Field(ge=0.0, le=1.0, description="Heating r for each A^2.")]
    reference_A: Annotated[
        float, Field(ge=0.0, le=1e4, description="Current I0 whose heating the baseline's gain holds already.")
    ] = 0.0
    tau_s: Tau = None


class LoadHeating(Effect):
    """Heat that grows with the square of the current."""

    name = "load_heating"
    title = "heating by the load current (I^2 R)"
    equation = "E' = r (I^2 - I0^2) - rate E"
    parameters = LoadHeatingParameters
    inputs = (Input("channel", units=("_A",), quantity="current", neutral="reference_A"),)
    tau = "tau_s"
    signature = "the residual follows the current squared, at one and the same PWM"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "supply_voltage": "vary the load at constant supply voltage, and log both",
        "schedule_error": "vary the load at constant PWM for 2 h",
        "temperature_dependent_loss": "vary the load at constant PWM for 2 h",
    }

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        made = []
        for channel in setting.ending("_A"):
            scale = max(setting.channels[channel] ** 2, 1e-6)
            free = Free("heating_K_per_s_A2", min(5.0 * setting.rate / scale, 0.5), 0.0, 1.0)
            made.append(Variant({"channel": channel, "tau_s": None}, (free,)))
            reference = Free("reference_A", 0.5 * scale**0.5, 0.0, 2.0 * scale**0.5, role="reference")
            made.append(Variant({"channel": channel, "tau_s": None}, (free, reference)))
            tau = Free("tau_s", 1.0 / setting.rate, 20.0, 40000.0, log=True, role="time constant")
            made.append(Variant({"channel": channel}, (free, tau)))
        return made

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return p["heating_K_per_s_A2"] * (m.channels[p["channel"]] ** 2 - p.get("reference_A", 0.0) ** 2)
