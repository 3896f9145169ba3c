"""Other cooling at standstill than the schedules' extrapolation to PWM 0."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field

from gen.model.dynamics import PWM_LEVELS
from gen.model.effects.base import Effect, Free, Lanes, Moment, Parameters, Setting, Values, Variant

if TYPE_CHECKING:
    from gen.model.dynamics import ThermalModel


class StandstillCoolingParameters(Parameters):
    """Parameters."""

    cooling_factor: Annotated[
        float, Field(ge=0.02, le=50.0, description="Factor of the component's poles at PWM 0: below 1 it cools slower.")
    ]


class StandstillCooling(Effect):
    """Without rotation no air is moved: the cooling at PWM 0 is another one than at the lowest identified speed."""

    name = "standstill_cooling"
    title = "different cooling at standstill"
    equation = "poles(0) multiplied by f:  E' = -(f - 1) rate T_rise - rate E while PWM = 0"
    parameters = StandstillCoolingParameters
    signature = "the error arises while PWM is 0 and the part is warm, and fades while the motor turns"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "hidden_node": "log a cut-off from hot for 2 h: a hidden part lifts the temperature first, then it fades; "
        "another cooling changes the rate throughout",
        "airflow": "switch the fan while the motor runs",
        "radiation": "stop the motor from two different temperatures",
    }

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        if 0 not in setting.levels:
            return []
        return [Variant({}, (Free("cooling_factor", 1.3, 0.02, 50.0, log=True),))]

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return 0.0 * m.rate

    def per_rise(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return (1.0 - p["cooling_factor"]) * (m.standstill * m.rate)

    def folded(self, p: Values, model: ThermalModel, component: str) -> ThermalModel | None:  # noqa: D102
        from gen.model.effects.tables import scaled

        if model.component(component).order > 1:
            return None  # other cooling changes A(0) alone, which no factor on its poles does
        rate = np.ones(PWM_LEVELS)
        rate[0] = p["cooling_factor"]
        return scaled(model, component, np.ones(PWM_LEVELS), rate)
