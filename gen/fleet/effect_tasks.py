"""Tasks of `gen fleet refine`: one motor's newer runs against its network with effects on it.

An effect is known by its name, what it acts on and what it acts by; the same one is put on each motor's own network.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from gen.coefficients import Coefficients, parse, with_network
from gen.coefficients.messages import building
from gen.errors import CheckFailed
from gen.fleet.models import model_path
from gen.fleet.motor_data import usable
from gen.fleet.patterns import residual_of
from gen.fleet.pooling import FloatArray
from gen.fleet.store import Kept, Store
from gen.fleet.work import Arrays
from gen.identification.network.fit import settle
from gen.identification.network.priors import Prior
from gen.identification.sources import Source
from gen.model.network import Network
from gen.refinement.condense import measured_in
from gen.refinement.network import excess
from gen.refinement.network.anchored import Anchored
from gen.refinement.network.columns import Columns
from gen.refinement.network.data import Data, make_data
from gen.refinement.network.effects import NetworkEffect, Offered, candidates
from gen.refinement.network.fit import GOOD, Bench, Fitted
from gen.refinement.network.judged import Judged, judged
from gen.refinement.network.trace import PRICE, leaves_some
from gen.refinement.network.writer import NetworkWriter

Key = dict[str, Any]
"""An effect: `what` it is, `where`, and what it `acts_by`; and whether a coefficient file can hold it (`held`)."""
HELD = 1e-6
"""Standard deviation of what a file says, while an effect on top of it is measured."""
AT_EACH = 10
"""Linearisations."""


def key_of(effect: NetworkEffect) -> Key:
    """Say which effect it is, whatever the motor."""
    return {
        "what": effect.name,
        "where": effect.component,
        "acts_by": dict(sorted(effect.acts_by.items())),
        "held": effect.held_by_the_file,
    }


def said(key: Key) -> str:
    """Name an effect."""
    by = ", ".join(f"{name} {value}" for name, value in key["acts_by"].items())
    return f"{key['what']} at {key['where']}" + (f" ({by})" if by else "")


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
        shape = self.now.fitted.shape
        fits = [
            self.bench.fit(shape.with_effects(*shape.effects, one), self.now.fitted)
            for one in _variants(self.every, key)
        ]
        best = min(fits, key=lambda fitted: fitted.fit.cost)
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
        gains[name] = max(gain - PRICE * len(effect.numbers), gains.get(name, -np.inf))
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
    others = np.setdiff1d(np.arange(problem.size), columns)
    gain = np.linalg.solve(matrix[np.ix_(others, others)], matrix[np.ix_(others, columns)])
    told = matrix[np.ix_(columns, columns)] - matrix[np.ix_(columns, others)] @ gain
    told = 0.5 * (told + told.T)
    vector = told @ (fitted.vector[columns] - mean) + right[columns] - gain.T @ right[others]
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


def with_means(text: str, found: Sequence[Key], mean: FloatArray, offered: Offered) -> str:
    """Give the text of a file with effects, their numbers the fleet's.

    Parameters
    ----------
    text
        The coefficient file.
    found
        The effects; those that no file can hold are passed over.
    mean
        Their numbers, in standard deviations from their priors' means.
    offered
        What the fleet's runs have.

    Raises
    ------
    CheckFailed
        Where one of them cannot act on this network.
    InputError
        When the file with them is none that can be built.
    """
    coefficients = parse(text.encode())
    shape = _bare(coefficients, Columns(tuple(offered.ranges), excess.count(_network(coefficients))))
    every = candidates(shape.motor(), offered)
    effects = [_variants(every, key)[0] for key in found]
    document, first = coefficients.document, 0
    assert document.network is not None
    writer = NetworkWriter(document.network, document.input.full_scale, offered.ranges, document.sample_time_s)
    with building():
        for effect in effects:
            own = mean[first : first + len(effect.numbers)]
            first += len(effect.numbers)
            numbers = zip(effect.numbers, own.tolist(), strict=True)
            effect.write(writer, [number.value(number.mean + number.deviation * z) for number, z in numbers])
        named = ", ".join(said(key) for key in found if key["held"])
        made = with_network(text, writer.entry, f"refined with its fleet: {named}")
    parse(made.encode())
    return made


def together(each: Sequence[Offered]) -> Offered:
    """Give what several motors' runs have: channels that all of them have, in the widest range."""
    names = [name for name in each[0].ranges if all(name in one.ranges for one in each)]
    return Offered(
        ranges={n: (min(o.ranges[n][0] for o in each), max(o.ranges[n][1] for o in each)) for n in names},
        typical={name: float(np.median([one.typical[name] for one in each])) for name in names},
        backwards=any(one.backwards for one in each),
        rests=any(one.rests for one in each),
    )


def _read(store: Store, motor: str, runs: list[list[str]]) -> tuple[Coefficients, Data]:
    """A motor's file as it was identified, and its newer runs."""
    coefficients = parse(store.read(model_path(motor)))
    _network(coefficients)
    sources = _sources(store, runs)
    named = [(source.name, measured_in(coefficients, source.run, source.name)) for source in sources]
    return coefficients, make_data(coefficients, named)


def _sources(store: Store, runs: list[list[str]]) -> tuple[Source, ...]:
    sources = usable(store, [Kept(*run) for run in runs]).sources
    if not sources:
        raise CheckFailed("no newer run can be used")
    return sources


def _network(coefficients: Coefficients) -> Network:
    network = coefficients.model.network
    if network is None:
        raise CheckFailed("the model is no network")
    return network


def _bare(coefficients: Coefficients, columns: Columns) -> Anchored:
    return Anchored(_network(coefficients), coefficients.document.input.full_scale, columns)


def _variants(every: Sequence[NetworkEffect], key: Key) -> list[NetworkEffect]:
    """The candidates that are one effect: they differ in where their search begins."""
    found = [effect for effect in every if key_of(effect) == key]
    if not found:
        raise CheckFailed(f"{said(key)} cannot act on this motor, or its runs do not show it")
    return found


def _beside(store: Store, motor: str, runs: list[list[str]], found: Sequence[Key]) -> Beside:
    """Fit the file with what was found, all free that the file leaves open."""
    coefficients, data = _read(store, motor, runs)
    bench = Bench(data)
    shape = _bare(coefficients, data.columns)
    fitted = bench.first(shape)
    every = candidates(shape.motor(), data.offered)
    for key in found:
        effects = fitted.shape.effects
        fits = [bench.fit(shape.with_effects(*effects, one), fitted) for one in _variants(every, key)]
        best = min(fits, key=lambda one: one.fit.cost)
        fitted = bench.tightened(best.shape, best.vector)
    return Beside(bench, judged(data, fitted, bench.left_out(fitted)), tuple(every))


def _with_effects(coefficients: Coefficients, data: Data, found: Sequence[Key], offered: Offered) -> Anchored:
    """The file with effects whose numbers mean the same in the whole fleet."""
    shape = _bare(coefficients, data.columns)
    every = candidates(shape.motor(), offered)
    return shape.with_effects(*(_variants(every, key)[0] for key in found))


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
