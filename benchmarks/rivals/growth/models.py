"""Coefficient files of a wanted size: components of an order, networks of so many nodes, effects."""

from __future__ import annotations

import json
from itertools import pairwise
from typing import Any

from gen.coefficients import Coefficients, parse

Tree = dict[str, Any]
PWM = (0, 64, 128, 192, 255)
SLOWEST_S = 2400.0
FULL_RISE_K = 40.0
EFFECTS: tuple[Tree, ...] = (
    {"name": "hidden_node", "component": "part0", "parameters": {"heating_K_per_s": 0.004, "node_tau_s": 400.0}},
    {"name": "coupling", "component": "part1", "parameters": {"source": "part0", "conductance_per_s": 1e-4}},
    {"name": "sensor_lag", "component": "part0", "parameters": {"lag_s": 25.0}},
    {"name": "sensor_offset", "component": "part1", "parameters": {"offset_K": 0.5}},
)
"""What is added, the first of them first."""
FAN, CURRENT = "fan_percent", "current_A"
TERMS = ("a fan's channel", "a load's channel", "copper loss that grows with temperature", "radiation")
"""What a network gets, the first of them first."""


def _head(name: str, version: int) -> Tree:
    return {
        "format": "gen-coefficients",
        "version": version,
        "name": name,
        "sample_time_s": 0.25,
        "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 2650},
        "ambient": {"fixed_degC": 25.0} if version == 1 else {"fixed_degC": 25, "channel": "ambient_degC"},
        "validity": {"pwm": [0, 255], "outside": "hold"},
        "domain": {"pwm": [0, 255], "ambient_degC": [0, 45], "temperature_degC": [-10, 150]},
        "accuracy": {"fixed_limit_K": 0.01, "float_limit_K": 1.0},
    }


def components(count: int, order: int, effects: int = 0) -> Coefficients:
    """Give components of one order with real poles, faster with the speed, each a little unlike the last.

    Parameters
    ----------
    count, order
        How many, and of which order, 1..4.
    effects
        How many of `EFFECTS` act; they need two components.
    """
    tree = _head(f"parts{count}x{order}", 1)
    tree["components"] = [_component(number, order) for number in range(count)]
    if effects:
        tree["version"] = 2
        tree["ambient"]["channel"] = "ambient_degC"
        tree["effects"] = [dict(effect) for effect in EFFECTS[:effects]]
    return _parsed(tree)


def _component(number: int, order: int) -> Tree:
    rates = [[(4.0**k) * (1.0 + 0.5 * x / 255) * (1.0 + 0.03 * number) / SLOWEST_S for x in PWM] for k in range(order)]
    gains = []
    for at in range(len(PWM)):
        product = FULL_RISE_K / 255
        for rate in rates:
            product *= rate[at]
        gains.append(product)
    return {
        "name": f"part{number}",
        "order": order,
        "gain": _table(gains),
        "poles": [{"real": _table([-value for value in rate])} for rate in rates],
    }


def _table(values: list[float]) -> Tree:
    return {"table": {"pwm": list(PWM), "value": values, "interpolation": "linear"}}


def network(nodes: int, terms: int = 0) -> Coefficients:
    """Give a chain of heat capacities, warmed at one end, with two ways to the room; every other node is measured.

    Parameters
    ----------
    nodes
        How many.
    terms
        How many of `TERMS` it has.
    """
    tree = _head(f"nodes{nodes}", 2)
    names = [f"node{k}" for k in range(nodes)]
    flow = {"power": {"constant": 0.3, "forced": 0.4, "exponent": 0.8}}
    tree["network"] = {
        "nodes": [
            {"name": name, "capacity_J_per_K": 150 + 40 * k, **({"sensor": {}} if k % 2 == 0 else {})}
            for k, name in enumerate(names)
        ],
        "paths": [
            *({"between": [a, b], "conductance_W_per_K": {"poly": [0.8]}} for a, b in pairwise(names)),
            {"between": [names[0], "ambient"], "conductance_W_per_K": {"poly": [0.2]}},
            {"between": [names[-1], "ambient"], "conductance_W_per_K": flow},
        ],
        "heats": [{"node": names[0], "power_W": {"poly": [1e-4, 0.01, 0]}}],
    }
    _add_terms(tree["network"], terms)
    return _parsed(tree)


def _add_terms(tree: Tree, count: int) -> None:
    first, last = tree["nodes"][0]["name"], tree["nodes"][-1]["name"]
    channels = {FAN: [0, 100], CURRENT: [0, 10]}
    tree["channels"] = [{"column": key, "range": ends, "neutral": 0} for key, ends in list(channels.items())[:count]]
    if count > 0:
        tree["paths"][-1]["factors"] = [{"channel": FAN, "table": {"at": [0, 30, 100], "value": [1, 1.4, 2.3]}}]
    if count > 1:
        load = {"channel": CURRENT, "poly": [1, 0, 0]}
        tree["heats"].append({"node": first, "power_W": {"poly": [0.02]}, "factors": [load]})
    if count > 2:
        tree["heats"][0] |= {"per_K": 0.0039, "reference_degC": 25}
    if count > 3:
        radiating = {"conductance_W_per_K": {"poly": [0.1]}, "radiation": {"reference_degC": 25}}
        tree["paths"].append({"between": [last, "ambient"], **radiating})


def _parsed(tree: Tree) -> Coefficients:
    return parse(json.dumps(tree).encode())
