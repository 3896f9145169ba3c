"""A small neural network of the rises, trained with scikit-learn on the exact solution, as emlearn writes it."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.rivals.missing import library
from gen.model import ExactSolution, ThermalModel

FloatArray = NDArray[np.float64]
MEANS_S = (150.0, 600.0, 1500.0, 3600.0)
"""Time constants of the slow means that stand for the past, s."""
HIDDEN = (16,)
RUNS, LENGTH, EVERY = 60, 43_200, 240
"""Runs that it learns from, their samples, and which of them."""
SCALE_K = 50.0


def write(model: ThermalModel, folder: Path) -> Path:
    """Write ``neural_net.h`` into a folder.

    Returns
    -------
    Path
        Where emlearn keeps its own headers.

    Raises
    ------
    LibraryMissing
        When emlearn or scikit-learn is not installed.
    """
    net, common = library("emlearn.net"), library("emlearn.common")
    learner = library("sklearn.neural_network").MLPRegressor(
        hidden_layer_sizes=HIDDEN,
        activation="relu",
        solver="lbfgs",
        alpha=1e-6,
        max_iter=500,
        max_fun=10**6,
        random_state=0,
    )
    shares = 1.0 - np.exp(-model.sample_time / np.array(MEANS_S))
    inputs, rises = lessons(model, shares)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it could go on learning
        learner.fit(inputs, rises / SCALE_K)
    text = net.c_generate_net_loadable(
        [*["relu"] * len(HIDDEN), "identity"], learner.coefs_, learner.intercepts_, "rises"
    )
    listed = ", ".join(f"{share:.9e}f" for share in shares)
    text += f"\n#define MEANS {len(shares)}\nstatic const float SHARES[MEANS] = {{{listed}}};\n"
    text += f"static const float SCALE_K = {SCALE_K}f;\n"
    (folder / "neural_net.h").write_text(text, encoding="utf-8")
    return Path(common.get_include_dir())


def features(pwm: NDArray[np.int64], shares: FloatArray) -> FloatArray:
    """Give what the network sees after each sample: |PWM| / 255, its slow means, and those of its square."""
    u = np.abs(pwm) / 255.0
    means = [lfilter([s], [1.0, s - 1.0], drive) for drive in (u, u * u) for s in shares]
    return np.column_stack([u, *means])


def lessons(model: ThermalModel, shares: FloatArray, seed: int = 2026) -> tuple[FloatArray, FloatArray]:
    """Make runs at random levels, held for seconds to hours, every third between two only, with their exact rises in K.

    Returns
    -------
    inputs, rises
        Shapes (n, features) and (n, components).
    """
    rng = np.random.default_rng(seed)
    exact = ExactSolution(model)
    inputs, rises = [], []
    for run in range(RUNS):
        hold = int(np.exp(rng.uniform(np.log(8), np.log(LENGTH))))
        levels = rng.integers(51, 256, LENGTH // hold + 1)
        pwm = np.repeat(levels if run % 3 else np.resize(levels[:2], levels.size), hold)[:LENGTH]
        solved = exact.simulate(pwm)
        inputs.append(features(pwm, shares)[::EVERY])
        rises.append(np.column_stack([solved[name][1::EVERY] for name in model.component_names]))
    return np.concatenate(inputs), np.concatenate(rises)
