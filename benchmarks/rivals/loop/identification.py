"""Identifiers on the same runs of random plants (`benchmarks.identify_rivals`): free runs on fresh profiles."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from benchmarks.identify_rivals import RIVALS, STEP, FloatArray, Predictor, blocks, pairs
from benchmarks.rivals.loop.network import casadi_network
from benchmarks.rivals.missing import LibraryMissing, library
from benchmarks.scheduled_plants import AMBIENT, fresh_profile, random_plant, simulate, step_runs
from gen.runs import Run

SEED = 20_418
OURS = "gen identify"
CASADI = "grey-box network of two nodes, CasADi"
LIBRARIES = {"SysIdentPy, NARMAX degree 2": "sysidentpy", CASADI: "casadi"}


@dataclass(frozen=True)
class Identified:
    """One identifier's errors.

    Attributes
    ----------
    title
        Its name.
    error_K
        Root mean square error on each plant's fresh profile, K; infinite where it diverged.
    seconds
        Processor time of the fits, s.
    missing
        Why nothing was measured.
    """

    title: str
    error_K: list[float] = field(default_factory=list)
    seconds: float = 0.0
    missing: str | None = None


def grey_box(runs: list[Run]) -> Predictor:
    """Fit two heat capacities by hand: heating and cooling that grow with the drive, and an exchange between them."""
    data = pairs(runs)

    def response(p: FloatArray, u: FloatArray) -> FloatArray:
        heat, more, cool, fan, exchange, other = np.exp(p[:6])
        out, inner = np.zeros(len(u)), 0.0
        for k in range(1, len(u)):
            drive = (u[k - 1] + u[k]) / 2
            rate = cool + fan * drive
            out[k] = out[k - 1] + STEP * (
                heat * drive + more * drive**2 - rate * out[k - 1] + exchange * (inner - out[k - 1])
            )
            inner += STEP * other * (out[k - 1] - inner)
            if not abs(out[k]) < 1e4:
                return np.full(len(u), 1e4)
        return np.asarray(out + p[6], dtype=np.float64)

    def misses(p: FloatArray) -> FloatArray:
        return np.concatenate([response(p, u) - y for u, y in data])

    start = np.array([*np.log([0.02, 0.02, 4e-4, 4e-4, 1e-3, 1e-3]), 0.0])
    found = np.asarray(least_squares(misses, start, x_scale="jac", max_nfev=60).x, dtype=np.float64)

    def predict(pwm: NDArray[np.int64]) -> FloatArray:
        return response(found, blocks(np.abs(pwm) / 255.0))

    return predict


def identified(count: int, tell: Callable[[str], None]) -> list[Identified]:
    """Fit all on the same plants.

    Parameters
    ----------
    count
        How many plants.
    tell
        Told what is being done.
    """
    ways: dict[str, Callable[[list[Run]], Predictor]] = {
        name: fit for name, fit in RIVALS.items() if not name.startswith("ARX")
    }
    ways["grey box by hand, two capacities"] = grey_box
    ways[CASADI] = casadi_network
    return [_one(title, fit, count, tell) for title, fit in ways.items()]


def _one(title: str, fit: Callable[[list[Run]], Predictor], count: int, tell: Callable[[str], None]) -> Identified:
    if missing := absent(title):
        return Identified(title, missing=missing)
    errors, seconds = [], 0.0
    for number in range(count):
        tell(f"{title}: plant {number + 1} of {count}")
        rng = np.random.default_rng([SEED, number])
        plant = random_plant(rng)
        runs = step_runs(plant, rng)
        pwm = fresh_profile(rng, known=True)
        true = blocks(simulate(plant, pwm)) - AMBIENT + plant.bias
        begun = time.process_time()
        with np.errstate(all="ignore"):
            predict = fit(runs)
            seconds += time.process_time() - begun
            errors.append(rms(predict(pwm) - true))
    return Identified(title, errors, seconds)


def absent(title: str) -> str | None:
    """Why a way cannot be tried: its library is not installed."""
    try:
        if title in LIBRARIES:
            library(LIBRARIES[title])
    except LibraryMissing as error:
        return str(error)
    return None


def rms(error: NDArray[np.float64]) -> float:
    """Root mean square, K; infinite where it diverged."""
    value = float(np.sqrt(np.mean(error**2)))
    return value if value < 1e3 else float("inf")
