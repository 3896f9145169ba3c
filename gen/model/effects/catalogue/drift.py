"""A reading that creeps away."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Lanes, Parameters, Setting, Values, Variant


class DriftParameters(Parameters):
    """Parameters."""

    drift_K_per_h: Annotated[float, Field(ge=-20.0, le=20.0, description="Growth of the error since switching on.")]


class Drift(Effect):
    """An amplifier or a cold junction that warms up with the electronics."""

    name = "drift"
    title = "slow drift of the reading"
    equation = "reading = T + d t,  t since the start of the run"
    parameters = DriftParameters
    signature = "the error grows with the time since switching on, whatever the motor does"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "ambient": "log the ambient, and a run at rest for 2 h",
        "sensor_offset": "repeat the run on another day",
        "schedule_error": "run one speed for twice as long: a drift goes on in the steady state",
    }
    heats = False

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        return [Variant({}, (Free("drift_K_per_h", 0.2, -20.0, 20.0),))]

    def reading(  # noqa: D102
        self, p: Values, temperature: Lanes, ambient: Lanes, measured_ambient: Lanes, elapsed: Lanes
    ) -> Lanes:
        return temperature + p["drift_K_per_h"] * (elapsed / 3600.0)
