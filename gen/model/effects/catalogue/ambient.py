"""An ambient that moves while the model takes it as fixed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Input, Lanes, Moment, Parameters, Setting, Tau, Values, Variant

if TYPE_CHECKING:
    from gen.model.dynamics import ThermalModel


class AmbientParameters(Parameters):
    """Parameters."""

    channel: Annotated[str, Field(description="Column with the measured ambient.")] = "ambient_degC"
    delayed: Annotated[
        bool, Field(description="The part follows the ambient through its thermal mass; else at once.")
    ] = False
    tau_s: Tau = None


class Ambient(Effect):
    """The measured ambient instead of the fixed one."""

    name = "ambient"
    title = "an ambient that moves"
    equation = "T = T_ambient measured + rise;  delayed: E' = rate (T_ambient - T_fixed) - rate E"
    parameters = AmbientParameters
    inputs = (Input("channel", of="ambient"),)
    signature = "all components are off by the same, also with the motor at rest, and follow the ambient sensor"
    everywhere = True
    tau = "tau_s"
    replaces_ambient = True
    lookalikes: ClassVar[Mapping[str, str]] = {
        "drift": "log the ambient at rest for 2 h: only the ambient comes back",
        "sensor_offset": "log a night at rest with the ambient sensor beside the others",
        "coupling": "hold the ambient constant for 2 h while the other part warms",
    }

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        if setting.ambient_fixed is None or not setting.ambient_measured:
            return []
        tau = Free("tau_s", 1.0 / setting.rate, 30.0, 40000.0, log=True, role="time constant")
        return [
            Variant({"delayed": False, "tau_s": None}),
            Variant({"delayed": True, "tau_s": None}),
            Variant({"delayed": True}, (tau,)),
        ]

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        if not p["delayed"]:
            return 0.0 * m.rate
        rate = m.rate if p["tau_s"] is None else 1.0 / p["tau_s"]
        return rate * (m.measured_ambient - m.ambient)

    def start(self, p: Values, rise: Lanes, ambient: Lanes, measured_ambient: Lanes) -> Lanes:  # noqa: D102
        return ambient - measured_ambient

    def begin(self, p: Values, ambient: Lanes, measured_ambient: Lanes) -> Lanes:  # noqa: D102
        return measured_ambient - ambient if p["delayed"] else 0.0

    def reading(  # noqa: D102
        self, p: Values, temperature: Lanes, ambient: Lanes, measured_ambient: Lanes, elapsed: Lanes
    ) -> Lanes:
        return temperature if p["delayed"] else temperature + (measured_ambient - ambient)

    def folded(self, p: Values, model: ThermalModel, component: str) -> ThermalModel | None:  # noqa: D102
        if p["delayed"]:
            return None
        return replace(model, ambient_channel=p.get("channel", "ambient_degC"))
