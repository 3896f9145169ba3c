"""Cooling by air that something else moves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Input, Lanes, Moment, Parameters, Setting, Values, Variant

WORDS = ("fan", "air", "flow", "wind", "cool", "blow")


class AirflowParameters(Parameters):
    """Parameters."""

    channel: Annotated[str, Field(description="Column of the fan's contact (0/1) or of the air's speed.")]
    cooling_per_s: Annotated[float, Field(ge=0.0, le=0.1, description="Added cooling rate k for each unit, 1/s.")]


class Airflow(Effect):
    """A fan or a draught cools while it blows."""

    name = "airflow"
    title = "cooling by moved air"
    equation = "E' = -k v T_rise - rate E"
    parameters = AirflowParameters
    inputs = (Input("channel"),)
    signature = "the temperature falls faster while the channel is on, the more the warmer the part is"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "standstill_cooling": "switch the fan while the motor runs",
        "ambient": "switch the fan at constant ambient",
        "radiation": "repeat the hottest run with the fan off, and log its contact",
    }

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        made = []
        for channel, mean in setting.channels.items():
            if (
                channel in setting.varying
                and any(word in channel.lower() for word in WORDS)
                and not channel.lower().endswith(("_degc", "_a", "_v"))
            ):
                start = 0.1 * setting.rate / max(abs(mean), 1e-3)
                made.append(Variant({"channel": channel}, (Free("cooling_per_s", min(start, 0.05), 0.0, 0.1),)))
        return made

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return 0.0 * m.rate

    def per_rise(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return -p["cooling_per_s"] * m.channels[p["channel"]]
