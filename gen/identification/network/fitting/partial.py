"""Derivatives of conductances and heats by the parameters that they depend on, without those that are zero."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.identification.network.fitting.bins import FloatArray, IntArray


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
        value = self.value.astype(unit.dtype)
        each = np.take(unit, self.of, axis=-1)
        each *= (value if level is None else value[level])[:, None, :]
        # One parameter may act in several places; neighbours are added at once.
        begins = np.flatnonzero(np.diff(self.by, prepend=-2) != 1).tolist()
        for begin, end in pairwise([*begins, self.by.size]):
            first = int(self.by[begin])
            made[..., first : first + end - begin] += each[..., begin:end]
