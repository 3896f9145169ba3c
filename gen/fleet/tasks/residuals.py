"""One motor's newest runs against its own model and against the fleet's mean."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from gen.coefficients import Coefficients
from gen.errors import CheckFailed, InputError
from gen.fleet.folder.models import COMMON, in_use, model_path, read_model
from gen.fleet.folder.store import Kept, Store
from gen.fleet.statistics.patterns import Products, hypotheses_of, products_of, residual_of
from gen.fleet.tasks.motor_data import read
from gen.fleet.tasks.work import Arrays

LEAST_HOURS = 1.0
"""A run that is shorter does not tell a node from a sensor."""
LEAST_MEANS = 12
"""Means with readings, of all sensors together, that a run has at least: one every five minutes of the shortest."""


def newest_against_models(store: Store, *, motor: str, runs: list[list[str]], models: list[str]) -> Arrays:
    """Hold a motor's runs against both models (a task).

    Parameters
    ----------
    store, motor
        Whose.
    runs
        The newest ones, in time; the last is judged, the others are for the course of the error.
    models
        Hashes of both coefficient files: with other ones it is another task.
    """
    own, mean = (read_model(store, in_use(store, path)) for path in (model_path(motor), COMMON))
    *earlier, last = [Kept(*each) for each in runs]
    run = read(store, last)
    hours = float(run.time_s[-1] - run.time_s[0]) / 3600.0
    if hours < LEAST_HOURS:
        raise CheckFailed(f"{last.path} lasts {hours:.2f} h, expected {LEAST_HOURS:g} h")
    learnt = learnt_by(own)
    found = {"own": products_of(own, run, last.path), "mean": products_of(mean, run, last.path)}
    count = found["own"].count
    if count < LEAST_MEANS:
        raise CheckFailed(
            f"{last.path} has means over a minute of {', '.join(own.model.component_names)}: {count} in all, "
            f"expected {LEAST_MEANS} at least"
        )
    hypotheses = [[hypothesis.kind, hypothesis.node] for hypothesis in hypotheses_of(own)]
    if hypotheses != [[hypothesis.kind, hypothesis.node] for hypothesis in hypotheses_of(mean)]:
        raise CheckFailed("the motor's model has other nodes than the fleet's")
    return {
        "errors_K": np.array([*(_error_K(store, own, each) for each in earlier), found["own"].error_K]),
        "seen": np.array(f"{last.name}.parquet" in learnt),
        "learnt": np.array(len(learnt)),
        "hypotheses": np.array(json.dumps(hypotheses)),
        **{f"{name}_{key}": value for name, products in found.items() for key, value in _arrays(products).items()},
    }


def _error_K(store: Store, model: Coefficients, kept: Kept) -> float:
    """Root mean square of a run's residual, K; NaN where it cannot be read, or has no reading."""
    try:
        residual = residual_of(model, read(store, kept), kept.path)
    except InputError:
        return float("nan")
    told = residual[np.isfinite(residual)]
    return float(np.sqrt(np.mean(told**2))) if told.size else float("nan")


def learnt_by(coefficients: Coefficients) -> set[str]:
    """Give the names of the runs that a model was fitted to."""
    provenance = coefficients.document.provenance
    return set() if provenance is None else set(provenance.data)


def products_in(arrays: Arrays, which: str) -> Products:
    """Read what the task gives for one of both models, `own` or `mean`."""
    return Products(
        arrays[f"{which}_gram"],
        arrays[f"{which}_along"],
        float(arrays[f"{which}_square"]),
        int(arrays[f"{which}_count"]),
    )


def _arrays(products: Products) -> dict[str, Any]:
    return {
        "gram": products.gram,
        "along": products.along,
        "square": np.array(products.square),
        "count": np.array(products.count),
    }
