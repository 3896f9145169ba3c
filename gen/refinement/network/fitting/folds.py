"""What is left out in turn of the later runs: whole runs, or stretches of them where they are few."""

from __future__ import annotations

import numpy as np

from gen.arrays import BoolArray
from gen.refinement.network.fitting.data import Data

FEW = 3
"""Up to so many later runs are cut."""
FOLDS, TURNS = 4, 2
"""Each such run is cut into so many stretches, and each fold leaves out every fourth: two of each run."""
MOST_FOLDS = 5


def folds_of(data: Data) -> list[BoolArray]:
    """Give the bins that each fold leaves out, shape (N,) each; what the file stands for is never left out."""
    inputs = data.inputs
    if data.later > FEW:
        count = min(data.later, MOST_FOLDS)
        return [data.is_later & (inputs.run % count == k) for k in range(count)]
    duration = np.array([run.duration for run in inputs.runs])[inputs.run]
    part = np.minimum(inputs.begins / duration * FOLDS * TURNS, FOLDS * TURNS - 1).astype(np.int64)
    # Runs are cut alike: another beginning for each, so that no fold has the same hours of all.
    return [data.is_later & ((part + inputs.run) % FOLDS == k) for k in range(FOLDS)]


def described(later: int) -> str:
    """Say what is left out."""
    if later > FEW:
        return "whole runs" if later <= MOST_FOLDS else f"whole runs, in {MOST_FOLDS} groups"
    return f"stretches of an eighth of each run, in {FOLDS} groups"
