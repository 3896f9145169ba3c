"""Random networks with every kind of term in some of them, and with natural convection and radiation."""

from __future__ import annotations

from typing import Any

import numpy as np


def drawn(seed: int, size: int) -> dict[str, Any]:
    """A coefficient file with a random network: a tree, some more paths, and every kind of term in some of them."""
    rng = np.random.default_rng(seed)

    def pick(*chances: float) -> int:
        return int(rng.choice(len(chances), p=np.array(chances) / sum(chances)))

    channels = [
        {"column": "fan_percent", "range": [0, 100], "neutral": 0},
        {"column": "current_A", "range": [-12.5, 20.125], "neutral": 0},
    ][: seed % 3]

    def factors() -> dict[str, Any]:
        if not channels or pick(2, 1) == 0:
            return {}
        fan = {
            "channel": "fan_percent",
            "table": {"at": [0, 30.5, 100], "value": [1, *rng.uniform(0.4, 3.0, 2).round(3)]},
        }
        square = {"channel": "current_A", "poly": [*rng.uniform(0.0005, 0.005, 1).round(5), 0.0, 0.2]}
        return {"factors": [fan, square][: 1 + pick(1, 1)] if len(channels) > 1 else [fan]}

    def curve(scale: float) -> dict[str, Any]:
        kind, a, b = pick(2, 2, 1), *np.round(scale * rng.uniform(0.2, 1.0, 2), 4)
        if kind == 0:
            return {"poly": [a]}
        made: dict[str, Any] = {"power": {"constant": a, "forced": b, "exponent": 0.8}}
        return made if kind == 1 else {**made, "at_rest": round(float(a) / 2, 4)}

    def name(k: int) -> str:
        return f"part{k}"

    pairs = [(k, int(rng.integers(0, k))) for k in range(1, size)]
    pairs += [(a, b) for a in range(size) for b in range(a) if (a, b) not in pairs and rng.random() < 0.15]
    paths = [{"between": [name(a), name(b)], "conductance_W_per_K": curve(1.5), **factors()} for a, b in pairs]
    warm = sorted({0, *(k for k in range(size) if rng.random() < 0.4)})
    paths += [{"between": [name(k), "ambient"], "conductance_W_per_K": curve(1.6), **factors()} for k in warm]
    heats = []
    for k in range(size):
        power = {"poly": [round(float(rng.uniform(1e-5, 2e-4)), 7), round(float(rng.uniform(0, 0.02)), 5), 0]}
        growth = {"per_K": [0.0015, -0.001][pick(1, 1)], "reference_degC": 25} if pick(2, 1) else {}
        heats += [{"node": name(k), "power_W": power, **growth, **factors()}]
    nodes = []
    for k in range(size):
        sensor: dict[str, Any] = {"offset_K": float(np.round(rng.normal(), 2)), "lag_s": [0.0, 6.0][pick(3, 1)]}
        gains: list[dict[str, Any]] = [{}, {"gain_error": -0.2}, {"gain_error": 0.1, "gain_about": "zero_degC"}]
        sensor |= gains[(seed + k) % 3]
        drifts: list[dict[str, Any]] = [{}, {"drift_K": -6.5, "drift_h": 1.5}, {}, {"drift_K": 40.0, "drift_h": 24.0}]
        sensor |= drifts[(seed + 2 * k) % 4]
        starts: list[dict[str, Any]] = [{}, {"start_factor": 0.4}, {"start_factor": 1.7}]
        starts += [{"start_from": {name(0): 1.3}}, {"start_from": {name(0): 0.7}, "start_factor": 1.5}]
        hidden = starts[seed % len(starts)]
        shown = {"sensor": sensor} if k == 0 or rng.random() < 0.7 else hidden
        nodes.append({"name": name(k), "capacity_J_per_K": float(np.round(rng.uniform(40, 900), 1)), **shown})
    return {
        "format": "gen-coefficients",
        "version": 2,
        "name": f"drawn{seed}",
        "sample_time_s": 0.25,
        "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 2650},
        "ambient": {"fixed_degC": 25, "channel": "ambient_degC"},
        "validity": {"pwm": [[0, 255], [20, 230]][seed % 2], "outside": "hold"},
        "domain": {"pwm": [[0, 255], [10, 240]][seed % 2], "ambient_degC": [0, 45], "temperature_degC": [-10, 120]},
        "accuracy": {"fixed_limit_K": 1.0, "float_limit_K": 10.0},
        "network": {"channels": channels, "nodes": nodes, "paths": paths, "heats": heats},
    }


def with_laws(seed: int, size: int) -> dict[str, Any]:
    """A random network of which some paths have laws, and one more radiates.

    Parameters
    ----------
    seed, size
        Of what, and how many nodes.
    """
    file = drawn(seed, size)
    random = np.random.default_rng(seed + 1000)
    paths = file["network"]["paths"]
    for number, path in enumerate(paths):
        if number % 2 == seed % 2:
            growth = float(random.uniform(0.0, 0.02))
            whole = [float(random.uniform(0, 4e-7)), -2e-3 * growth, growth, float(random.uniform(0.5, 1.0))]
            path["convection"] = {"poly": [round(c, 9) for c in whole[seed % 4 :]]}
    outside = {"between": ["part0", "ambient"], "conductance_W_per_K": {"poly": [0.4]}}
    paths.append({**outside, "radiation": {"reference_degC": [25, 60][seed % 2]}})
    if all("convection" in path or "radiation" in path for path in paths if "ambient" in path["between"]):
        paths.append({**outside, "conductance_W_per_K": {"poly": [0.3]}})
    # What bends counts with the square of how fast temperatures change.
    for node in file["network"]["nodes"]:
        node["capacity_J_per_K"] = round(10.0 * node["capacity_J_per_K"], 1)
    file["domain"]["temperature_degC"], file["domain"]["ambient_degC"] = [0, 90], [10, 35]
    file["domain"]["pwm"] = file["validity"]["pwm"] = [0, 255]
    file["name"] = f"laws{seed}"
    return file
