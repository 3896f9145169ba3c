"""What a model errs by on what was left out: as `gen simulate` of its file runs from the run's first readings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.identification.choice.folds import Fold
from gen.identification.logs.data import sound
from gen.reference.simulate import simulate_run
from gen.runs import with_noted_ambient

BLOCKS = 8
"""Each left-out run or stretch is cut into so many of equal time that count alike, however dense their readings are."""


@dataclass(frozen=True)
class Judged:
    """A part in a run, or stretch, that was left out.

    Attributes
    ----------
    run, part
        Which.
    """

    run: str
    part: str


def errors(coefficients: Coefficients, fold: Fold) -> dict[Judged, FloatArray]:
    """Mean square errors of a model on what a fold leaves out.

    Parameters
    ----------
    coefficients
        The model, fitted to the fold's other runs.
    fold
        What was left out. Readings that no part can have shown are no part of it.

    Returns
    -------
    dict
        By run and part that both the model and the run have: mean of the square of (model minus reading) over all
        readings in each block of the run's left-out time, shape (BLOCKS,), K^2; NaN in a block without a reading.

    Raises
    ------
    InputError
        When a run lacks what the model needs.
    """
    return dict(_errors(coefficients, fold))


def _errors(coefficients: Coefficients, fold: Fold) -> Iterator[tuple[Judged, FloatArray]]:
    for source, out in fold.judged:
        run = sound(source, []).run
        if coefficients.model.ambient_fixed is None:
            run = with_noted_ambient(run, source.path)
        known = {name: run.temps[name] for name in coefficients.model.component_names if name in run.temps}
        shown = simulate_run(coefficients, replace(run, temps=known), "exact", "auto", source.path)
        block = _blocks(run.time_s, out)
        for name, read in known.items():
            good = out & np.isfinite(read)
            square = (np.asarray(shown[f"{name}_degC"])[good] - read[good]) ** 2
            number = np.bincount(block[good], minlength=BLOCKS).astype(np.float64)
            total = np.bincount(block[good], square, BLOCKS)
            if good.any():
                yield (
                    Judged(source.path, name),
                    np.where(number > 0.0, total / np.maximum(number, 1.0), np.nan),
                )


def _blocks(time: FloatArray, out: BoolArray) -> IntArray:
    """The block of each row, shape (N,); of rows that were left out it counts."""
    first, last = float(time[out][0]), float(time[out][-1])
    share = (time - first) / max(last - first, 1e-9)
    return np.asarray(np.clip(share * BLOCKS, 0, BLOCKS - 1), dtype=np.int64)
