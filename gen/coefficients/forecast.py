"""How long the motor may run on: limits that the board runs ahead to, and how far."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

from pydantic import Field

from gen.coefficients.alarms import AlarmRule, OverTemperature
from gen.coefficients.base import Celsius, NotNegative, Part, Positive, fault, listed

MOST_LIMITS = 16
"""As many as a motor has parts."""

LEAST_STEPS_TO_HOLD = 8
"""So fast a run has to be for a motor to be held by it: an answer that is older than the horizon is none, and between
two of them lie three runs at most."""


class ForecastLimit(Part):
    """A temperature that a part should not reach."""

    component: Annotated[str, Field(description="A component; of a network any node, also one that nobody measures.")]
    limit_degC: Celsius


class Forecast(Part):
    """The board's own model, run ahead between the samples until a limit is reached."""

    horizon_s: Annotated[Positive, Field(le=86400, description="So far ahead, in s.")]
    steps_per_sample: Annotated[
        int, Field(ge=1, le=4096, description="Samples that it goes ahead within each sample of the board.")
    ] = 32
    limits: Annotated[
        tuple[ForecastLimit, ...],
        Field(
            max_length=MOST_LIMITS,
            description="Limits beside those of the over-temperature rules; of a rule's component: in its place.",
        ),
    ] = ()
    near_s: Annotated[
        NotNegative | None,
        Field(description='The cause "limit_near" begins when a limit is as near as this, in s.'),
    ] = None


def limits_ahead(forecast: Forecast, alarms: Sequence[AlarmRule]) -> dict[str, float]:
    """Limit of every part that is watched ahead, degC, by its name: the forecast's own first, then the rules'.

    Parameters
    ----------
    forecast, alarms
        The file's; of several rules on a part the lowest limit holds.
    """
    found = {limit.component: limit.limit_degC for limit in forecast.limits}
    own = set(found)
    for rule in alarms:
        if isinstance(rule, OverTemperature) and rule.component not in own:
            found[rule.component] = min(rule.limit_degC, found.get(rule.component, rule.limit_degC))
    return found


def check_forecast(forecast: Forecast, alarms: Sequence[AlarmRule], names: Sequence[str], sample_time_s: float) -> None:
    """Check what is to be watched.

    Parameters
    ----------
    forecast, alarms
        The file's.
    names
        Components, and the nodes of a network.
    sample_time_s
        In s.

    Raises
    ------
    PydanticCustomError
        At a limit of a part that there is not, or that is named twice; if there is none; if the horizon is shorter than
        a sample, or than what is near.
    """
    seen: set[str] = set()
    for i, limit in enumerate(forecast.limits):
        at = ("forecast", "limits", i, "component")
        if limit.component not in names:
            raise fault(f'found "{limit.component}", expected {listed(list(names))}', *at)
        if limit.component in seen:
            raise fault(f'found "{limit.component}" again, expected one limit for each part', *at)
        seen.add(limit.component)
    if not limits_ahead(forecast, alarms):
        raise fault('no limit to run ahead to; expected "limits", or an over-temperature rule', "forecast")
    if forecast.horizon_s < sample_time_s:
        raise fault(
            f"found {forecast.horizon_s:g}, expected the sample time, {sample_time_s:g}, or more",
            "forecast",
            "horizon_s",
        )
    if forecast.near_s is not None and forecast.near_s > forecast.horizon_s:
        raise fault(
            f"found {forecast.near_s:g}, expected at most the horizon, {forecast.horizon_s:g}", "forecast", "near_s"
        )
