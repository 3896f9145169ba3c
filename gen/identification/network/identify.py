"""Identify one thermal network from all runs together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.data import NetworkData
from gen.identification.network.evidence import clearly_better, likely, plainly_warm
from gen.identification.network.fitting.as_found import usual
from gen.identification.network.fitting.driven import POWER
from gen.identification.network.fitting.inputs import Inputs, inputs_of
from gen.identification.network.fitting.past import past_weights
from gen.identification.network.fitting.priors import Prior, prior_of
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.rooms import level_of, places_of, unsure_K
from gen.identification.network.fitting.scale import Scale, scale_of
from gen.identification.network.fitting.structure import Structure
from gen.identification.network.fitting.weights import weights
from gen.identification.network.hidden_nodes import MOST_HIDDEN, SLACK, Candidate, Tried, bending, noise_of, stiff
from gen.identification.network.left_out import LeftOut, each_alone, folds_of, left_out, second_half
from gen.identification.network.prune import held_to_tables, pruned
from gen.identification.network.search import Found, in_still_air, tightened, with_warmth
from gen.identification.network.starts import taken_over
from gen.identification.network.telling.uncertainty import spread_of
from gen.identification.network.used import as_used

AT_LAST = 8
"""Linearisations on the fine bins."""
AT_ONCE = 14
"""The same on the coarse ones, in other rooms."""
WARM_AT_ONE_LEVEL = "runs begin at one level as if they were cold, but what they do says that their room is another"


@dataclass(frozen=True, eq=False)
class NetworkFound:
    """What was identified.

    Attributes
    ----------
    data
        The runs.
    found
        The network, on the fine bins.
    judged
        Errors on what was left out, on the coarse bins; `inputs` are those.
    inputs
        The coarse bins.
    candidates
        What else was tried.
    simpler
        The same, on the coarse bins, before each thing that goes with temperature came in (growing heat, then natural
        convection); none where nothing does.
    later
        Errors on the second half of the only run, from a fit to its first; None where there are more runs.
    """

    data: NetworkData
    found: Found
    judged: LeftOut
    inputs: Inputs
    candidates: tuple[Candidate, ...]
    simpler: tuple[Found, ...] = ()
    later: LeftOut | None = None

    @cached_property
    def residual(self) -> FloatArray:
        """Reading minus what the file gives (see `used`) in each fine bin, shape (N, S), K; 0 where none was read."""
        return as_used(self.found, self.data.ambient_fixed).residual


def identify_network(
    data: NetworkData, progress: Callable[[str], None], most_hidden: int = MOST_HIDDEN
) -> NetworkFound:
    """Identify the network.

    Parameters
    ----------
    data
        The runs.
    progress
        Told what is being done.
    most_hidden
        Most hidden nodes to try.
    """
    inputs = inputs_of(data.coarse)
    scale = scale_of(inputs)
    hardly = stiff(data, inputs, scale, most_hidden, progress)
    let_bend = bending(data, inputs, scale, hardly, progress)
    best = _pruned(data, hardly if clearly_better(hardly.found, let_bend.found) else let_bend, scale, progress)
    if data.taken_for_cold and not _began_cold(data, best.found, scale):
        progress("runs that begin warm, all at one level")
        doubted = replace(data.in_any_room(), warnings=(*data.warnings, WARM_AT_ONE_LEVEL))
        return identify_network(doubted, progress, most_hidden)
    *simpler, warmest = _by_temperature(data, best.found, scale, progress)
    judged = left_out(warmest, folds_of(inputs)) if simpler else best.judged
    later = _later(warmest)
    progress("last fit")
    last = _polished(data, warmest, scale)
    return NetworkFound(_with_room(data, last), last, judged, inputs, best.candidates, tuple(simpler), later)


def simplified(result: NetworkFound, why: str) -> NetworkFound:
    """Give the same without what came in last of what goes with temperature, and the reason as a warning."""
    *simpler, found = result.simpler
    convection = result.found.structure.natural > found.structure.natural
    said = "natural convection is left out" if convection else "that heat grows with temperature is left out"
    data = replace(result.data, warnings=(*result.data.warnings, f"{said}, {why}"))
    judged = left_out(found, folds_of(result.inputs))
    last = _polished(data, found, scale_of(result.inputs))
    return replace(result, data=data, found=last, judged=judged, simpler=tuple(simpler), later=_later(found))


def _later(found: Found) -> LeftOut | None:
    half = second_half(found.problem.inputs)
    return None if half is None else left_out(found, [half])


def _by_temperature(
    data: NetworkData, found: Found, scale: Scale, progress: Callable[[str], None]
) -> tuple[Found, ...]:
    """Let heats grow with temperature, then natural convection be, where the runs do not speak against it.

    Returns
    -------
    tuple
        The network without, and after each that was taken.
    """
    made = [found]
    if data.driven != POWER:
        # A power is what heats, however warm it is.
        progress("heat that grows with temperature")
        room = round(float(np.median([run.ambient[0] for run in data.coarse])))
        growing = with_warmth(made[-1], float(room), scale)
        if likely(growing, made[-1]):
            made.append(growing)
    if data.ambient_measured:
        # Where nobody measured the room, it is not known what the difference to it is.
        progress("natural convection")
        natural = in_still_air(made[-1], data.widest_K, scale)
        if likely(natural, made[-1]):
            made.append(natural)
    return tuple(made)


@dataclass(frozen=True, eq=False)
class _Best:
    """What was chosen.

    Attributes
    ----------
    found, judged
        The network, and its errors on what was left out.
    candidates
        What else was tried.
    """

    found: Found
    judged: LeftOut
    candidates: tuple[Candidate, ...]


def _pruned(data: NetworkData, tried: Tried, scale: Scale, progress: Callable[[str], None]) -> _Best:
    """Take out the paths and heats that the chosen network does not need."""
    progress("paths")
    inputs = tried.found.problem.inputs
    folds, slack = folds_of(inputs), SLACK * noise_of(data.coarse)
    judged = left_out(tried.found, folds) if each_alone(inputs) else tried.judged[tried.chosen]
    found, judged = pruned(tried.found, judged, folds, scale, slack)
    return _Best(found, judged, tried.candidates)


def _began_cold(data: NetworkData, found: Found, scale: Scale) -> bool:
    """Whether runs that begin at one level do not plainly say that their room is another."""
    inputs = inputs_of(data.in_any_room().coarse)
    problem = Problem(found.structure, inputs, prior_of(found.structure, inputs, scale))
    return not plainly_warm(tightened(problem, found.vector, found.density, AT_ONCE), found)


def _polished(data: NetworkData, found: Found, scale: Scale) -> Found:
    """The same network on the fine bins."""
    inputs, structure = inputs_of(data.fine), held_to_tables(found)
    problem = Problem(structure, inputs, prior_of(structure, inputs, scale))
    start = taken_over(problem, found.problem, found.vector)
    last = tightened(problem, start, found.density, AT_LAST, rounds=2)
    if not found.structure.factors.size:
        return last
    others = [_with_usual_starts(last), *_with_likely_starts(last, scale)]
    return min(others, key=lambda one: _cost_from_there(one, last.density))


def _with_likely_starts(found: Found, scale: Scale) -> list[Found]:
    """Fit twice more, hidden nodes starting where the network as it was found lets expect (see `past`)."""
    for _ in range(2):
        inputs = found.problem.inputs
        shares = past_weights(found.structure, found.vector, inputs)
        if shares is None:
            return []
        structure = replace(found.structure, start=tuple(tuple(row) for row in shares.tolist()))
        problem = Problem(structure, inputs, prior_of(structure, inputs, scale))
        start = taken_over(problem, found.problem, found.vector)
        if not found.structure.start:
            _of_hidden(problem, start)[...] = 0.0
        found = tightened(problem, start, found.density, AT_LAST, rounds=2)
    return [found]


def _cost_from_there(found: Found, density: FloatArray) -> float:
    """What is left, weighed, where hidden nodes begin no other than the file will let them."""
    problem = found.problem.weighed(weights(found.problem.inputs, density))
    vector = found.vector.copy()
    _of_hidden(problem, vector)[...] = 0.0
    return problem.evaluate(vector).cost


def _of_hidden(problem: Problem[Structure], vector: FloatArray) -> FloatArray:
    """What hidden nodes begin at beside where they are let begin, by run, shape (R, h): a view of the parameters."""
    return problem.per_run(vector)[:, problem.structure.sensors : problem.structure.nodes]


def _with_usual_starts(found: Found) -> Found:
    """Fit once more, the factors of hidden nodes at the start near what the runs show of them (see `as_found`)."""
    shared, prior = usual(found.problem, found.vector, found.fit.evaluated), found.problem.prior
    mean, precision, places = prior.mean.copy(), prior.precision.copy(), found.structure.factors
    mean[places], precision[places, places] = shared.log, shared.deviation**-2
    problem = replace(found.problem, prior=Prior(mean, precision))
    return tightened(problem, found.vector, found.density, AT_LAST, rounds=2)


def _with_room(data: NetworkData, found: Found) -> NetworkData:
    """The same data, with the level of a room that nothing said as it was found."""
    problem = found.problem
    unsure = unsure_K(problem.inputs)
    if unsure == 0.0 or data.ambient_fixed is None:
        return data
    places = places_of(problem.inputs, problem.structure.size, problem.structure.nodes)
    level, deviation = level_of(problem.prior.precision, places, unsure, found.vector, spread_of(found).covariance)
    return replace(data, ambient_fixed=data.ambient_fixed + level, ambient_unsure_K=deviation)


def curves(result: NetworkFound) -> dict[str, tuple[FloatArray, dict[str, FloatArray]]]:
    """Give the measured and modelled readings of each run.

    Returns
    -------
    dict
        By run: middles of the bins, shape (K,), s; and columns ``<part>_degC`` and ``<part>_model_degC``, shape (K,),
        degC, NaN where nothing was read.
    """
    inputs = result.found.problem.inputs
    made = {}
    for run, row in zip(inputs.runs, inputs.rows, strict=True):
        read = inputs.covered[row] > 0.0
        measured = np.where(read, inputs.target[row], np.nan)
        modelled = measured - np.where(read, result.residual[row], np.nan)
        columns = {}
        for s, name in enumerate(result.data.names):
            columns[f"{name}_degC"] = measured[:, s]
            columns[f"{name}_model_degC"] = modelled[:, s]
        made[run.name] = (0.5 * (run.edges[1:] + run.edges[:-1]), columns)
    return made
