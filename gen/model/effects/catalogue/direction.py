"""Other losses in reverse."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from gen.model.effects.base import Effect, Free, Lanes, Moment, Parameters, Setting, Values, Variant


class DirectionParameters(Parameters):
    """Parameters."""

    reverse_heating: Annotated[
        float, Field(ge=-0.9, le=2.0, description="Relative change of the heating while PWM is negative.")
    ]


class Direction(Effect):
    """Brushes off the neutral line, a fan made for one direction: it runs warmer one way round."""

    name = "direction"
    title = "dependence on the direction of rotation"
    equation = "E' = d rate K/A(0) |PWM| - rate E while PWM < 0"
    parameters = DirectionParameters
    signature = "the error is there in one direction of rotation only"
    lookalikes: ClassVar[Mapping[str, str]] = {"schedule_error": "run the same speed for 2 h in each direction"}

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        if not setting.reverse:
            return []
        return [Variant({}, (Free("reverse_heating", 0.05, -0.9, 2.0),))]

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return p["reverse_heating"] * (m.heat * m.reverse)
