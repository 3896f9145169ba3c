"""Forms of a schedule over |PWM|: what may stand for time constants and steady rise between the identified speeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import least_squares

from gen.arrays import FloatArray
from gen.model.dynamics import MAX_PWM

Kind = Literal["poly", "exp2", "linear", "pchip", "trend"]
FULL = float(MAX_PWM)

_DEGREES = ("constant", "straight line", "parabola", "cubic")
_CURVES = {
    "exp2": "sum of two exponentials",
    "linear": "straight lines from point to point",
    "pchip": "smooth curve through the points",
    "trend": "{} and a smooth curve through what it leaves",
}
_QUANTITIES = {
    "log": "(of the logarithm)",
    "rate": "(of the pole)",
    "rise": "(of the steady rise)",
    "per_count": "(of the rise per count)",
    "numerator": "(of the gain K)",
}


@dataclass(frozen=True)
class Form:
    """One way to draw a curve through, or near, values at the identified speeds.

    Attributes
    ----------
    quantity
        What is drawn: of a time constant "log" (its logarithm) or "rate" (its inverse, the pole); of the gain
        "rise" (steady rise, zero at PWM 0), "log" (logarithm of rise per count), "per_count", or "numerator" (K of the
        coefficient file, as the source study does).
    kind
        "poly" of a degree; "exp2" a e^(bx) + c e^(dx); "linear" or "pchip" through the points; "trend" a polynomial of
        a degree, and the rest through the points by pchip.
    degree
        Of "poly" and "trend".
    """

    quantity: str
    kind: Kind
    degree: int = 0

    @property
    def name(self) -> str:
        """For people."""
        shape = f"{self.kind}{self.degree}" if self.kind in ("poly", "trend") else self.kind
        return f"{self.quantity} {shape}"

    @property
    def words(self) -> str:
        """What the name stands for."""
        if self.kind == "poly" and self.degree == 0:
            return "the same at every speed"
        curve = _DEGREES[self.degree] if self.kind == "poly" else _CURVES[self.kind].format(_DEGREES[self.degree])
        return f"{curve} {_QUANTITIES[self.quantity]}"

    @property
    def interpolates(self) -> bool:
        """Whether the curve goes through every point."""
        return self.kind in ("linear", "pchip", "trend")

    def size(self, points: int) -> int:
        """Number of parameters with that many points."""
        if self.interpolates:
            return points
        return 4 if self.kind == "exp2" else self.degree + 1

    def least_points(self) -> int:
        """Fewest points that determine it."""
        return {"poly": self.degree + 1, "exp2": 4, "linear": 1, "pchip": 1, "trend": self.degree + 1}[self.kind]

    def fit(self, nodes: FloatArray, values: FloatArray, weights: FloatArray) -> FloatArray:
        """Give the parameters for values at nodes.

        Parameters
        ----------
        nodes, values, weights
            |PWM|, what to draw, and one over its standard deviation, shape (n,).
        """
        if self.interpolates:
            return values.copy()
        if self.kind == "poly":
            return _poly_fit(nodes, values, weights, self.degree)
        return _exp2_fit(nodes, values, weights)

    def evaluate(self, parameters: FloatArray, nodes: FloatArray, x: FloatArray) -> FloatArray:
        """Evaluate at |PWM| x, shape (m,); beyond the outermost points as the form goes on by itself."""
        if self.kind == "poly":
            return np.asarray(np.polyval(parameters, x / FULL), dtype=np.float64)
        if self.kind == "exp2":
            a, b, c, d = parameters
            return np.asarray(a * np.exp(b * x / FULL) + c * np.exp(d * x / FULL), dtype=np.float64)
        if len(nodes) == 1:
            return np.full(len(x), parameters[0])
        if self.kind == "linear":
            return np.interp(x, nodes, parameters)
        if self.kind == "pchip":
            return _pchip(nodes, parameters, x)
        trend = _poly_fit(nodes, parameters, np.ones(len(nodes)), self.degree)
        rest = parameters - np.polyval(trend, nodes / FULL)
        held = np.clip(x, nodes[0], nodes[-1])
        return np.asarray(np.polyval(trend, x / FULL) + _pchip(nodes, rest, held), dtype=np.float64)


def _poly_fit(nodes: FloatArray, values: FloatArray, weights: FloatArray, degree: int) -> FloatArray:
    matrix = np.vander(nodes / FULL, degree + 1)
    solved = np.linalg.lstsq(matrix * weights[:, None], values * weights, rcond=None)[0]
    return np.asarray(solved, dtype=np.float64)


def _pchip(nodes: FloatArray, values: FloatArray, x: FloatArray) -> FloatArray:
    """Interpolate; beyond the ends go on along the straight line there."""
    if len(nodes) == 2:
        return np.asarray(values[0] + (values[1] - values[0]) * (x - nodes[0]) / (nodes[1] - nodes[0]))
    curve = PchipInterpolator(nodes, values)
    slope = curve.derivative()
    inside = np.asarray(curve(np.clip(x, nodes[0], nodes[-1])), dtype=np.float64)
    low, high = np.minimum(x - nodes[0], 0.0), np.maximum(x - nodes[-1], 0.0)
    return np.asarray(inside + low * slope(nodes[0]) + high * slope(nodes[-1]), dtype=np.float64)


def _exp2_fit(nodes: FloatArray, values: FloatArray, weights: FloatArray) -> FloatArray:
    """Fit from several starts; the two amplitudes follow linearly from the two rates."""
    x = nodes / FULL

    def amplitudes(rates: FloatArray) -> FloatArray:
        matrix = np.exp(np.outer(x, rates)) * weights[:, None]
        return np.asarray(np.linalg.lstsq(matrix, values * weights, rcond=1e-9)[0], dtype=np.float64)

    def residual(rates: FloatArray) -> FloatArray:
        return np.asarray((np.exp(np.outer(x, rates)) @ amplitudes(rates) - values) * weights, dtype=np.float64)

    best: FloatArray | None = None
    least = np.inf
    for start in ((-0.3, -3.0), (-1.0, 1.0), (0.5, 3.0)):
        found = least_squares(residual, start, bounds=(-12.0, 6.0), max_nfev=60)
        if found.cost < least:
            least, best = found.cost, np.asarray(found.x, dtype=np.float64)
    assert best is not None
    a, c = amplitudes(best)
    return np.array([a, best[0], c, best[1]])


TIME_FORMS = (
    *(Form("log", "poly", d) for d in range(4)),
    *(Form("rate", "poly", d) for d in (1, 2)),
    Form("rate", "exp2"),
    Form("log", "linear"),
    Form("log", "pchip"),
    Form("rate", "pchip"),
    *(Form("log", "trend", d) for d in (1, 2)),
)
GAIN_FORMS = (
    *(Form("log", "poly", d) for d in range(4)),
    *(Form("per_count", "poly", d) for d in (1, 2)),
    *(Form("numerator", "poly", d) for d in (1, 2)),
    Form("numerator", "exp2"),
    Form("rise", "pchip"),
    Form("rise", "linear"),
    Form("log", "pchip"),
    Form("numerator", "pchip"),
    *(Form("log", "trend", d) for d in (1, 2)),
    *(Form("per_count", "trend", d) for d in (1, 2)),
)
