"""Tasks of `gen fleet refine`: one motor's newer runs against its network with the fleet's effects on it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from gen.coefficients import Coefficients, parse
from gen.errors import CheckFailed
from gen.fleet.folder.models import model_path, read_model
from gen.fleet.folder.store import Kept, Store
from gen.fleet.statistics.patterns import residual_of
from gen.fleet.statistics.pooling import integrated_out
from gen.fleet.statistics.shared_effects import Key, bare, key_of, network_of, variants, with_means
from gen.fleet.tasks.motor_data import usable
from gen.fleet.tasks.work import Arrays
from gen.identification.logs.sources import Source
from gen.identification.network.fitting.fit import settle
from gen.identification.network.fitting.priors import Prior
from gen.refinement.condense import measured_in
from gen.refinement.network.effects import NetworkEffect, Offered, candidates
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data, make_data
from gen.refinement.network.fitting.fit import AT_EACH, GOOD, Bench, Fitted
from gen.refinement.network.tracing.judged import Judged, judged
from gen.refinement.network.tracing.search import PRICE, leaves_some

HELD = 1e-6
"""Standard deviation of what a file says, while an effect on top of it is measured."""


@dataclass(frozen=True, eq=False)
class Beside:
    """A motor with the effects that all motors show.

    Attributes
    ----------
    bench
        Its newer runs, and its file.
    now
        The file with these effects, all free that the file leaves open.
    every
        All candidates.
    """

    bench: Bench
    now: Judged
    every: tuple[NetworkEffect, ...]

    def with_one(self, key: Key) -> Judged:
        """Put one more effect on it."""
        best = _with_one(self.bench, self.now.fitted, self.every, key)
        return judged(self.bench.data, best, self.bench.left_out(best))


def promised(store: Store, *, motor: str, runs: list[list[str]], model: str, found: list[Key]) -> Arrays:
    """Say what each candidate promises beside those that were found (a task); `model` is the file's hash.

    The decrease of the weighed squares by one linear step, what its numbers cost taken off; none where little is left.
    """
    del model
    at = _beside(store, motor, runs, found)
    base = at.now.fitted
    gains: dict[str, float] = {}
    for effect in at.every if leaves_some(at.bench, at.now) else ():
        gain = at.bench.promise(base.shape.with_effects(*base.shape.effects, effect), base)
        name = json.dumps(key_of(effect), sort_keys=True)
        gains[name] = max(gain - PRICE * effect.freedom, gains.get(name, -np.inf))
    return {
        "gains": np.array(json.dumps(gains)),
        "offered": np.array(json.dumps(asdict(at.bench.data.offered))),
    }


def compared(
    store: Store, *, motor: str, runs: list[list[str]], model: str, found: list[Key], keys: list[Key]
) -> Arrays:
    """Give the left-out error, K, without and with each of some effects (a task); NaN where one cannot act."""
    del model
    at = _beside(store, motor, runs, found)
    scores = []
    for key in keys:
        try:
            scores.append(at.with_one(key).score_K)
        except CheckFailed:
            scores.append(np.nan)
    return {"without_K": np.array(at.now.score_K), "with_K": np.array(scores)}


def numbers_told(
    store: Store, *, motor: str, runs: list[list[str]], model: str, found: list[Key], offered: dict[str, Any]
) -> Arrays:
    """Give what a motor's runs say of the effects' numbers on top of its file as it is (a task).

    In standard deviations of each number's own prior from its mean, so that all are of one size.
    """
    del model
    coefficients, data = _read(store, motor, runs)
    fitted = _on_top(data, _with_effects(coefficients, data, found, Offered(**offered)))
    shape, problem = fitted.shape, fitted.problem
    columns = np.concatenate([place.columns for place in shape.places])
    mean = problem.prior.mean[columns]
    scale = np.array([number.deviation for effect in shape.effects for number in effect.numbers])
    matrix, right = problem.assembled(fitted.fit.normal, fitted.vector)
    own = problem.prior.precision[np.ix_(columns, columns)]
    matrix[np.ix_(columns, columns)] -= own
    right[columns] += own @ (fitted.vector[columns] - mean)
    told, step = integrated_out(matrix, right, columns)
    vector = told @ (fitted.vector[columns] - mean) + step
    return {"matrix": scale[:, None] * told * scale, "vector": scale * vector}


def errors_with(
    store: Store,
    *,
    motor: str,
    runs: list[list[str]],
    model: str,
    found: list[Key],
    offered: dict[str, Any],
    mean: list[float],
) -> Arrays:
    """Give the error of a motor's file on its newer runs, without and with the fleet's effects, K (a task)."""
    del model
    text = store.read(model_path(motor)).decode()
    files = [parse(each.encode()) for each in (text, with_means(text, found, np.array(mean), Offered(**offered)))]
    sources = _sources(store, runs)
    squares = [np.concatenate([residual_of(file, each.run, each.name) ** 2 for each in sources]) for file in files]
    return {"error_K": np.sqrt([np.nanmean(each) for each in squares])}


def _read(store: Store, motor: str, runs: list[list[str]]) -> tuple[Coefficients, Data]:
    """A motor's file as it was identified, and its newer runs."""
    coefficients = read_model(store, model_path(motor))
    network_of(coefficients)
    sources = _sources(store, runs)
    named = [(source.name, measured_in(coefficients, source.run, source.name)) for source in sources]
    data = make_data(coefficients, named)
    # Walls that lag belong to a room, and so does its sensor: motors that stand elsewhere have others.
    return coefficients, replace(data, offered=replace(data.offered, room_moves=False, room_measured=False))


def _sources(store: Store, runs: list[list[str]]) -> tuple[Source, ...]:
    sources = usable(store, [Kept(*run) for run in runs]).sources
    if not sources:
        raise CheckFailed("no newer run can be used")
    return sources


def _beside(store: Store, motor: str, runs: list[list[str]], found: Sequence[Key]) -> Beside:
    """Fit the file with what was found, all free that the file leaves open."""
    coefficients, data = _read(store, motor, runs)
    bench = Bench(data)
    shape = bare(coefficients, data.columns)
    fitted = bench.first(shape)
    every = candidates(shape.motor(), data.offered)
    for key in found:
        best = _with_one(bench, fitted, every, key)
        fitted = bench.tightened(best.shape, best.vector)
    return Beside(bench, judged(data, fitted, bench.left_out(fitted)), tuple(every))


def _with_one(bench: Bench, fitted: Fitted, every: Sequence[NetworkEffect], key: Key) -> Fitted:
    """Fit one more effect, from wherever its search ends best."""
    shape = fitted.shape
    fits = [bench.fit(shape.with_effects(*shape.effects, one), fitted) for one in variants(every, key)]
    return min(fits, key=lambda one: one.fit.cost)


def _with_effects(coefficients: Coefficients, data: Data, found: Sequence[Key], offered: Offered) -> Anchored:
    """The file with effects whose numbers mean the same in the whole fleet."""
    shape = bare(coefficients, data.columns)
    every = candidates(shape.motor(), offered)
    return shape.with_effects(*(variants(every, key)[0] for key in found))


def _on_top(data: Data, shape: Anchored) -> Fitted:
    """Fit the effects' numbers and the runs' starts; the file stays as it is."""
    bench = Bench(data)
    base = bench.first(shape.with_effects())
    bench.weigh(np.minimum(bench.density(base.fit), GOOD))
    problem = bench.problem(shape)
    held = np.zeros(problem.size)
    held[: shape.size] = HELD**-2
    for place in shape.places:
        held[place.columns] = 0.0
    prior = Prior(problem.prior.mean, problem.prior.precision + np.diag(held))
    problem = replace(problem, prior=prior)
    start = prior.mean.copy()
    start[: shape.size] = shape.start()
    return Fitted(problem, settle(problem, start, AT_EACH))
