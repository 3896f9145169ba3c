"""How many hidden nodes there are: none to three, by the error on what was left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from gen.identification.network.data import NetworkData
from gen.identification.network.evidence import STIFF
from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.bins import Binned
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.structure import full
from gen.identification.network.left_out import (
    LeftOut,
    all_left_out,
    each_alone,
    folds_for_nodes,
    predictions,
    together,
)
from gen.identification.network.search import Found, Search, bent, told
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
class Tried:
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


def stiff(data: NetworkData, inputs: Inputs, scale: Scale, most_hidden: int, progress: Callable[[str], None]) -> Tried:
    """Try hidden nodes with curves that hardly bend, until more of them are not worth it.

    Parameters
    ----------
    data, inputs
        The runs, and their coarse bins.
    scale
        What the parts do alone.
    most_hidden
        Most hidden nodes to try.
    progress
        Told what is being done.
    """
    most_hidden = min(most_hidden, MOST_ALONE) if each_alone(inputs) else most_hidden
    by_nodes, slack = folds_for_nodes(inputs), SLACK * noise_of(data.coarse)
    apart = APART if inputs.warm.any() else 0.0
    searches = [
        Search.of(full(data.names, hidden, len(data.driving), STIFF, apart, data.driven, data.least_s), inputs, scale)
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
    return Tried(tuple(tried), tuple(judged), _choice([one.score_K for one in judged], slack))


def bending(data: NetworkData, inputs: Inputs, scale: Scale, hardly: Tried, progress: Callable[[str], None]) -> Tried:
    """Let curves bend: with as many hidden nodes as without, one fewer, and one more.

    Parameters
    ----------
    data, inputs, scale, progress
        As for `stiff`.
    hardly
        What that gave.
    """
    by_nodes, slack = folds_for_nodes(inputs), SLACK * noise_of(data.coarse)
    some = hardly.all[max(hardly.chosen - 1, 0) : hardly.chosen + 2]
    progress("curves that bend")
    tried = bent(some, BEND, scale)
    progress("curves that bend: left-out error")
    judged = all_left_out(tried, by_nodes)
    return Tried(tuple(tried), tuple(judged), _choice([one.score_K for one in judged], slack))


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
