"""A run in memory."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
AMBIENT = "ambient_degC"


@dataclass(frozen=True, eq=False)
class Run:
    """One run.

    Parameters
    ----------
    time_s
        Strictly increasing, s, shape (N,), N >= 1.
    pwm
        Integer -255..255, shape (N,); acts from its row's time until the next row's.
    temps
        Measured temperature by component, degC, shape (N,) each; NaN where missing.
    ambient
        Measured ambient, degC, shape (N,), NaN where missing; None without such a column.
    extras
        Further columns by their full name.
    comments
        The comment lines; a line without a colon has an empty value.
    rows_in_file
        Rows of the file that it was read from, more than N when it was thinned; None for a run from elsewhere.
    """

    time_s: FloatArray
    pwm: NDArray[np.int64]
    temps: dict[str, FloatArray] = field(default_factory=dict)
    ambient: FloatArray | None = None
    extras: dict[str, FloatArray] = field(default_factory=dict)
    comments: dict[str, str] = field(default_factory=dict)
    rows_in_file: int | None = None
