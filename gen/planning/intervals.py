"""95 % intervals of a hypothesis's numbers, before a run and after it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.model.network_parts import AMBIENT
from gen.planning.hypotheses import Hypothesis

WIDTH = 1.96


@dataclass(frozen=True)
class Interval:
    """Of one number.

    Attributes
    ----------
    what
        Which, its unit in its name; a share (of what the file has) has none.
    value
        Where it is now.
    before, after
        Its ends now, and when the run is done and finds what it is expected to.
    """

    what: str
    value: float
    before: tuple[float, float]
    after: tuple[float, float]

    def summary(self) -> dict[str, Any]:
        """The JSON summary."""
        return asdict(self)


def intervals(hypothesis: Hypothesis, before: FloatArray, after: FloatArray) -> tuple[Interval, ...]:
    """Give the intervals of the effects' numbers, or of the file's where there is no effect.

    Parameters
    ----------
    hypothesis
        Whose.
    before, after
        Standard deviations, shape (size,) each.
    """
    shape, shared = hypothesis.shape, hypothesis.shared
    made = []
    for effect, place in zip(shape.effects, shape.places, strict=True):
        for number, at in zip(effect.numbers, place.columns.tolist(), strict=True):
            ends = []
            for deviation in (before[at], after[at]):
                low, high = (number.value(float(shared[at] + side * WIDTH * deviation)) for side in (-1.0, 1.0))
                ends.append((max(low, number.low), min(high, number.high)))
            made.append(Interval(f"{effect.name} {number.name}", number.value(float(shared[at])), ends[0], ends[1]))
    return tuple(made) if made else _of_the_file(hypothesis, before, after)


def _of_the_file(hypothesis: Hypothesis, before: FloatArray, after: FloatArray) -> tuple[Interval, ...]:
    """Of capacities, paths and heats, each as a factor on what the file has."""
    shape, shared = hypothesis.shape, hypothesis.shared
    start = shape.start()
    names = (*shape.names[: shape.base_nodes], AMBIENT)
    paths, heats = shape.levels_at
    named = [(f"capacity of {names[i]}", i) for i in range(shape.base_nodes)]
    named += [(f"path {names[i]} - {names[j]}", at) for (i, j), at in zip(shape.base_paths, paths, strict=True)]
    named += [(f"heat of {names[node]}", at) for node, at in zip(shape.base_heats, heats, strict=True)]
    made = []
    for what, at in named:
        away = float(shared[at] - start[at])
        ends = [
            (float(np.exp(away - WIDTH * one[at])), float(np.exp(away + WIDTH * one[at]))) for one in (before, after)
        ]
        made.append(Interval(f"factor on the {what}", float(np.exp(away)), ends[0], ends[1]))
    return tuple(made)
