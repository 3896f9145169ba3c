"""What the templates are told about the alarm rules."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gen.lowering.alarms import LoweredRule
from gen.model import ThermalModel

_QUANTITIES = {"above": "ABOVE_MODEL", "below": "BELOW_MODEL", "measured": "MEASURED"}
_SOURCES = {"above": ".threshold_K", "below": ".threshold_K", "measured": ".limit_degC"}


def alarm_context(rules: Sequence[LoweredRule], model: ThermalModel) -> dict[str, Any]:
    """The rules as the templates print them.

    Parameters
    ----------
    rules
        Lowered rules in the file's order.
    model
        Gives the components' names.
    """
    entries, first = [], 0
    for rule in rules:
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
                "threshold_source": source,
            }
        )
        first += len(rule.segments)
    mask = sum(1 << number for number, rule in enumerate(rules) if rule.stops)
    return {"alarms": entries, "alarm_stop_mask": mask}
