"""How uncertain a forecast is: the spread of the parameters along a profile of holds and stops that no run had."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.bins import binned
from gen.identification.network.fitting.inputs import Inputs, inputs_of
from gen.identification.network.fitting.priors import prior_of
from gen.identification.network.fitting.problem import Evaluated, Problem
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.search import Found
from gen.identification.network.telling.uncertainty import FORM, SENSOR_K, Spread
from gen.runs import Run

HOURS, ROW_S = 6.0, 10.0
HOLD_S = (300.0, 2100.0)
STOPS = 0.25
"""Share of the holds that are stops."""
AMBIENT = 25.0


@dataclass(frozen=True, eq=False)
class Foresight:
    """Standard deviations along the profile.

    Attributes
    ----------
    pwm
        Mean |PWM| of each bin, shape (N,), counts.
    rest
        Share of the bin at PWM 0, shape (N,).
    deviation
        Of the modelled reading, shape (N, S), K.
    """

    pwm: FloatArray
    rest: FloatArray
    deviation: FloatArray

    def within(self, low: int, high: int) -> FloatArray:
        """Root mean square of the deviations at |PWM| in a range, shape (S,), K."""
        inside = (self.pwm >= low - 0.5) & (self.pwm <= high + 0.5)
        mine = self.rest > 0.5 if high == 0 else (self.rest <= 0.5) & inside
        mine = mine if mine.any() else np.ones_like(mine)
        return np.asarray(np.sqrt(np.mean(self.deviation[mine] ** 2, axis=0)))


def foresight(found: Found, spread: Spread, measured: tuple[int, int], full_scale: int) -> Foresight:
    """Give the uncertainty of a forecast.

    Parameters
    ----------
    found, spread
        The network and its parameters' covariance.
    measured
        Lowest and highest |PWM| that turned in the runs.
    full_scale
        The count that is 100 %.
    """
    structure = found.structure
    inputs, evaluated, shared = along(found, _profile(measured), full_scale)
    covariance = spread.covariance[: structure.size, : structure.size]
    variance = np.einsum("nsp,pq,nsq->ns", shared, covariance, shared, optimize=True)
    rise = evaluated.after[:, : len(structure.sensed)] - AMBIENT
    whole = np.maximum(variance, 0.0) + SENSOR_K**2 + (FORM * rise) ** 2
    return Foresight(inputs.speed * full_scale, inputs.rest, np.sqrt(whole))


def along(found: Found, run: Run, full_scale: int) -> tuple[Inputs, Evaluated, FloatArray]:
    """Follow the network along a profile that nobody measured.

    Returns
    -------
    inputs, evaluated, slopes
        Its bins, the temperatures, and the derivatives of the modelled readings by the parameters that all runs share,
        shape (N, S, p).
    """
    structure = found.structure
    around = np.full(run.time_s.size, AMBIENT)
    whole = replace(run, temps=dict.fromkeys(structure.sensed, around))
    inputs = inputs_of([binned("forecast", whole, structure.sensed, around, full_scale)])
    scale = Scale(np.full(len(structure.sensed), 1e3), np.full(len(structure.sensed), 10.0))
    problem = Problem(structure, inputs, prior_of(structure, inputs, scale))
    vector = np.zeros(problem.size)
    vector[: structure.size] = found.vector[: structure.size]
    evaluated, slopes = problem.slopes(vector)
    return inputs, evaluated, slopes[..., : structure.size].astype(np.float64)


def _profile(measured: tuple[int, int]) -> Run:
    """Holds of some minutes at random speeds, and stops; the same ones each time."""
    chance = np.random.default_rng(0)
    low, high = measured
    total = int(HOURS * 3600.0 / ROW_S)
    pwm = np.zeros(total, dtype=np.int64)
    at = 0
    while at < total:
        rows = int(chance.uniform(*HOLD_S) / ROW_S)
        pwm[at : at + rows] = 0 if at and chance.random() < STOPS else int(chance.integers(low, high + 1))
        at += rows
    return Run(ROW_S * np.arange(total, dtype=np.float64), pwm)
