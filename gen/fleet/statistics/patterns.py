"""What a fault would add to a motor's residual along a run: heat at each node, an offset and a gain of each sensor."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.errors import CheckFailed
from gen.model.network_parts import Curve, Heat
from gen.model.schedules import Polynomial
from gen.reference.simulate import simulate_run
from gen.runs import Run

MEAN_S = 60.0
"""Residuals are means over this time: a single reading's noise is no fault."""
PROBE = 0.05
"""The heat with which a node is probed, at full PWM, as a share of the motor's own there."""


@dataclass(frozen=True)
class Hypothesis:
    """One thing that may be different.

    Attributes
    ----------
    kind
        `heat`, `offset` or `gain`.
    node
        Where.
    """

    kind: str
    node: str

    def state(self, amount: float) -> str:
        """What a motor is that shows an amount of it."""
        if self.kind != "heat":
            return "sensor differs"
        return "warmer" if amount > 0.0 else "cooler"

    def said(self, amount: float, explained_K: float) -> str:
        """Say where and by how much; of heat also what it does to the readings, root mean square over all of them.

        A share of all heat alone would say little: a hidden node with a large capacity may have most of it, and
        nobody reads that node.
        """
        match self.kind:
            case "heat":
                shown_K = np.copysign(explained_K, amount)
                return f"at {self.node}, by {shown_K:+.2f} K in the readings, {amount:+.1%} of the motor's heat"
            case "offset":
                return f"of {self.node}, by {amount:+.2f} K"
            case _:
                return f"of {self.node}, by {amount:+.1%} of the rise"


def hypotheses_of(coefficients: Coefficients) -> tuple[Hypothesis, ...]:
    """Give what is looked for, nodes in the file's order."""
    network = coefficients.model.network
    if network is None:
        raise CheckFailed("the model is no network")
    heats = [Hypothesis("heat", node.name) for node in network.nodes]
    sensed = [node.name for node in network.sensed]
    return (*heats, *(Hypothesis(kind, name) for kind in ("offset", "gain") for name in sensed))


@dataclass(frozen=True, eq=False)
class Products:
    """A residual r and the H patterns p_h along one run, as inner products over B means of all sensors.

    Attributes
    ----------
    gram
        <p_h, p_k>, shape (H, H).
    along
        <p_h, r>, shape (H,).
    square
        <r, r>, K^2.
    count
        Means that took part.
    """

    gram: FloatArray
    along: FloatArray
    square: float
    count: int

    @property
    def error_K(self) -> float:
        """Root mean square of the residual, K; NaN where nothing was read."""
        return float(np.sqrt(self.square / self.count)) if self.count else float("nan")


def residual_of(coefficients: Coefficients, run: Run, file: str) -> FloatArray:
    """Give measured minus model, means over a minute, shape (B, S), K; NaN where nothing was read."""
    shown = simulate_run(coefficients, run, "exact", "auto", file)
    return _means(run, [_read(run, name) - shown[f"{name}_degC"] for name in coefficients.model.component_names])


def products_of(coefficients: Coefficients, run: Run, file: str) -> Products:
    """Hold a run's residual against each pattern.

    A pattern of heat is what the model shows with some more of it at a node, growing with |PWM|, less what it shows
    without, over that heat's share of all heat at full PWM; so any form of network, laws and effects included, gives
    its own.

    Raises
    ------
    CheckFailed
        When the model is no network.
    InputError
        When the run lacks what the model reads.
    """
    names = coefficients.model.component_names
    shown = simulate_run(coefficients, run, "exact", "auto", file)
    base = [np.asarray(shown[f"{name}_degC"], dtype=np.float64) for name in names]
    residual = _means(run, [_read(run, name) - values for name, values in zip(names, base, strict=True)])
    used = np.isfinite(residual)
    made = []
    for hypothesis in hypotheses_of(coefficients):
        if hypothesis.kind == "heat":
            probed = simulate_run(_probed(coefficients, hypothesis.node), run, "exact", "auto", file)
            pattern = [(probed[f"{name}_degC"] - values) / PROBE for name, values in zip(names, base, strict=True)]
        else:
            rise = [values - float(values[0]) for values in base]
            pattern = [
                (np.ones_like(run.time_s) if hypothesis.kind == "offset" else rise[s]) * (name == hypothesis.node)
                for s, name in enumerate(names)
            ]
        made.append(np.where(used, _means(run, pattern, fill=0.0), 0.0).ravel())
    patterns, flat = np.array(made), np.where(used, residual, 0.0).ravel()
    return Products(patterns @ patterns.T, patterns @ flat, float(flat @ flat), int(used.sum()))


def _probed(coefficients: Coefficients, node: str) -> Coefficients:
    model = coefficients.model
    assert model.network is not None
    full = np.array([float(model.full_scale)])
    watts = sum(float(heat.curve.turning(full)[0]) for heat in model.network.heats)
    more = Heat(node, Curve(Polynomial((PROBE * watts / model.full_scale, 0.0)), 0.0))
    network = replace(model.network, heats=(*model.network.heats, more))
    return replace(coefficients, model=replace(model, network=network))


def _read(run: Run, name: str) -> FloatArray:
    return run.temps.get(name, np.full(run.time_s.size, np.nan))


def _means(run: Run, columns: list[FloatArray], fill: float = np.nan) -> FloatArray:
    """Means over a minute of what is there, shape (B, S)."""
    index = ((run.time_s - run.time_s[0]) // MEAN_S).astype(np.int64)
    made = []
    for values in columns:
        good = np.isfinite(values)
        count = np.bincount(index[good], minlength=int(index[-1]) + 1)
        total = np.bincount(index[good], values[good], minlength=int(index[-1]) + 1)
        made.append(np.where(count > 0, total / np.maximum(count, 1), fill))
    return np.array(made).T
