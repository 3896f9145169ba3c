"""A log that begins while the inside is warmer than the sensors say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Lanes, Moment, Parameters, Setting, Values, Variant


class InitialStateParameters(Parameters):
    """Parameters."""

    soak_per_s: Annotated[
        float,
        Field(
            ge=-0.05, le=0.05, description="Heating by the inside, k, for each K of the component's rise at the start."
        ),
    ]
    soak_tau_s: Annotated[float, Field(ge=5.0, le=40000.0, description="Time in which the inside evens out, s.")]


class InitialState(Effect):
    """Warm start: heat stored inside comes out; runs that start cold know nothing of it."""

    name = "initial_state"
    title = "a warm start with heat stored inside"
    equation = "E' = k T_rise(0) exp(-t/tau) - rate E"
    parameters = InitialStateParameters
    signature = "the error arises in the first minutes of runs that start warm, and in no run that starts cold"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "hidden_node": "start a run from cold",
        "standstill_cooling": "log a cut-off from hot within a run",
        "sensor_lag": "start a run from cold",
    }

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        if not setting.warm:
            return []
        k = Free("soak_per_s", 0.2 * setting.rate, -0.05, 0.05)
        tau = Free("soak_tau_s", 0.3 / setting.rate, 5.0, 40000.0, log=True, role="time constant")
        return [Variant({}, (k, tau))]

    def inner(self, p: Values, m: Moment) -> tuple[Lanes, Lanes] | None:  # noqa: D102
        return 0.0 * m.rate, p["soak_tau_s"]

    def inner_start(self, p: Values, rise: Lanes) -> Lanes:  # noqa: D102
        return rise

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return p["soak_per_s"] * m.inner
