"""What the rivals' detectors are given of a run: means over 20 s, as the rules on missing heat take them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.runs import Run

FloatArray = NDArray[np.float64]
BLOCK_S = 20.0
FIXED_ROOM_DEGC = 30.0
"""Where a run has no measured room."""


@dataclass(frozen=True)
class Blocks:
    """A run's means over blocks of `BLOCK_S`, n of them.

    Attributes
    ----------
    end_s
        Ends of the blocks, s, shape (n,).
    drive
        |PWM| / 255, shape (n,).
    room_degC
        Shape (n,).
    measured_degC, model_degC
        Shape (n, components).
    """

    end_s: FloatArray
    drive: FloatArray
    room_degC: FloatArray
    measured_degC: FloatArray
    model_degC: FloatArray


def blocks_of(run: Run, model_degC: Mapping[str, FloatArray]) -> Blocks:
    """Condense a run; what is missing takes no part in its block's mean.

    Parameters
    ----------
    run
        What was measured.
    model_degC
        The model's temperatures at the run's rows by component, shape (N,) each.
    """
    index = ((run.time_s - run.time_s[0]) // BLOCK_S).astype(np.int64)
    whole = index[-1]  # the last block may be cut off
    names = list(model_degC)

    def mean(values: FloatArray) -> FloatArray:
        good = np.isfinite(values) & (index < whole)
        total = np.bincount(index[good], values[good], whole)
        return np.asarray(total / np.maximum(np.bincount(index[good], minlength=whole), 1), dtype=np.float64)

    room = np.full(run.time_s.shape, FIXED_ROOM_DEGC) if run.ambient is None else run.ambient
    return Blocks(
        run.time_s[0] + (np.arange(whole) + 1) * BLOCK_S,
        mean(np.abs(run.pwm) / 255.0),
        mean(room),
        np.column_stack([mean(run.temps[name]) for name in names]),
        np.column_stack([mean(model_degC[name]) for name in names]),
    )
