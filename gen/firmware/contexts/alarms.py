"""What the templates are told about the alarm rules."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

from gen.lowering import heat
from gen.lowering.alarms import LoweredRule, Segment
from gen.lowering.heat import LoweredHeat
from gen.model import ThermalModel
from gen.reference.heat import watched

_QUANTITIES = {"above": "ABOVE_MODEL", "below": "BELOW_MODEL", "measured": "MEASURED", "heat": "HEAT"}
_SOURCES = {"above": ".threshold_K", "below": ".threshold_K", "measured": ".limit_degC", "heat": ".threshold_K"}


class Rule(TypedDict):
    """One rule; `first` is the place of its first segment in the table of all, times are in samples."""

    name: str
    description: str
    quantity: str
    component: str
    relative_to: str | None
    segments: Sequence[Segment]
    first: int
    requires: str
    unless: str
    settle: int
    start_wait: int
    persistence: int
    sum_limit: int
    heat: int
    threshold_source: str


class HeatTerm(TypedDict):
    """One watched component's part in a rule, by its place among the watched ones."""

    part: int
    weight: int


class HeatRule(TypedDict):
    """A rule on missing heat; `rule` is its number among all, `first` the place of its first term in the table."""

    name: str
    rule: int
    terms: list[HeatTerm]
    first: int
    low: int
    high: int
    slack: int
    unknown: int
    change: int
    start: int
    fading: Sequence[int]
    memory: int
    limit: int


class WatchedPart(TypedDict):
    """A component whose missing heat some rule weighs."""

    name: str
    forgetting: Sequence[int]


class AlarmsContext(TypedDict):
    """The rules, a mask of those that stop the motor, and what is summed of missing heat."""

    alarms: list[Rule]
    alarm_stop_mask: int
    heat_rules: list[HeatRule]
    heat_parts: list[WatchedPart]
    heat_block: int
    heat_limits: dict[str, int]


def alarms_context(rules: Sequence[LoweredRule], model: ThermalModel) -> AlarmsContext:
    """The rules as the templates print them.

    Parameters
    ----------
    rules
        Lowered rules in the file's order.
    model
        Gives the components' names.
    """
    entries: list[Rule] = []
    first = 0
    sums = [(number, rule.heat) for number, rule in enumerate(rules) if rule.heat is not None]
    places = {number: place for place, (number, _) in enumerate(sums)}
    for number, rule in enumerate(rules):
        source = ".slack_K" if rule.sum_limit is not None else f"{_SOURCES[rule.quantity]}, .hysteresis_K"
        entries.append(
            {
                "name": rule.name,
                "description": rule.description,
                "quantity": _QUANTITIES[rule.quantity],
                "component": model.component_names[rule.component],
                "relative_to": None if rule.relative_to is None else model.component_names[rule.relative_to],
                "segments": rule.segments,
                "first": first,
                "requires": "NONE" if rule.requires is None else str(rule.requires),
                "unless": "NONE" if rule.unless is None else str(rule.unless),
                "settle": rule.settle,
                "start_wait": rule.start_wait,
                "persistence": rule.persistence,
                "sum_limit": rule.sum_limit or 0,
                "heat": places.get(number, 0),
                "threshold_source": source,
            }
        )
        first += len(rule.segments)
    mask = sum(1 << number for number, rule in enumerate(rules) if rule.stops)
    return {
        "alarms": entries,
        "alarm_stop_mask": mask,
        "heat_rules": _heat_rules(rules, sums),
        "heat_parts": _heat_parts([found for _, found in sums], model),
        "heat_block": sums[0][1].block if sums else 0,
        "heat_limits": {
            "per_mK": heat.PER_mK,
            "bin": heat.BIN_COUNTS,
            "rate_bits": heat.RATE_BITS,
            "weight_bits": heat.WEIGHT_BITS,
            "fine_bits": heat.FINE_BITS,
            "prior": heat.PRIOR_BLOCKS,
            "most_deviation": heat.MOST_DEVIATION_mK,
            "most_unsettled": heat.MOST_UNSETTLED,
            "most_pending": heat.MOST_PENDING,
            "most_rate": heat.MOST_RATE << heat.FINE_BITS,
            "most_waited": heat.MOST_WAITED,
        },
    }


def _heat_rules(rules: Sequence[LoweredRule], sums: Sequence[tuple[int, LoweredHeat]]) -> list[HeatRule]:
    components = watched([found for _, found in sums])
    entries: list[HeatRule] = []
    first = 0
    for number, found in sums:
        terms: list[HeatTerm] = [
            {"part": components.index(term.component), "weight": term.weight} for term in found.terms
        ]
        entries.append(
            {
                "name": rules[number].name,
                "rule": number,
                "terms": terms,
                "first": first,
                "low": found.low,
                "high": found.high,
                "slack": found.slack,
                "unknown": found.unknown,
                "change": found.change,
                "start": found.start,
                "fading": found.fading,
                "memory": found.memory,
                "limit": found.limit,
            }
        )
        first += len(terms)
    return entries


def _heat_parts(sums: Sequence[LoweredHeat], model: ThermalModel) -> list[WatchedPart]:
    forgetting = {term.component: term.forgetting for found in sums for term in found.terms}
    return [
        {"name": model.component_names[component], "forgetting": forgetting[component]} for component in watched(sums)
    ]
