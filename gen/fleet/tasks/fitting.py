"""One motor in the common form, with the fleet as its prior: what its runs say, and its coefficient file."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import dump, parse
from gen.coefficients.names import name_fault
from gen.fleet.folder.store import Kept, Store
from gen.fleet.statistics.pooling import integrated_out
from gen.fleet.tasks.common import Common, common_of
from gen.fleet.tasks.motor_data import data_of, usable
from gen.fleet.tasks.work import Arrays
from gen.identification.logs.sources import Source
from gen.identification.network.data import NetworkData
from gen.identification.network.fitting.bins import Binned
from gen.identification.network.fitting.inputs import inputs_of
from gen.identification.network.identify import NetworkFound
from gen.identification.network.left_out import LeftOut, folds_of, left_out
from gen.identification.network.search import Found, tightened
from gen.identification.network.starts import taken_over
from gen.identification.network.telling.document import network_text
from gen.identification.settings import Settings

AT_FIRST, AT_LAST = 14, 8
"""Linearisations, on the coarse bins and then on the fine ones."""


def fitted_in_common(store: Store, *, runs: list[list[str]], ambient: float | None, common: dict[str, Any]) -> Arrays:
    """Fit one motor on the coarse bins; give what its runs say of the shared parameters, and what is left (a task)."""
    form = common_of(common)
    said = usable(store, [Kept(*run) for run in runs])
    found = _fit(form, data_of(said.sources, ambient, form.structure.sensed).coarse)
    matrix, vector = told_by(found)
    read = found.problem.inputs.covered > 0.0
    off_K = np.sqrt(np.mean(found.fit.evaluated.residual[read] ** 2))
    return {"matrix": matrix, "vector": vector, "off_K": np.array(off_K)}


def model_in_common(
    store: Store, *, motor: str, runs: list[list[str]], ambient: float | None, common: dict[str, Any]
) -> Arrays:
    """Fit one motor on the fine bins and write its coefficient file's text (a task)."""
    form = common_of(common)
    said = usable(store, [Kept(*run) for run in runs])
    result = found_in(form, said.sources, ambient)
    note = f"in the form of its fleet, whose spread is the prior; motor {motor}"
    text = _said_of_fleet(network_text(result, Settings(model_name(motor)), note)[0])
    return {
        "text": np.array(text),
        "left_out_K": np.sqrt(np.nanmean(result.judged.by_fold, axis=0)),
        "lines": np.array(said.lines, dtype=np.str_),
    }


def found_in(form: Common, sources: tuple[Source, ...], ambient: float | None) -> NetworkFound:
    """Identify a motor in the common form, its structure given."""
    data = data_of(sources, ambient, form.structure.sensed)
    coarse = _fit(form, data.coarse)
    inputs = inputs_of(data.fine)
    problem = form.problem(inputs)
    start = taken_over(problem, coarse.problem, coarse.vector)
    fine = tightened(problem, start, coarse.density, AT_LAST, rounds=2)
    judged = left_out(coarse, folds_of(coarse.problem.inputs))
    return NetworkFound(data, fine, judged, coarse.problem.inputs, ())


def mean_model(form: Common, data: NetworkData) -> str:
    """Give the coefficient file of the fleet's mean, with the errors that it has on some motors' runs."""
    narrow = replace(form, pool=replace(form.pool, variance=np.full(form.structure.size, 1e-10)))
    held = _fit(narrow, data.coarse)
    # Nothing of these runs is in the mean's own uncertainty, which is the fleet's spread.
    nothing = replace(held.fit.normal, matrix=np.zeros_like(held.fit.normal.matrix))
    problem = form.problem(held.problem.inputs).weighed(held.problem.inputs.weight)
    found = Found(problem, replace(held.fit, normal=nothing), held.density)
    inputs, residual = problem.inputs, held.fit.evaluated.residual
    missing = np.where(inputs.covered > 0.0, residual, np.nan)
    squares = np.array([_mean_square(inputs.covered[row], residual[row]) for row in inputs.rows])
    coarse = replace(data, fine=data.coarse)
    result = NetworkFound(coarse, found, LeftOut(missing, squares), inputs, ())
    return _said_of_fleet(network_text(result, Settings("common"), "the mean of a fleet; errors are its motors'")[0])


def told_by(found: Found) -> tuple[FloatArray, FloatArray]:
    """Give what runs say of the shared parameters alone, as a normal matrix and its right-hand side.

    What is a run's own (starts, an unmeasured room) is integrated out with its prior.

    Returns
    -------
    matrix, vector
        Shapes (p, p) and (p,): of the parameters themselves, not of a step from the fit.
    """
    problem, fit = found.problem, found.fit
    shared = problem.structure.size
    matrix, right = np.zeros((problem.size, problem.size)), np.zeros(problem.size)
    for run in range(problem.runs):
        at = problem.columns(run)
        matrix[np.ix_(at, at)] += fit.normal.matrix[run]
        right[at] += fit.normal.vector[run]
    own = slice(shared, None)
    prior = problem.prior
    matrix[own, own] += prior.precision[own, own]
    right[own] -= prior.precision[own, own] @ (fit.vector[own] - prior.mean[own])
    told, step = integrated_out(matrix, right, np.arange(shared))
    return told, told @ fit.vector[:shared] + step


def model_name(motor: str) -> str:
    """Give a name that firmware can have; motors' names may begin with a digit and have dots."""
    name = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]", "_", motor)).strip("_")
    name = name if name[:1].isalpha() else f"motor_{name}"
    return "motor" if name_fault(name) else name


def _fit(form: Common, bins: tuple[Binned, ...]) -> Found:
    problem = form.problem(inputs_of(bins))
    return tightened(problem, problem.prior.mean.copy(), form.density, AT_FIRST)


def _said_of_fleet(text: str) -> str:
    """The same file, with this command as its source."""
    document = parse(text.encode()).document
    provenance = document.provenance
    assert provenance is not None
    return dump(document.model_copy(update={"provenance": provenance.said_by("gen fleet identify")}))


def _mean_square(covered: FloatArray, residual: FloatArray) -> FloatArray:
    total = covered.sum(axis=0)
    return np.where(total > 0.0, np.sum(covered * residual**2, axis=0) / np.maximum(total, 1e-9), np.nan)
