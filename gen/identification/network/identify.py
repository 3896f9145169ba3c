"""Identify one thermal network from all runs together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from gen.identification.network.data import NetworkData
from gen.identification.network.evidence import STIFF, clearly_better, likely
from gen.identification.network.fitting.as_found import usual
from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.bins import Binned, FloatArray
from gen.identification.network.fitting.inputs import Inputs, inputs_of
from gen.identification.network.fitting.priors import Prior, prior_of
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.rooms import level_of, places_of, unsure_K
from gen.identification.network.fitting.scale import Scale, scale_of
from gen.identification.network.fitting.structure import full
from gen.identification.network.left_out import (
    LeftOut,
    all_left_out,
    each_alone,
    folds_for_nodes,
    folds_of,
    left_out,
    predictions,
    together,
)
from gen.identification.network.prune import pruned
from gen.identification.network.search import Found, Search, bent, in_still_air, tightened, told
from gen.identification.network.starts import taken_over
from gen.identification.network.telling.uncertainty import spread_of
from gen.identification.network.used import as_used
from gen.side_by_side import has_help, of_two_kinds, side_by_side

MOST_HIDDEN = 3
MOST_ALONE = 1
"""Hidden nodes at most where each run has a speed of its own: at one speed alone hidden temperatures may be any mixture
of them, and what happens when speed changes, which the mixture decides, is in no run."""
MOST_NODES = 10


APART = 0.1
"""How far hidden nodes may start from where the file lets them, as a share of what parts differ by there."""
BETTER = 1.1
"""Left-out errors within this factor of the best are as good."""
SLACK = 0.1
"""Nor does a difference count that is below this share of a single reading's noise."""
AT_LAST = 8
"""Linearisations on the fine bins."""


@dataclass(frozen=True)
class Candidate:
    """A number of hidden nodes that was tried.

    Attributes
    ----------
    hidden
        How many.
    left_out_K
        Root mean square error on what was left out, K.
    parameters
        Free numbers that all runs share.
    """

    hidden: int
    left_out_K: float
    parameters: int


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
    still
        The same, on the coarse bins, without natural convection and how that was judged; None where there is none.
    """

    data: NetworkData
    found: Found
    judged: LeftOut
    inputs: Inputs
    candidates: tuple[Candidate, ...]
    still: tuple[Found, LeftOut] | None = None

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
    most_hidden = min(most_hidden, MOST_ALONE) if each_alone(inputs) else most_hidden
    stiff = _stiff(data, inputs, scale, most_hidden, progress)
    bending = _bending(data, inputs, scale, stiff, progress)
    best = _pruned(data, stiff if clearly_better(stiff.found, bending.found) else bending, scale, progress)
    still = None
    if data.ambient_measured:
        # Where nobody measured the room, it is not known what the difference to it is.
        progress("natural convection")
        natural = in_still_air(best.found, data.widest_K, scale)
        if likely(natural, best.found):
            still = best.found, best.judged
            best = replace(best, found=natural, judged=left_out(natural, folds_of(inputs)))
    progress("last fit")
    last = _polished(data, best.found, scale)
    return NetworkFound(_with_room(data, last), last, best.judged, inputs, best.candidates, still)


def without_convection(result: NetworkFound, why: str) -> NetworkFound:
    """Give the same without natural convection, and the reason as a warning."""
    assert result.still is not None
    found, judged = result.still
    last = _polished(result.data, found, scale_of(result.inputs))
    data = replace(result.data, warnings=(*result.data.warnings, why))
    return replace(result, data=data, found=last, judged=judged, still=None)


@dataclass(frozen=True, eq=False)
class _Tried:
    """Networks of one kind of curves over speed, with one more hidden node each.

    Attributes
    ----------
    all
        The networks.
    judged
        The errors of each on what was left out.
    chosen
        Which of them is taken.
    """

    all: tuple[Found, ...]
    judged: tuple[LeftOut, ...]
    chosen: int

    @property
    def found(self) -> Found:
        """What is taken."""
        return self.all[self.chosen]

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """All of them."""
        each = zip(self.all, self.judged, strict=True)
        return tuple(Candidate(one.structure.hidden, errors.score_K, one.structure.size) for one, errors in each)


def _stiff(
    data: NetworkData, inputs: Inputs, scale: Scale, most_hidden: int, progress: Callable[[str], None]
) -> _Tried:
    """Try hidden nodes with curves that hardly bend, until more of them are not worth it."""
    by_nodes, slack = folds_for_nodes(inputs), SLACK * noise_of(data.coarse)
    apart = APART if inputs.warm.any() else 0.0
    searches = [
        Search.of(full(data.names, hidden, len(data.driving), STIFF, apart, data.driven), inputs, scale)
        for hidden in range(max(0, min(most_hidden, MOST_NODES - len(data.names))) + 1)
    ]
    tried: list[Found] = []
    judged: list[LeftOut] = []
    fits = side_by_side(searches[0].afresh())
    for hidden, search in enumerate(searches):
        # What the next search will need is begun beside what this one still has to do, where there is help.
        after = searches[hidden + 1 : hidden + 2]
        ahead = after if has_help() else []
        progress(f"{hidden} hidden node(s): fit")
        begun, ended = of_two_kinds(
            [task for one in ahead for task in one.afresh()], [partial(told, partial(search.ended, fits))]
        )
        found = ended[0].of(search.problem)
        tried.append(found)
        progress(f"{hidden} hidden node(s): left-out error")
        fewer, errors = of_two_kinds([partial(one.from_fewer, found) for one in ahead], predictions(found, by_nodes))
        judged.append(together(found, by_nodes, errors))
        if _enough([one.score_K for one in judged], slack):
            break
        for one in after:
            fits = [*(begun or side_by_side(one.afresh())), *(fewer or [one.from_fewer(found)])]
    return _Tried(tuple(tried), tuple(judged), _choice([one.score_K for one in judged], slack))


def _bending(data: NetworkData, inputs: Inputs, scale: Scale, stiff: _Tried, progress: Callable[[str], None]) -> _Tried:
    """Let curves bend: with as many hidden nodes as without, one fewer, and one more."""
    by_nodes, slack = folds_for_nodes(inputs), SLACK * noise_of(data.coarse)
    some = stiff.all[max(stiff.chosen - 1, 0) : stiff.chosen + 2]
    progress("curves that bend")
    tried = bent(some, BEND, scale)
    progress("curves that bend: left-out error")
    judged = all_left_out(tried, by_nodes)
    return _Tried(tuple(tried), tuple(judged), _choice([one.score_K for one in judged], slack))


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


def _pruned(data: NetworkData, tried: _Tried, scale: Scale, progress: Callable[[str], None]) -> _Best:
    """Take out the paths and heats that the chosen network does not need."""
    progress("paths")
    inputs = tried.found.problem.inputs
    folds, slack = folds_of(inputs), SLACK * noise_of(data.coarse)
    judged = left_out(tried.found, folds) if each_alone(inputs) else tried.judged[tried.chosen]
    found, judged = pruned(tried.found, judged, folds, scale, slack)
    return _Best(found, judged, tried.candidates)


def noise_of(runs: Sequence[Binned]) -> float:
    """What the sensors scatter by in all runs together, as a root mean square, K: a node must gain more than that."""
    return float(np.sqrt(np.mean([run.noise_K**2 for run in runs])))


def _enough(scores: Sequence[float], slack: float) -> bool:
    """Whether one more hidden node is not worth a trial: none could be chosen, the last made it worse, or two did."""
    if scores[-1] <= slack:
        return True
    return len(scores) > 2 and (scores[-1] > scores[-2] * BETTER or min(scores[-2:]) > min(scores[:-2]) * BETTER)


def _choice(scores: Sequence[float], slack: float) -> int:
    """The first that is about as good as the best."""
    limit = (BETTER * min(scores)) ** 2 + slack**2
    return next(k for k, score in enumerate(scores) if score**2 <= limit)


def _polished(data: NetworkData, found: Found, scale: Scale) -> Found:
    """The same network on the fine bins."""
    inputs = inputs_of(data.fine)
    problem = Problem(found.structure, inputs, prior_of(found.structure, inputs, scale))
    start = taken_over(problem, found.problem, found.vector)
    last = tightened(problem, start, found.density, AT_LAST, rounds=2)
    return _with_usual_starts(last) if found.structure.factors.size else last


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
