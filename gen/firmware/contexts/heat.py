"""What the templates are told about the rules on missing heat."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

from gen.lowering import heat
from gen.lowering.alarms import LoweredRule
from gen.lowering.heat import LoweredHeat
from gen.model import ThermalModel
from gen.reference.heat import watched


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
    told: int
    forgetting: int
    limit: int


class WatchedPart(TypedDict):
    """A component whose missing heat some rule weighs."""

    name: str
    forgetting: Sequence[int]


class HeatContext(TypedDict):
    """The sums of missing heat, none where no rule is on it, and what their words hold."""

    heat_rules: list[HeatRule]
    heat_parts: list[WatchedPart]
    heat_block: int
    heat_limits: dict[str, int]


def heat_context(rules: Sequence[LoweredRule], model: ThermalModel) -> HeatContext:
    """The sums as the templates print them.

    Parameters
    ----------
    rules
        All lowered rules in the file's order.
    model
        Gives the components' names.
    """
    sums = [(number, rule.heat) for number, rule in enumerate(rules) if rule.heat is not None]
    return {
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
                "told": found.told,
                "forgetting": found.forgetting,
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
