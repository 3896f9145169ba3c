"""What the templates are told about the alarm rules."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

from gen.firmware.contexts.heat import HeatContext, heat_context
from gen.lowering.alarms import AHEAD_TIMES, HASTE_mK, LoweredRule, Segment, asks_heat
from gen.model import ThermalModel

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
    ahead: int
    threshold_source: str


class AlarmsContext(HeatContext):
    """The rules, and what is summed of missing heat; how limits look ahead, if any (`ahead_rules`) does.

    `heat_asked`: whether a rule waits for one on missing heat to stay silent.
    """

    alarms: list[Rule]
    heat_asked: bool
    ahead_rules: bool
    ahead_times: int
    haste_mK: int


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
    places = {number: place for place, number in enumerate(n for n, rule in enumerate(rules) if rule.heat is not None)}
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
                "ahead": int(rule.looks_ahead),
                "threshold_source": source,
            }
        )
        first += len(rule.segments)
    return {
        "alarms": entries,
        "heat_asked": asks_heat(rules),
        "ahead_rules": any(rule.looks_ahead for rule in rules),
        "ahead_times": AHEAD_TIMES,
        "haste_mK": HASTE_mK,
        **heat_context(rules, model),
    }
