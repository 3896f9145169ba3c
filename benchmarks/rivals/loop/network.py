"""A grey-box network of two nodes with CasADi: its equations by symbols, its exact derivatives, and scipy's search."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from benchmarks.identify_rivals import STEP, FloatArray, Predictor, blocks, pairs
from benchmarks.rivals.missing import library
from gen.runs import Run

STARTS: tuple[tuple[float, ...], ...] = (
    (-3.5, -7.8, -8.0, -7.0, -7.0, -9.0, 1.0, 1.0, 0.0, 0.0),
    (-3.5, -7.0, -7.5, -5.0, -6.5, -8.0, 1.5, 0.6, 1.0, 0.0),
)
"""Two beginnings of the search; the better end counts."""
LIMITS = (
    (-9.0, -12.0, -12.0, -12.0, -12.0, -14.0, 0.2, 0.2, -8.0, -5.0),
    (0.0, -3.0, -3.0, -2.5, -2.5, -3.0, 4.0, 4.0, 8.0, 5.0),
)
"""Logarithms of the heat (K/s) and of five rates (1/s), two exponents, the logit of a share, an offset (K)."""


def casadi_network(runs: list[Run]) -> Predictor:
    """Fit a node with the sensor and one behind it: power laws for the heat and the air, losses of both to the room.

    Parameters
    ----------
    runs
        From cold.

    Raises
    ------
    LibraryMissing
        When CasADi is not installed.
    """
    casadi = library("casadi")
    data = pairs(runs)
    response = [_response(casadi, len(u)) for u, _ in data]
    slope = [made.factory("slope", made.name_in(), ["jac:rise:p"]) for made in response]

    def misses(p: FloatArray) -> FloatArray:
        return np.concatenate([_flat(made(p, u)) - y for made, (u, y) in zip(response, data, strict=True)])

    def slopes(p: FloatArray) -> FloatArray:
        rows = [np.asarray(made(p, u), dtype=np.float64) for made, (u, _) in zip(slope, data, strict=True)]
        return np.asarray(np.vstack(rows), dtype=np.float64)

    ends = [least_squares(misses, start, slopes, bounds=LIMITS, x_scale=1.0, max_nfev=100) for start in STARTS]
    found = min(ends, key=lambda end: float(end.cost)).x

    def predict(pwm: NDArray[np.int64]) -> FloatArray:
        u = blocks(np.abs(pwm) / 255.0)
        return _flat(_response(casadi, len(u))(found, u))

    return predict


def _response(casadi: Any, count: int) -> Any:  # noqa: ANN401
    """Rise at the ends of so many blocks, as a function of the parameters and the drive, by Runge-Kutta of order 4."""
    p, state, drive = casadi.SX.sym("p", len(STARTS[0])), casadi.SX.sym("state", 2), casadi.SX.sym("u")
    rates = casadi.Function("rates", [state, drive, p], [_rates(casadi, state, drive, p)])
    one = rates(state, drive, p)
    two = rates(state + STEP / 2 * one, drive, p)
    three = rates(state + STEP / 2 * two, drive, p)
    four = rates(state + STEP * three, drive, p)
    step = casadi.Function("step", [state, drive, p], [state + STEP / 6 * (one + 2 * two + 2 * three + four)])
    q, inputs = casadi.MX.sym("p", len(STARTS[0])), casadi.MX.sym("u", count)
    whole = step.mapaccum(count - 1)
    between = (inputs[:-1] + inputs[1:]) / 2  # from the middle of one block to that of the next
    states = whole(casadi.DM.zeros(2), between.T, casadi.repmat(q, 1, count - 1))
    rise = casadi.vertcat(0, states[0, :].T) + q[9]
    return casadi.Function("response", [q, inputs], [rise], ["p", "u"], ["rise"])


def _rates(casadi: Any, state: Any, u: Any, p: Any) -> Any:  # noqa: ANN401
    """K/s of the node with the sensor and of the one behind it."""
    turning = casadi.fmax(u, 1e-6)
    heat, share = casadi.exp(p[0]) * turning ** p[6], 1 / (1 + casadi.exp(-p[8]))
    cooling = casadi.exp(p[1]) + casadi.exp(p[2]) * turning ** p[7]
    near, far, lost = casadi.exp(p[3]), casadi.exp(p[4]), casadi.exp(p[5])
    exchanged = state[1] - state[0]
    return casadi.vertcat(
        share * heat - cooling * state[0] + near * exchanged, (1 - share) * heat - lost * state[1] - far * exchanged
    )


def _flat(values: Any) -> FloatArray:  # noqa: ANN401
    return np.asarray(values, dtype=np.float64).ravel()
