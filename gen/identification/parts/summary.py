"""What was found, as JSON and as text for the terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from gen.identification.grades import Grade, Miss, told, worse_than
from gen.identification.logs.data import Data
from gen.identification.logs.records import quantiser_bias
from gen.identification.parts.bands import next_speed
from gen.identification.parts.coefficient_file import measured_error
from gen.identification.parts.identify import SETTLED, Identified
from gen.model.dynamics import MAX_PWM

_LEAST_OFFSET_K = 0.005
"""Smaller offsets print as none."""
BETWEEN_K = 1.0
"""Error at speeds that were left out, above which a model is called good at the measured speeds only."""


def summary(data: Data, found: Mapping[str, Identified]) -> dict[str, Any]:
    """Give everything as plain numbers and words."""
    return {
        "runs": [source.path for source in data.sources],
        "ambient": {"fixed_degC": data.ambient_fixed, "measured": data.ambient_measured},
        "verdict": verdict(found),
        "warnings": [*data.warnings, *_warnings(found)],
        "components": {name: _component(item) for name, item in found.items()},
        "next_speed": _next(found),
    }


def verdict(found: Mapping[str, Identified]) -> str:
    """Whether the model is good to be built, in one line: from the runs' reach, the speeds and what had a fault."""
    speeds = {pwm for item in found.values() for pwm in item.speeds}
    faulty = [name for name, item in found.items() if item.choice.chosen.rejected or item.general.chosen.rejected]
    short = [name for name, item in found.items() if min(item.settled.values(), default=1.0) < SETTLED]
    if faulty:
        return f"Not good yet: no order or schedule without a fault was found for {', '.join(faulty)}."
    misses = [own_miss(item) for item in found.values()]
    bad, fair = (worse_than(grade, misses) for grade in (Grade.FAIR, Grade.GOOD))
    if bad:
        return f"Not good yet: in the runs that it was fitted to it misses {told(bad)}."
    if fair:
        return f"Fair: in the runs that it was fitted to it misses {told(fair)}."
    if len(speeds) < 3:
        return "Good at the measured speeds only: with fewer than three, nothing shows what lies between and beyond."
    scores = {name: item.general.chosen.score for name, item in found.items() if item.general.chosen.left_out}
    far = [f"{name} by {score:.2g} K" for name, score in scores.items() if score > BETWEEN_K]
    if far:
        return f"Good at the measured speeds; speeds that were left out it misses, {', '.join(far)}."
    if short:
        return f"Good for as long as the runs lasted; where {', '.join(short)} would settle is extrapolated."
    return "Good: every run settled, and every order and schedule passed its checks."


def own_miss(item: Identified) -> Miss:
    """By how much a part's model misses the runs that it was fitted to."""
    records = item.problem.records
    moved = max(float(r.raw_rise.max()) for r in records) - min(float(r.raw_rise.min()) for r in records)
    noise = np.array([math.hypot(r.noise_K, quantiser_bias(r.noise_K, r.quantum_K)) for r in records])
    error = math.sqrt(float(np.mean([tests.rms_K**2 for tests in item.tests.values()])))
    return Miss(item.name, error, moved, math.sqrt(float(np.mean(noise**2))))


def without_nan(tree: Any) -> Any:  # noqa: ANN401
    """Give the same tree with null in place of what JSON has no number for."""
    if isinstance(tree, dict):
        return {key: without_nan(value) for key, value in tree.items()}
    if isinstance(tree, list):
        return [without_nan(value) for value in tree]
    return None if isinstance(tree, float) and not math.isfinite(tree) else tree


def _component(item: Identified) -> dict[str, Any]:
    layout, fit = item.fit.layout, item.fit
    deviation, factor = item.spread.deviation, item.spread.factor
    line = item.linearity
    speeds: dict[str, Any] = {}
    first = len(layout.nodes) - len(layout.positive)
    for i, node in enumerate(layout.nodes.tolist()):
        theta, sd = fit.theta[i], deviation[: layout.thetas].reshape(-1, layout.order)[i]
        entry: dict[str, Any] = {
            label: {"value": math.exp(t), "interval": _interval(t, s, factor)}
            for label, t, s in zip(layout.structure.labels, theta, sd, strict=True)
        }
        if node:
            k = i - first
            sd_rise = float(deviation[layout.thetas + k])
            entry["steady_rise_K"] = {
                "value": float(fit.steady[k]),
                "interval": [float(fit.steady[k] - factor * sd_rise), float(fit.steady[k] + factor * sd_rise)],
            }
            entry["settled_share"] = item.settled.get(node, 0.0)
            entry["numerator"], entry["denominator"] = _polynomials(item, i, k)
        low, high = measured_error(item, node)
        entry["model_minus_measured_K"] = [low, high]
        speeds[str(node)] = entry
    chosen = item.general.chosen
    return {
        "order": layout.order,
        "structure": layout.structure.name,
        "reason": item.choice.reason,
        "held_out": item.choice.held_out,
        "candidates": [
            {
                "structure": c.structure.name,
                "held_out_loss": c.loss,
                "rejected": list(c.rejected),
                "by_pwm": {str(p): vars(k) for p, k in item.criteria[c.structure.name].items()},
            }
            for c in item.choice.candidates
        ],
        "speeds": speeds,
        "sensor_offset_K": item.fit.offset,
        "linearity": {
            "mean": [[p.real, p.imag] for p in line.mean.tolist()],
            "variance": line.variance.tolist(),
            "cv": line.cv.tolist(),
            "linear": line.linear,
            "verdict": line.verdict,
            "averaged_pole_steady_error_K": dict(zip(map(str, item.speeds), line.averaged_K.tolist(), strict=True)),
        },
        "schedules": {
            "time": chosen.shape.time.name,
            "gain": chosen.shape.gain.name,
            "leave_one_speed_out_K": chosen.left_out.rms_K.tolist() if chosen.left_out else None,
            "tried": len(item.general.options),
            "rejected": sum(bool(o.rejected) for o in item.general.options),
        },
        "residuals": {run: vars(tests) for run, tests in item.tests.items()},
    }


def _polynomials(item: Identified, i: int, k: int) -> tuple[float, list[float]]:
    poles = np.asarray(item.fit.layout.structure.poles(item.fit.theta[i]), dtype=np.complex128)
    denominator = np.real(np.poly(poles))
    gain = item.fit.steady[k] / item.speeds[k] * denominator[-1]
    return float(gain), [float(c) for c in denominator]


def _interval(log: float, sd: float, factor: float) -> list[float]:
    bound = min(factor * sd, 20.0)
    return [math.exp(log - bound), math.exp(log + bound)]


def _next(found: Mapping[str, Identified]) -> dict[str, Any] | None:
    """Where one more measured speed would help most."""
    speeds = sorted({p for item in found.values() for p in item.speeds})
    if len(speeds) < 3:
        ends = [0, *speeds, MAX_PWM]
        gap = max(range(len(ends) - 1), key=lambda i: ends[i + 1] - ends[i])  # the widest
        target = MAX_PWM if gap == len(speeds) else max((ends[gap] + ends[gap + 1]) // 2, 1)
        return {"pwm": target, "why": "fewer than three speeds: nothing shows how the model goes on between and beyond"}
    same = [item for item in found.values() if item.speeds == speeds]
    left: dict[int, float] = {}
    for item in same:
        error = item.general.chosen.left_out
        if error is not None:
            for p, value in zip(item.speeds, np.abs(error.steady_K).tolist(), strict=True):
                left[p] = max(left.get(p, 0.0), value)
    best = next_speed([item.band for item in same], speeds, left)
    if best is None:
        return None
    return {"pwm": best[0], "why": f"the steady rise there is uncertain by {best[1]:.2f} K (standard deviation)"}


def _warnings(found: Mapping[str, Identified]) -> list[str]:
    result = []
    for name, item in found.items():
        for pwm, share in item.settled.items():
            if share < SETTLED:
                sd = float(item.spread.deviation[item.fit.layout.thetas + item.speeds.index(pwm)])
                result.append(
                    f"{name} at PWM {pwm}: the runs reach {share:.0%} of the way to the steady rise; "
                    f"the rest is extrapolated, known to ±{item.spread.factor * sd:.2g} K"
                )
        if item.fit.offset and abs(item.fit.offset) >= _LEAST_OFFSET_K:
            result.append(
                f"{name}: its sensor reads {item.fit.offset:+.2f} K against the ambient's (±"
                f"{item.spread.factor * (item.offset_sd or 0.0):.2f} K); the model is without it"
            )
        if item.choice.chosen.rejected:
            result.append(f"{name}: {item.choice.reason}")
        if item.general.chosen.rejected:
            result.append(f"{name}: every form of schedule has a fault; the chosen one {item.general.chosen.rejected}")
    return result


def text(data: Data, found: Mapping[str, Identified]) -> str:
    """What the command prints."""
    whole = summary(data, found)
    lines = []
    for name, item in found.items():
        part = whole["components"][name]
        lines.append(f"{name}: order {part['structure']} ({part['reason']})")
        lines.append("  PWM   time constants (s)            steady rise (K)      error in the runs (K)  left out (K)")
        left = item.general.chosen.left_out
        for node, entry in part["speeds"].items():
            taus = ", ".join(f"{entry[label]['value']:.4g}" for label in item.fit.layout.structure.labels)
            rise = ""
            if "steady_rise_K" in entry:
                value, (low, high) = entry["steady_rise_K"]["value"], entry["steady_rise_K"]["interval"]
                rise = f"{value:.2f} ±{(high - low) / 2:.2f}"
            low, high = entry["model_minus_measured_K"]
            out = f"{left.rms_K[item.speeds.index(int(node))]:.2f}" if left is not None and int(node) else ""
            lines.append(f"  {node:>3}   {taus:<28}  {rise:<19}  {low:+.2f} .. {high:+.2f}{'':<8}  {out}")
        line = item.linearity
        if line.linear is not None:
            cv = ", ".join(f"{c:.0%}" for c in line.cv)
            worst = float(np.max(np.abs(line.averaged_K)))
            lines.append(f"  {line.verdict} ({worst:.1f} K; coefficients of variation of the poles: {cv})")
        shape = item.general.chosen.shape
        lines.append(f"  schedules: time constants: {shape.time.words}; gain: {shape.gain.words}")
    if whole["next_speed"]:
        lines.append(f"next run: PWM {whole['next_speed']['pwm']} ({whole['next_speed']['why']})")
    lines.append(whole["verdict"])
    lines += [f"warning: {warning}" for warning in whole["warnings"]]
    return "\n".join(lines)
