"""What is left out to compare the two kinds of models: whole runs, or stretches where there is one run only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import BoolArray
from gen.identification.logs.sources import Source

MOST_FOLDS = 3
"""Each costs a fit of both kinds, so a choice costs this many more."""
STRETCHES = MOST_FOLDS + 1
"""One run is cut into so many of equal time. The first always takes part in the fit: a simulation begins with it, and
where nobody measured the room its beginning tells that, too."""

LONGEST_STEP_S = 600.0
"""As which a gap counts, where one run is cut: a stretch without rows could judge nothing."""


@dataclass(frozen=True, eq=False)
class Fold:
    """One fit without some of the data.

    Attributes
    ----------
    fit
        What it is fitted to.
    judged
        Runs that it has to predict from their first rows, and the rows of each that were left out, shape (N,).
    """

    fit: tuple[Source, ...]
    judged: tuple[tuple[Source, BoolArray], ...]


def folds_of(sources: Sequence[Source]) -> list[Fold]:
    """Give what each fold leaves out; no fold where the only run is too short to be cut.

    Parameters
    ----------
    sources
        The runs.
    """
    if len(sources) == 1:
        return _stretches(sources[0])
    # Neighbours in the list are often alike (speeds in order): a fold takes runs from all over it.
    count = min(len(sources), MOST_FOLDS)
    folds = []
    for k in range(count):
        kept = tuple(source for i, source in enumerate(sources) if i % count != k)
        out = tuple((source, np.ones(source.run.time_s.size, dtype=np.bool_)) for source in sources[k::count])
        folds.append(Fold(kept, out))
    return folds


def _stretches(source: Source) -> list[Fold]:
    """Input and room of a stretch stay known; only its readings are left out."""
    run = source.run
    time = np.concatenate([[0.0], np.cumsum(np.minimum(np.diff(run.time_s), LONGEST_STEP_S))])
    if time[-1] <= 0.0:
        return []
    stretch = np.minimum((time / time[-1] * STRETCHES).astype(np.int64), STRETCHES - 1)
    folds = []
    for k in range(1, STRETCHES):
        out = stretch == k
        if not out.any():
            continue
        temps = {name: np.where(out, np.nan, values) for name, values in run.temps.items()}
        folds.append(Fold((replace(source, run=replace(run, temps=temps)),), ((source, out),)))
    return folds
