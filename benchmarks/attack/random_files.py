"""Coefficient files drawn at random, wide on purpose: what a user may write and the format allows."""

from __future__ import annotations

from typing import Any

import numpy as np

Document = dict[str, Any]

#: Sample times in s, |pole| times sample time, highest temperature in degC, steady rise at full scale in K: the ends.
SAMPLE_TIMES = (0.05, 5.0)
SPEEDS = (1e-6, 0.1)
TEMPERATURES = (40.0, 4000.0)
RISES = (1e-6, 4500.0)
#: By how much a schedule may change over the domain.
_STRENGTH = (1.0, 12.0)


def random_document(seed: int, number: int) -> Document:
    """The file of one number; most can be built."""
    rng = np.random.default_rng([seed, number])
    step = round(_log(rng, *SAMPLE_TIMES), 3)  # the board counts milliseconds
    domain = [0, 255] if rng.random() < 0.8 else sorted(int(v) for v in rng.choice(256, 2, replace=False))
    low = float(round(rng.uniform(-60.0, 20.0)))
    high = float(np.ceil(low + _log(rng, *TEMPERATURES)))
    cold, warm = (low, min(high, low + 80.0)) if rng.random() < 0.6 else (min(20.0, high), min(20.0, high))
    ambient: Document = {"fixed_degC": cold}
    if rng.random() < 0.3:
        ambient = {"channel": "ambient_degC"}
    elif rng.random() < 0.3:
        ambient = {"fixed_degC": cold, "channel": "ambient_degC"}
    document: Document = {
        "format": "gen-coefficients",
        "version": 1,
        "name": f"random{number}",
        "sample_time_s": step,
        "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 3000},
        "ambient": ambient,
        "validity": {"pwm": domain, "outside": str(rng.choice(["extrapolate", "hold"]))},
        "domain": {"pwm": domain, "ambient_degC": [cold, warm], "temperature_degC": [low, high]},
        "components": [_component(rng, f"part{i}", step, domain) for i in range(1 + int(rng.random() < 0.2))],
    }
    if rng.random() < 0.7:  # else most hot motors are refused, and nothing is learnt of their bounds
        document["accuracy"] = {"fixed_limit_K": 1.0, "float_limit_K": 50.0}
    if rng.random() < 0.1:  # what has no proof has no bound to break, yet must be built without a crash
        document["accuracy"] = document.get("accuracy", {}) | {"unproven": "saturate"}
    return document


def _component(rng: np.random.Generator, name: str, step: float, domain: list[int]) -> Document:
    order = int(rng.integers(1, 5))
    fastest = _log(rng, 1e-4, SPEEDS[1])
    slowest = max(SPEEDS[0], fastest / _log(rng, 1.0, 100.0))
    poles: list[Document] = []
    size = 1.0
    while len(poles) < order:
        speed = _log(rng, slowest, fastest) / step
        strength = _strength(rng)
        if order - len(poles) >= 2 and rng.random() < 0.4:
            angle = rng.uniform(0.1, 1.3)
            shape, values = _schedule(rng, -speed * np.cos(angle), strength, domain)
            other = speed * np.sin(angle)
            for sign in (1.0, -1.0):
                poles.append({"real": shape, "imag": _like(shape, values, sign * other)})
            size *= speed * speed
        else:
            shape, _ = _schedule(rng, -speed, strength, domain)
            poles.append({"real": shape})
            size *= speed
    rise = _log(rng, *RISES)
    gain, _ = _schedule(rng, rise * size / max(1, domain[1]), 1.0 / _strength(rng), domain)
    component: Document = {"name": name, "order": order, "gain": gain, "poles": poles}
    if rng.random() < 0.3:
        component["negative_gain"] = "zero"
    return component


def _schedule(rng: np.random.Generator, top: float, strength: float, domain: list[int]) -> tuple[Document, float]:
    """A schedule that is ``top`` at one end of the domain and ``top / strength`` at the other, and that ratio."""
    low, high = domain
    bottom = top / strength
    if rng.random() < 0.3:
        top, bottom = bottom, top
    kind = rng.choice(["constant", "linear", "exp1", "exp2", "pchip", "table"])
    span = high - low
    if kind == "constant":
        return {"poly": [top]}, 1.0
    if kind == "linear":
        slope = (top - bottom) / span
        return {"poly": [slope, bottom - slope * low]}, bottom / top
    if kind == "exp1":
        rate = float(np.log(top / bottom) / span)
        return {"exp1": [bottom * float(np.exp(-rate * low)), rate]}, bottom / top
    if kind == "exp2":
        rate = float(np.log(top / bottom) / span)
        share = float(rng.uniform(0.2, 0.8))
        factor = bottom * float(np.exp(-rate * low))
        return {"exp2": [share * factor, rate, (1.0 - share) * factor, 0.7 * rate]}, bottom / top
    count = int(rng.integers(2, min(9, span + 2)))
    pwm = sorted({low, high, *(int(v) for v in rng.integers(low, high + 1, count))})
    value = [bottom * float((top / bottom) ** rng.random()) for _ in pwm]
    value[0], value[-1] = bottom, top
    return {"table": {"pwm": pwm, "value": value, "interpolation": "linear" if kind == "table" else "pchip"}}, 1.0


def _like(shape: Document, _ratio: float, top: float) -> Document:
    """The schedule of a pair's imaginary part: the real one's, scaled, so that the angle stays."""
    ((kind, given),) = shape.items()
    if kind == "table":
        factor = top / max(abs(v) for v in given["value"])
        return {"table": {**given, "value": [abs(v) * factor for v in given["value"]]}}
    if kind == "poly":
        factor = top / max(abs(given[-1]), abs(sum(v * 255.0**i for i, v in enumerate(reversed(given)))))
        return {"poly": [-v * factor for v in given]}
    factor = top / max(abs(given[0]), 1e-300)
    return {kind: [-v * factor if i % 2 == 0 else v for i, v in enumerate(given)]}


def _strength(rng: np.random.Generator) -> float:
    return 1.0 if rng.random() < 0.2 else _log(rng, *_STRENGTH)


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    """Uniform in the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
