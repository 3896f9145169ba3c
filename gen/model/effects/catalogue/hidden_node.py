"""A hot part without a sensor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Lanes, Moment, Parameters, Setting, Tau, Values, Variant


class HiddenNodeParameters(Parameters):
    """Parameters."""

    heating_K_per_s: Annotated[
        float, Field(ge=0.0, le=10.0, description="Heat flow g from the hidden part, warm at full scale, as heating.")
    ]
    node_tau_s: Annotated[float, Field(ge=5.0, le=40000.0, description="Time constant of the hidden part, s.")]
    exponent: Annotated[int, Field(ge=1, le=2, description="Its heating grows with |PWM| or with its square.")] = 1
    exchange: Annotated[
        bool, Field(description="The steady heat flow is in the baseline's gain already: only the delay is added.")
    ] = False
    tau_s: Tau = None


class HiddenNode(Effect):
    """A part inside warms up first, and goes on giving heat when the motor has stopped."""

    name = "hidden_node"
    title = "a hot part without a sensor"
    equation = "H' = ((|PWM|/full)^n - H)/tau_node;  E' = g H - rate E  (exchange: g (H - (|PWM|/full)^n))"
    parameters = HiddenNodeParameters
    signature = "the temperature goes on rising after a cut-off from hot"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "standstill_cooling": "log a cut-off from hot for 2 h: a hidden part lifts the temperature first, then it "
        "fades; another cooling changes the rate throughout",
        "schedule_error": "log a cut-off from hot",
        "sensor_lag": "step PWM up and down within minutes: a sensor's lag is the same at every temperature",
        "coupling": "log a run in which only the other part is warm",
        "initial_state": "start a run from cold",
    }
    tau = "tau_s"

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        g = Free("heating_K_per_s", 5.0 * setting.rate, 0.0, 10.0)
        node = Free("node_tau_s", 0.5 / setting.rate, 30.0, 30000.0, log=True, role="time constant")
        tau = Free("tau_s", 1.0 / setting.rate, 30.0, 30000.0, log=True, role="time constant")
        return [
            Variant({"exponent": 1, "exchange": False, "tau_s": None}, (g, node)),
            Variant({"exponent": 2, "exchange": False, "tau_s": None}, (g, node)),
            Variant({"exponent": 1, "exchange": True, "tau_s": None}, (g, node)),
            Variant({"exponent": 1, "exchange": False}, (g, node, tau)),
        ]

    def inner(self, p: Values, m: Moment) -> tuple[Lanes, Lanes] | None:  # noqa: D102
        return m.pwm ** p["exponent"], p["node_tau_s"]

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        warm = m.inner - m.pwm ** p["exponent"] if p["exchange"] else m.inner
        return p["heating_K_per_s"] * warm
