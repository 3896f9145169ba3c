"""Networks for tests: coefficient files with whatever the format has, made from a seed."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from gen.coefficients import Coefficients, parse

Tree = dict[str, Any]


def network_tree(seed: int, nodes: int, *, plain: bool = False) -> Tree:
    """A random network: a tree of paths with some more, two or three ways to the ambient, a heat at most nodes.

    Parameters
    ----------
    seed, nodes
        Of what.
    plain
        Without channels, heat that depends on temperature, and sensors that lag.
    """
    random = np.random.default_rng(seed)
    names = [f"n{k}" for k in range(nodes)]
    capacity = np.exp(random.uniform(np.log(40.0), np.log(2000.0), nodes))
    ends = [(names[k], names[int(random.integers(k))]) for k in range(1, nodes)]
    for _ in range(nodes // 3):
        a, b = random.choice(nodes, 2, replace=False)
        pair = (names[a], names[b])
        if pair not in ends and pair[::-1] not in ends:
            ends.append(pair)
    outside = random.choice(nodes, min(nodes, 1 + nodes // 3), replace=False)
    limit = 0.004 * capacity
    paths: list[Tree] = []
    for a, b in [*ends, *((names[k], "ambient") for k in outside)]:
        most = min(limit[names.index(end)] for end in (a, b) if end != "ambient") / (1.0 + nodes / 4)
        paths.append({"between": [a, b], "conductance_W_per_K": _conductance(random, most)})
    heats: list[Tree] = [
        {"node": name, "power_W": _power(random, 40.0 / nodes)} for name in names if random.random() < 0.7
    ] or [{"node": names[0], "power_W": _power(random, 20.0)}]
    sensed: list[Tree] = [{"sensor": {}} if k == 0 or random.random() < 0.6 else {} for k in range(nodes)]
    network: Tree = {
        "nodes": [
            {"name": name, "capacity_J_per_K": round(float(c), 3), **own}
            for name, c, own in zip(names, capacity, sensed, strict=True)
        ],
        "paths": paths,
        "heats": heats,
    }
    if not plain:
        network["channels"] = [
            {"column": "fan_percent", "range": [0, 100], "neutral": 20},
            {"column": "current_A", "range": [-10, 10], "neutral": 0},
        ]
        paths[-1]["factors"] = [{"channel": "fan_percent", "table": {"at": [0, 40, 100], "value": [1.0, 1.9, 1.6]}}]
        heats[0]["factors"] = [{"channel": "current_A", "poly": [0.01, 0.0, 0.5]}]
        heats[-1]["per_K"], heats[-1]["reference_degC"] = 0.0039, 25
        network["nodes"][0]["sensor"] = {"offset_K": 0.4, "lag_s": 12}
    tree = {
        "format": "gen-coefficients",
        "version": 2,
        "name": "net",
        "sample_time_s": 0.25,
        "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 2650},
        "ambient": {"fixed_degC": 25, "channel": "ambient_degC"},
        "validity": {"pwm": [0, 255], "outside": "hold"},
        "domain": {"pwm": [0, 255], "ambient_degC": [0, 45], "temperature_degC": [-10, 120]},
        "accuracy": {"fixed_limit_K": 1e-3, "float_limit_K": 0.1},
        "network": network,
    }
    return _scaled(tree)


def _scaled(tree: Tree) -> Tree:
    """Heats such that the hottest node settles some 60 K over the ambient at full PWM, channels neutral."""
    powers = [heat["power_W"]["poly"] for heat in tree["network"]["heats"]]
    for power in powers:
        power[:] = [value * 1e-3 for value in power]
    network = loaded(tree).model.network
    assert network is not None
    m, a, f = network.matrices(np.array([255]))
    rise = float(np.linalg.solve(-m[0], a[0] * 25.0 + f[0]).max()) - 25.0
    for power in powers:
        power[:] = [value * 60.0 / rise for value in power]
    return tree


def loaded(tree: Tree) -> Coefficients:
    """Read it as every command does."""
    return parse(json.dumps(tree).encode())


def _conductance(random: np.random.Generator, most: float) -> Tree:
    constant = float(most * random.uniform(0.2, 0.6))
    match int(random.integers(3)):
        case 0:
            return {"poly": [round(constant, 6)]}
        case 1:
            law = {"constant": constant, "forced": constant * float(random.uniform(0.1, 0.6)), "exponent": 0.8}
            return {"power": law, "at_rest": constant * 0.9}
        case _:
            values = constant * (1.0 + np.cumsum(random.uniform(0.0, 0.2, 4)))
            return {"table": {"pwm": [0, 60, 150, 255], "value": values.tolist(), "interpolation": "pchip"}}


def _power(random: np.random.Generator, most: float) -> Tree:
    top = float(most * random.uniform(0.3, 1.0))
    return {"poly": [top / 255.0**2 * 0.5, top / 255.0 * 0.5, 0.0]}
