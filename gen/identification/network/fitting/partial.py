"""Derivatives of conductances and heats by the parameters that they depend on, without those that are zero."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray, IntArray
from gen.compiled import compiled


@dataclass(frozen=True, eq=False)
class Partial:
    """Derivatives that are not zero: each of one path's conductance, or of one node's heat, by one parameter.

    Attributes
    ----------
    of
        The path or node, shape (F,).
    by
        Place of the parameter among those that all runs share, shape (F,).
    value
        At each distinct input, shape (L, F).
    """

    of: IntArray
    by: IntArray
    value: FloatArray

    def add_to(self, made: NDArray[Any], unit: NDArray[Any], level: IntArray | None = None) -> None:
        """Add what each parameter does: its derivatives times what a unit of each path or node does.

        Parameters
        ----------
        made
            Where each parameter has a column, shape (N, n, p).
        unit
            Of each path or node, shape (N, n, paths or nodes).
        level
            Which distinct input holds, shape (N,); None where N is their number.
        """
        if self.by.size == 0:
            return
        at = np.arange(len(made)) if level is None else level
        _spread(self.of, self.by, self.value.astype(unit.dtype), at, unit, made)


@compiled
def _spread(
    of: IntArray, by: IntArray, value: NDArray[Any], level: IntArray, unit: NDArray[Any], made: NDArray[Any]
) -> None:
    """Add what each parameter does: its derivatives times what a unit of each path or node does.

    Parameters
    ----------
    of, by, value
        See `Partial`.
    level
        Shape (N,).
    unit
        Shape (N, n, paths or nodes).
    made
        Shape (N, n, p).
    """
    for row in range(level.size):
        at = level[row]
        for i in range(unit.shape[1]):
            for f in range(of.size):
                made[row, i, by[f]] += value[at, f] * unit[row, i, of[f]]
