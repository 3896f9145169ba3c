"""Sensors that lag: a reading y follows the temperature T of its part, lag y' = T - y.

Within a bin T is taken for a straight line, of slope m. Over d seconds y - T then goes from e to
e a - lag m (1 - a) with a = exp(-d / lag), exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import BoolArray, FloatArray
from gen.identification.network.fitting.inputs import Inputs

SHORT_S = 1e-3
"""Below this a reading is what was a lag ago, to first order; so a search may pass through 0."""


@dataclass(frozen=True, eq=False)
class Lagged:
    """One sensor along all runs.

    Attributes
    ----------
    inputs
        The bins.
    sensor
        Which.
    lag
        In each bin, shape (N,), s.
    """

    inputs: Inputs
    sensor: int
    lag: FloatArray

    def behind(self, change: NDArray[Any]) -> NDArray[Any]:
        """Give y - T where readings are, which is linear in the changes of T.

        Parameters
        ----------
        change
            Of T in each bin, shape (N,), K/s; or their derivatives by p parameters, shape (N, p).
        """
        return self._at_readings(self._before(change), change)

    def by_lag(self, change: FloatArray) -> FloatArray:
        """Give the derivative of y - T by the lag, shape (N,), K/s; the argument is that of :meth:`behind`."""
        known = self._before(change)
        longer = np.where(self._usual, self.lag, 1.0)

        def own(kept: FloatArray, span: FloatArray) -> FloatArray:
            return np.asarray((known + self.lag * change) * kept * span / longer**2 - change * (1.0 - kept))

        whole, read = self.inputs.width, self._read_after
        kept = self._kept(whole)
        return np.asarray(self._kept(read) * self._carried(kept, own(kept, whole)) + own(self._kept(read), read))

    @cached_property
    def _usual(self) -> BoolArray:
        return np.asarray(self.lag > SHORT_S)

    @property
    def _read_after(self) -> FloatArray:
        """From a bin's beginning to its reading, s."""
        return np.asarray(self.inputs.share[:, self.sensor] * self.inputs.width)

    def _kept(self, span: FloatArray) -> FloatArray:
        """What is left of y - T after a while."""
        return np.where(self._usual, np.exp(-span / np.where(self._usual, self.lag, 1.0)), 0.0)

    def _at_readings(self, known: NDArray[Any], change: NDArray[Any]) -> NDArray[Any]:
        kept, lag = self._kept(self._read_after), self.lag
        if change.ndim > 1:
            kept, lag = kept[:, None], lag[:, None]
        return np.asarray(kept * known - lag * (1.0 - kept) * change)

    def _before(self, change: NDArray[Any]) -> NDArray[Any]:
        """Give y - T where bins begin."""
        kept, lag = self._kept(self.inputs.width), self.lag
        added = -lag * (1.0 - kept)
        return self._carried(kept, (added[:, None] if change.ndim > 1 else added) * change)

    def _carried(self, kept: FloatArray, added: NDArray[Any]) -> NDArray[Any]:
        """Run e -> kept e + added along all runs side by side, from 0; e where bins begin."""
        made = np.zeros_like(added)
        factor = kept[:, None] if added.ndim > 1 else kept
        for (last, _), (low, high) in pairwise(pairwise(self.inputs.first.tolist())):
            here = slice(last, last + high - low)
            made[low:high] = factor[here] * made[here] + added[here]
        return made
