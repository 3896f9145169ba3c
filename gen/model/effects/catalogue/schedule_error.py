"""Schedules that are wrong at some speeds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field, model_validator

from gen.arrays import FloatArray
from gen.model.dynamics import MAX_PWM, PWM_LEVELS
from gen.model.effects.base import Effect, Free, Lanes, Moment, Parameters, Setting, Values, Variant

if TYPE_CHECKING:
    from gen.model.dynamics import ThermalModel


REACH = 20
"""How far from a speed its own correction is believed, in counts."""


class ScheduleErrorParameters(Parameters):
    """Parameters."""

    pwm: Annotated[
        tuple[Annotated[int, Field(ge=0, le=MAX_PWM)], ...], Field(min_length=1, description="|PWM| in counts, rising.")
    ]
    gain_factor: Annotated[
        tuple[Annotated[float, Field(ge=0.02, le=20.0)], ...],
        Field(min_length=1, description="Factor of the steady rise there; linear between, held outside."),
    ]
    rate_factor: Annotated[float, Field(ge=0.1, le=10.0, description="Factor of all poles, at every speed.")] = 1.0
    peak_factor: Annotated[
        float, Field(ge=0.02, le=20.0, description="Factor of the steady rise at the middle of a bump.")
    ] = 1.0
    middle_pwm: Annotated[
        float, Field(ge=0.0, le=float(MAX_PWM), description="|PWM| at the bump's middle, counts.")
    ] = 128.0
    width_pwm: Annotated[float, Field(ge=5.0, le=128.0, description="Where the bump has fallen to 1/e, counts.")] = 40.0

    @model_validator(mode="after")
    def _check(self) -> ScheduleErrorParameters:
        if len(self.pwm) != len(self.gain_factor):
            raise ValueError(f"{len(self.gain_factor)} factors for {len(self.pwm)} PWM levels")
        if any(b <= a for a, b in zip(self.pwm, self.pwm[1:], strict=False)):
            raise ValueError("pwm must rise strictly")
        return self


class ScheduleError(Effect):
    """Between identified speeds, and where a fit of the schedule was poor, gain and poles are off."""

    name = "schedule_error"
    title = "a wrong schedule at some speeds"
    equation = (
        "steady rise multiplied by c(|PWM|) (a table, and a bump), poles by f:  "
        "E' = rate (f c - 1) K/A(0) |PWM| - (f - 1) rate T - rate E"
    )
    parameters = ScheduleErrorParameters
    signature = "the steady error belongs to the speed, and comes back each time that the speed does"
    lookalikes: ClassVar[Mapping[str, str]] = {
        "load_heating": "vary the load at constant PWM for 2 h",
        "sensor_gain": "hold a reference sensor to the part: a gain that is wrong everywhere looks the same",
        "radiation": "reach the same temperature at another speed",
        "hidden_node": "log a cut-off from hot",
        "direction": "run the same speed for 2 h in each direction",
    }
    over_pwm = "pwm"
    of_single_speeds = True

    def variants(self, setting: Setting) -> list[Variant]:  # noqa: D102
        levels = tuple(level for level in setting.levels if level > 0)
        if not levels:
            return []
        gains = tuple(Free(f"gain_factor[{i}]", 1.0, 0.02, 20.0, log=True, role="level") for i in range(len(levels)))
        rate = Free("rate_factor", 1.02, 0.1, 10.0, log=True, role="shape")
        one = Variant({"pwm": (levels[0],)}, (gains[0], rate))
        bump = (
            Free("peak_factor", 1.0, 0.02, 20.0, log=True),
            Free("middle_pwm", 130.0, float(levels[0]), float(levels[-1]), role="shape"),
            Free("width_pwm", 35.0, 10.0, 90.0, log=True, role="shape"),
        )
        flat = {"pwm": (levels[0],), "gain_factor": (1.0,), "rate_factor": 1.0}
        made = [one, Variant({"pwm": levels, "rate_factor": 1.0}, gains), Variant({"pwm": levels}, (*gains, rate))]
        if len(levels) > 5:
            knots = tuple(int(x) for x in np.rint(np.linspace(levels[0], levels[-1], 5)))
            made.append(Variant({"pwm": knots, "rate_factor": 1.0}, gains[:5]))
        if len(levels) > 2:
            made.append(Variant(flat, bump, also=((1.0, 80.0, 35.0), (1.0, 180.0, 35.0), (1.0, 225.0, 35.0))))
        return made

    def local(self, setting: Setting) -> Variant | None:
        """A factor at each speed that was run, 1 again :data:`REACH` counts away: nothing is said of other speeds."""
        levels = tuple(level for level in setting.levels if level > 0)
        if not levels:
            return None
        pwm: list[int] = []
        known: list[bool] = []
        for level in levels:
            for count, own in ((level - REACH, False), (level, True), (level + REACH, False)):
                if 0 < count <= MAX_PWM and (not pwm or count > pwm[-1]):
                    pwm.append(count)
                    known.append(own)
        free = tuple(
            Free(f"gain_factor[{i}]", 1.0, 0.02 if own else 1.0, 20.0 if own else 1.0, log=True, role="level")
            for i, own in enumerate(known)
        )
        return Variant({"pwm": tuple(pwm), "rate_factor": 1.0}, free)

    def heat(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        factor = _factor(m.count, p)
        return (p["rate_factor"] * factor - 1.0) * m.heat

    def per_rise(self, p: Values, m: Moment) -> Lanes:  # noqa: D102
        return (1.0 - p["rate_factor"]) * m.rate

    def folded(self, p: Values, model: ThermalModel, component: str) -> ThermalModel | None:  # noqa: D102
        from gen.model.effects.tables import scaled

        if p["rate_factor"] != 1.0 and model.component(component).order > 1:
            return None  # a rate of heat exchange changes A(0) alone, which no factor on its poles does
        steady = np.asarray(_factor(np.arange(float(PWM_LEVELS)), p) + np.zeros(PWM_LEVELS))
        return scaled(model, component, steady, np.full(PWM_LEVELS, float(p["rate_factor"])))


def _factor(count: FloatArray, p: Values) -> Lanes:
    factor = interpolated(count, p["pwm"], p["gain_factor"])
    if "peak_factor" not in p:
        return factor
    return factor * (1.0 + (p["peak_factor"] - 1.0) * np.exp(-(((count - p["middle_pwm"]) / p["width_pwm"]) ** 2)))


def interpolated(count: FloatArray, levels: tuple[int, ...], factors: Lanes) -> Lanes:
    """Linear interpolation whose values may be arrays of lanes; the end values hold outside."""
    if len(levels) == 1:
        return factors[0]
    made: Lanes = 0.0
    for i, level in enumerate(levels):
        weight = np.ones_like(count)
        if i > 0:
            weight = weight * np.clip((count - levels[i - 1]) / (level - levels[i - 1]), 0.0, 1.0)
        if i + 1 < len(levels):
            weight = weight * np.clip((levels[i + 1] - count) / (levels[i + 1] - level), 0.0, 1.0)
        made = made + weight * factors[i]
    return made
