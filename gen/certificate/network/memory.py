"""The memory of the board, as the machine sees it: arrays and pointers into them, words of states, tables in flash."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.certificate.network.arithmetic import Number
from gen.certificate.network.forms import Form, Space
from gen.certificate.network.source import Table
from gen.certificate.refuted import Refuted


@dataclass
class Cell:
    """A state's word of ``hi`` and ``lo``.

    Attributes
    ----------
    form
        The whole number; None where ``lo`` alone was written.
    low_bits
        Of ``lo``.
    """

    form: Form | None
    low_bits: int


@dataclass(frozen=True)
class Pointer:
    """A place in an array."""

    cells: list[Any]
    at: int


@dataclass(frozen=True)
class Told:
    """A channel's value."""

    channel: int


@dataclass
class Model:
    """The model in RAM: the states' words."""

    T: list[Any]


class Flash(list[Any]):
    """A table, read at the place of each |PWM|."""

    def __init__(self, table: Table, space: Space) -> None:
        super().__init__()
        self._table, self._space = table, space

    def place(self, index: Any) -> Pointer:  # noqa: ANN401
        """What is read there."""
        if not isinstance(index, Number) or index.kind == "float" or not index.form.known:
            raise Refuted("a table's place that is not known")
        places = index.form.constant
        if not (places.min() >= 0 and places.max() < len(self._table.values)):
            raise Refuted("a place outside of its table")
        found = Number(self._table.kind, self._space.number(self._table.values[places.astype(np.int64)]))
        cell = Flash(self._table, self._space)
        cell.append(found)
        return Pointer(cell, 0)
