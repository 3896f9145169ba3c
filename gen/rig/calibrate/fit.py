"""Least squares over published numbers, first guesses and what keeps the motor plausible."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from gen.arrays import FloatArray
from gen.rig.calibrate.targets import Targets, time_to_63
from gen.rig.calibrate.unknowns import BOUNDS, GUESSES, SPREADS, motor
from gen.rig.losses import HEALTHY, Condition
from gen.rig.parameters import MEASURED, NODES, MotorParameters
from gen.rig.response import Held, held, network, no_load

#: Full severity of each fault.
BROKEN = {"bearing": Condition(bearing_fault=1.0), "brush": Condition(brush_fault=1.0)}
#: The hottest casing of all fault runs, degC: the bearing fault at 70 % speed.
HOTTEST_CASING = 75.0
_COLUMN = {name: NODES.index(name) for name in NODES}


@dataclass(frozen=True)
class Comparison:
    """The motor beside the targets.

    Attributes
    ----------
    end_K
        Motor minus Table 4.1 at the end of the recording, by component, shape (speeds,).
    settled_K
        The same for the settled motor.
    time_63
        Time to 63 % over the transfer function's, minus one.
    curves
        Motor's rise from cold, K, shape (speeds, times).
    current_A
        No-load current, shape (speeds,).
    """

    end_K: dict[str, FloatArray]
    settled_K: dict[str, FloatArray]
    time_63: dict[str, FloatArray]
    curves: dict[str, FloatArray]
    current_A: FloatArray
    points: tuple[Held, ...]


def compare(parameters: MotorParameters, targets: Targets) -> Comparison:
    """Run the motor from cold at each identified speed."""
    net = network(parameters)
    cold = np.full(len(NODES), targets.ambient_degC)
    points = tuple(held(parameters, no_load(s), ambient_degC=targets.ambient_degC, net=net) for s in targets.speeds)
    rises = np.array([point.rise_from(cold, targets.time_s) for point in points]) - targets.ambient_degC
    settled = np.array([point.settled for point in points])
    curves = {name: rises[:, :, _COLUMN[name]] for name in NODES}
    return Comparison(
        end_K={name: curves[name][:, -1] + targets.ambient_degC - targets.end_degC[name] for name in MEASURED},
        settled_K={name: settled[:, _COLUMN[name]] - targets.end_degC[name] for name in MEASURED},
        time_63={
            name: np.array(
                [
                    time_to_63(targets.time_s, mine) / time_to_63(targets.time_s, theirs) - 1.0
                    for mine, theirs in zip(curves[name], targets.curves[name], strict=True)
                ]
            )
            for name in MEASURED
        },
        curves=curves,
        current_A=np.array([point.heat.current_A for point in points]),
        points=points,
    )


def settled(parameters: MotorParameters, speeds: FloatArray, condition: Condition = HEALTHY) -> dict[str, FloatArray]:
    """Settled temperatures at 30 degC ambient, degC, by node, shape (speeds,)."""
    net = network(parameters)
    all_nodes = np.array([held(parameters, no_load(s), condition=condition, net=net).settled for s in speeds])
    return {name: all_nodes[:, column] for name, column in _COLUMN.items()}


def calibrate(targets: Targets) -> FloatArray:
    """Find the unknowns' logarithms."""

    def residual(x: FloatArray) -> FloatArray:
        return _residual(x, targets)

    start = np.clip(GUESSES, *BOUNDS)
    solution = least_squares(residual, start, bounds=BOUNDS, x_scale=0.3, max_nfev=500)
    return np.asarray(solution.x)


def _residual(x: FloatArray, targets: Targets) -> FloatArray:
    parameters = motor(x)
    healthy = compare(parameters, targets)
    parts: list[FloatArray] = [0.25 * (x - GUESSES) / SPREADS]
    for name in MEASURED:
        limit = 0.21 if name == "brush" else 0.11
        end = healthy.end_K[name]
        parts += [
            end / 0.25,
            _beyond(end, 1.6, 0.02),
            _beyond(healthy.settled_K[name], 1.75, 0.01),
            healthy.time_63[name] / 0.04,
        ]
        parts.append(_beyond(healthy.time_63[name], limit, 0.002))
        # Shapes count little: the brush's transfer function has no zeros and so cannot start as fast as a heated body.
        scaled = (
            targets.curves[name]
            * ((targets.end_degC[name] - targets.ambient_degC) / targets.curves[name][:, -1])[:, None]
        )
        parts.append(((healthy.curves[name] - scaled)[:, 60::90] / 4.0).ravel())
    # The air that bathes the brush is not far from the casing, nor is the winding, which hardly any current heats.
    at = {name: values[:, -1] for name, values in healthy.curves.items()}
    parts.append(_above(at["air"] - at["casing"], 5.0, 0.5))
    parts.append(_above(at["winding"] - at["brush"], 10.0, 2.0))
    slow = [held(parameters, no_load(s)) for s in (0.004, 0.03, 0.1)]
    currents = np.concatenate([healthy.current_A, [point.heat.current_A for point in slow]])
    parts.append(_above(currents, targets.current_A_max - 0.03, 0.005))
    parts += _fault_residuals(parameters, targets)
    return np.concatenate(parts)


def _fault_residuals(parameters: MotorParameters, targets: Targets) -> list[FloatArray]:
    parts: list[FloatArray] = []
    speeds = targets.fault_speeds
    healthy = settled(parameters, speeds)
    for kind, target in targets.faults.items():
        broken = settled(parameters, speeds, BROKEN[kind])
        brush, casing = (broken[name] - healthy[name] for name in ("brush", "casing"))
        known = np.isfinite(target.casing_at_least)
        parts.append((brush - target.brush) / 0.4)
        parts.append(_beyond(brush - target.brush, 0.85, 0.03))
        parts.append(_above(target.casing_at_least[known] + 0.2, casing[known], 0.03))
        parts.append(_above(np.full(known.sum() - 1, 0.1), np.diff(casing[known]), 0.02))
        parts.append(_above(casing, 10.0, 1.0))
        parts.append(_above(broken["casing"], HOTTEST_CASING, 0.2))
        if kind == "bearing":
            parts.append((broken["casing"][speeds == 0.7] - HOTTEST_CASING) / 0.3)
    return parts


def _beyond(values: FloatArray, limit: float, scale: float) -> FloatArray:
    return np.maximum(0.0, np.abs(values) - limit) / scale


def _above(values: FloatArray, limit: FloatArray | float, scale: float) -> FloatArray:
    return np.maximum(0.0, values - limit) / scale
