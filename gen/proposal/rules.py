"""Alarm rules for a motor's parts: too hot for itself, hotter than its model, and heated by what its model lacks."""

from __future__ import annotations

from typing import Any

from gen.coefficients import Coefficients
from gen.coefficients.alarms import MOST_RULES
from gen.coefficients.names import MAX_LENGTH, name_fault
from gen.coefficients.rules import LEAST_HOURS, RuleDraft, drafted
from gen.proposal.motor import Motor

GUESSED_K = 3.0
"""Beyond the declared error band, until healthy runs tell more: six times the least margin of `gen thresholds`."""
_HYSTERESIS_K = 5.0
REMEMBERED_S = 14_400.0
"""What was usual within four hours and comes back is no change: a draught, a load that pauses."""
_PERSISTENCE_S, _LIMIT_PERSISTENCE_S, _SETTLE_S = 120.0, 1.0, 600.0


def open_rules(motor: Motor) -> list[RuleDraft]:
    """Rules without their numbers, for `gen thresholds` to fill in from healthy runs."""
    taken: set[str] = set()
    limits = [_limit(part, taken) for part in motor.parts]
    heat = [_heat(motor, taken)] if enough_for_heat(motor) else []
    return _fitting([*heat, *[_hot(part, motor, taken) for part in motor.parts]], limits)


def enough_for_heat(motor: Motor) -> bool:
    """Whether logs as long as these could give a rule on missing heat its rate of false alarms."""
    return motor.hours >= LEAST_HOURS


def complete_rules(motor: Motor, coefficients: Coefficients) -> list[RuleDraft]:
    """Rules with numbers from the coefficient file alone: its domain, and how far off it declares itself."""
    taken: set[str] = set()
    document = coefficients.document
    highest = document.domain.temperature_degC[1]
    limits = [
        _limit(
            part,
            taken,
            limit_degC=highest,
            hysteresis_K=_HYSTERESIS_K,
            note=f"TO BE SET: {highest:g} degC is the highest temperature of $.domain, for which all is proven. A "
            "limit of the material goes before.",
        )
        for part in motor.parts
    ]
    bands = document.provenance.error if document.provenance is not None else ()
    hot = [
        _hot(
            part,
            motor,
            taken,
            beyond="error_band",
            threshold_K=GUESSED_K,
            hysteresis_K=GUESSED_K / 2.0,
            note=f"TO BE SET: {GUESSED_K:g} K beyond what provenance.error declares at the present speed are a guess; "
            "gen thresholds derives the number from healthy runs.",
        )
        for part in motor.parts
        if any(band.component == part for band in bands)
    ]
    return _fitting(hot, limits)


def _limit(part: str, taken: set[str], **numbers: Any) -> RuleDraft:  # noqa: ANN401
    """A part that is too hot for itself."""
    name, why = _name(part, "limit", taken), f"{part} too hot, whatever the model says."
    return drafted(name, "over_temperature", part, why, persistence_s=_LIMIT_PERSISTENCE_S, **numbers)


def _hot(part: str, motor: Motor, taken: set[str], **numbers: Any) -> RuleDraft:  # noqa: ANN401
    """A part that is hotter than its model."""
    return drafted(
        _name(part, "hot", taken),
        "above_model",
        part,
        f"{part} over the healthy range: it heats more, or cools less, than a healthy motor.",
        speed_percent=_speeds(motor),
        persistence_s=_PERSISTENCE_S,
        settle_s=_SETTLE_S,
        **numbers,
    )


def _heat(motor: Motor, taken: set[str]) -> RuleDraft:
    """Heat that all parts together did not have before."""
    parts = motor.parts
    return drafted(
        _name("motor", "heat", taken),
        "missing_heat",
        parts[0],
        "Heat that was not there before, in the mean of the parts: a fault is heard in minutes, before a part is hot.",
        weights={part: round(1.0 / len(parts), 4) for part in parts},
        remembered_s=REMEMBERED_S,
        speed_percent=_speeds(motor),
    )


def _fitting(hot: list[RuleDraft], limits: list[RuleDraft]) -> list[RuleDraft]:
    """As many as the board has room for; limits go before."""
    return [*hot[: max(0, MOST_RULES - len(limits))], *limits]


def _speeds(motor: Motor) -> tuple[float, float]:
    """Where the motor was seen, in % of full scale, up to full speed."""
    return int(1000.0 * motor.speeds[0] / motor.full_scale) / 10.0, 100.0


def _name(part: str, what: str, taken: set[str]) -> str:
    """A rule's name that no other has, whatever the part's is."""
    for number in range(1, 100):
        end = f"_{what}" if number == 1 else f"_{what}{number}"
        name = f"{part[: MAX_LENGTH - len(end)].rstrip('_')}{end}"
        if name.lower() not in taken and name_fault(name) is None:
            break
    taken.add(name.lower())
    return name
