"""The alarm rules in words, for the README and the report of an emitted project."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

from gen.coefficients import Coefficients
from gen.coefficients.alarms import AlarmRule, Cusum, Deviation, MissingHeat, OverTemperature
from gen.coefficients.checks.alarm_checks import declared_deviation_K
from gen.coefficients.document import Document
from gen.coefficients.protecting import protections
from gen.lowering.alarms import LoweredRule, lower_alarms

_WARM_START = "after a start from the measured temperatures of a warm motor"


@dataclass(frozen=True)
class AlarmText:
    """One rule.

    Attributes
    ----------
    name, description, note
        From the coefficient file.
    condition
        What is compared with what, for how long, and from when.
    sleeps_s
        Seconds at its speeds that it sleeps for after a start from the measured temperatures of a warm motor.
    thresholds
        By range of |PWM|: the threshold as the board has it, beside what the file declares of a healthy motor there.
    """

    name: str
    description: str
    note: str
    condition: str
    sleeps_s: float
    thresholds: tuple[str, ...]


def alarm_texts(coefficients: Coefficients) -> tuple[AlarmText, ...]:
    """Say what each rule of a coefficient file does.

    Parameters
    ----------
    coefficients
        A checked coefficient file.
    """
    document = coefficients.document
    made = []
    for rule, lowered in zip(document.alarms, lower_alarms(coefficients), strict=True):
        sleeps_s = lowered.start_wait * coefficients.model.sample_time
        condition = _condition(document, rule, sleeps_s)
        thresholds = _thresholds(coefficients, rule, lowered)
        made.append(AlarmText(rule.name, rule.description, rule.note, condition, sleeps_s, thresholds))
    return tuple(made)


def told_sleeping(texts: Sequence[AlarmText]) -> str:
    """One line on the rules that a warm start puts to sleep, empty where none sleeps.

    Parameters
    ----------
    texts
        The rules of a file in words.
    """
    asleep = [f"{text.name} {_lasting(text.sleeps_s)}" for text in texts if text.sleeps_s]
    if not asleep:
        return ""
    return f"{_WARM_START} rules sleep, counted at their speeds: {', '.join(asleep)}"


def _lasting(seconds: float) -> str:
    hours, minutes = divmod(ceil(seconds / 60.0), 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min"


def _condition(document: Document, rule: AlarmRule, sleeps_s: float) -> str:
    low, high = rule.speed_percent
    parts = [f"{_compared(rule)}, at {low:g} to {high:g} % speed"]
    if rule.persistence_s:
        sooner = ", sooner the farther over it or the faster it rises" if _looks_ahead(rule) else ""
        parts.append(f"for {rule.persistence_s:g} s{sooner}")
    if rule.settle_s:
        parts.append(f"from {rule.settle_s:g} s after PWM came there")
    if sleeps_s:
        parts.append(f"only after {_lasting(sleeps_s)} there {_WARM_START}")
    if rule.requires is not None:
        parts.append(f"only while {rule.requires} is raised")
    if rule.unless is not None:
        parts.append(f"not while {rule.unless} is raised{_or_deaf(document, rule.unless)}")
    if any(entry.rule == rule.name and entry.stops for entry in protections(document)):
        parts.append("stops the motor")
    return ", ".join(parts)


def _or_deaf(document: Document, name: str) -> str:
    heard = any(isinstance(rule, MissingHeat) and rule.name == name for rule in document.alarms)
    return ", nor where it had been unsettled and could hear nothing" if heard else ""


def _looks_ahead(rule: AlarmRule) -> bool:
    return isinstance(rule, OverTemperature) and rule.look_ahead


def _compared(rule: AlarmRule) -> str:
    if isinstance(rule, OverTemperature):
        return f"{rule.component} over {rule.limit_degC:g} degC"
    if isinstance(rule, MissingHeat):
        return _heat(rule)
    beyond = " beyond the healthy range" if rule.beyond == "error_band" else ""
    if isinstance(rule, Cusum):
        excess = f"{rule.component} {rule.direction} the model by more than {rule.slack_K:g} K{beyond}"
        return f"{excess}, summed up to {rule.threshold_K_s:g} K s"
    side = "above" if rule.kind == "above_model" else "below"
    other = f" than {rule.relative_to} is" if rule.relative_to is not None else ""
    more = "farther " if other else ""
    return f"{rule.component} {more}{side} the model{other} by more than {rule.threshold_K:g} K{beyond}"


def _heat(rule: MissingHeat) -> str:
    weights = rule.weight_of
    terms = [f"{weight:+g} {name}" for name, weight in weights.items()]
    of = rule.component if weights == {rule.component: 1.0} else " ".join(terms).removeprefix("+")
    since = "" if rule.remembered_s is None else f", forgotten with {rule.remembered_s / 3600.0:.3g} h,"
    return (
        f"heat that the model lacks ({of}), beyond the usual{since} by more than {rule.slack_K_per_h:g} K/h, "
        f"summed up to {rule.threshold_K:g} K"
    )


def _thresholds(coefficients: Coefficients, rule: AlarmRule, lowered: LoweredRule) -> tuple[str, ...]:
    if isinstance(rule, OverTemperature | MissingHeat):
        return ()
    return tuple(
        f"PWM {segment.low}..{segment.high}: {segment.trip_mK / 1000.0:g} K"
        + _declared(coefficients, rule, segment.low, segment.high)
        for segment in lowered.segments
    )


def _declared(coefficients: Coefficients, rule: Deviation | Cusum, low: int, high: int) -> str:
    bands = coefficients.document.provenance.error if coefficients.document.provenance else ()
    if rule.relative_to is not None or not bands:
        return ""
    known = [value for pwm in range(low, high + 1) if (value := declared_deviation_K(bands, rule, pwm)) is not None]
    return f" (healthy up to {max(known):.2f} K)" if known else " (no healthy range declared)"
