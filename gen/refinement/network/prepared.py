"""Later runs of a network, read and condensed: what refinement and planning begin with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from gen.coefficients import Coefficients
from gen.refinement.admission import healthy
from gen.refinement.condense import read_measured
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data, make_data
from gen.refinement.network.mistaken import check_mistakes
from gen.runs import Run


def prepared(
    coefficients: Coefficients, paths: Sequence[Path], progress: Callable[[str], None]
) -> tuple[list[tuple[str, Run]], Data, Anchored, list[str]]:
    """Read the runs of a healthy motor and condense them.

    Parameters
    ----------
    coefficients
        A file with a network.
    paths
        Run files.
    progress
        Called with what is being done.

    Returns
    -------
    runs, data, shape, warnings
        The runs by name; their bins; the file with everything in it free; sentences for the user.

    Raises
    ------
    InputError
        For files that are no runs, or where all of them name a fault; for a run that a mistake in logging explains.
    """
    network = coefficients.model.network
    assert network is not None
    runs = []
    for path in paths:
        progress(f"reading {path}")
        runs.append((str(path), read_measured(coefficients, path)))
    runs, warnings = healthy(runs)
    warnings += [f"{name}: {run.left_out}" for name, run in runs if run.left_out]
    check_mistakes(coefficients, runs)
    data = make_data(coefficients, runs)
    return runs, data, Anchored.of(network, coefficients.document.input.full_scale, data.columns), warnings
