"""Columns that grow while a file is read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray

_FIRST = 1 << 14


class Columns:
    """One array for each column; memory that was not written yet costs nothing.

    Parameters
    ----------
    names
        Of the columns.
    compact_after
        From this many rows on all but the time are kept in single precision, and PWM in 16 bits: 1e-6 K of a
        temperature is far below any sensor's step. None: never.
    """

    def __init__(self, names: Sequence[str], compact_after: int | None) -> None:
        self.rows = 0
        self._names = list(names)
        self._compact_after = compact_after
        self._arrays: list[NDArray[Any]] = [np.empty(_FIRST) for _ in names]

    def append(self, values: FloatArray) -> None:
        """Add rows, shape (n, columns)."""
        rows = self.rows + len(values)
        if self._compact_after is not None and rows > self._compact_after:
            self._compact()
        for i, array in enumerate(self._arrays):
            if rows > array.size:
                self._arrays[i] = self._copied(i, max(2 * array.size, rows), array.dtype)
            self._arrays[i][self.rows : rows] = values[:, i]
        self.rows = rows

    def _compact(self) -> None:
        kinds: dict[str, np.dtype[Any]] = {"time_s": np.dtype(np.float64), "pwm": np.dtype(np.int16)}
        for i, name in enumerate(self._names):
            kind = kinds.get(name, np.dtype(np.float32))
            if self._arrays[i].dtype != kind:
                self._arrays[i] = self._copied(i, self._arrays[i].size, kind)

    def _copied(self, i: int, size: int, kind: np.dtype[Any]) -> NDArray[Any]:
        made = np.empty(size, dtype=kind)
        made[: self.rows] = self._arrays[i][: self.rows]
        return made

    def finished(self) -> dict[str, NDArray[Any]]:
        """The columns by name."""
        return {name: array[: self.rows] for name, array in zip(self._names, self._arrays, strict=True)}
