"""Functions of words and byte products whose text is known (:mod:`gen.certificate.network.words`), and what they do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.network.arithmetic import Arithmetic, Number
from gen.certificate.network.forms import Space
from gen.certificate.network.memory import Cell, Pointer
from gen.certificate.network.source import Unit
from gen.certificate.network.words import check_text
from gen.certificate.refuted import Refuted


class KnownTexts:
    """What they do, on forms.

    Parameters
    ----------
    unit
        Whose functions.
    space
        What numbers are made of.
    call
        Runs any other function of the unit.
    """

    def __init__(self, unit: Unit, space: Space, call: Callable[..., Any]) -> None:
        self._unit, self._space, self._call = unit, space, call
        self._do = Arithmetic(space)

    def of(self, name: str, arguments: Sequence[Any]) -> Callable[..., Any] | None:
        """What a function of that name does with such arguments; None for one whose text is not known.

        Raises
        ------
        Refuted
            If it has another text than that.
        """
        cell = arguments[0].cells[arguments[0].at] if arguments and isinstance(arguments[0], Pointer) else None
        of_words: dict[str, Callable[..., Any]] = {"add": self._added, "take_up": self._taken_up}
        of_numbers: dict[str, Callable[..., Any]] = {"product": self._product, "scaled": self._scaled}
        known = of_words if isinstance(cell, Cell) else of_numbers
        base = name.removeprefix(f"{self._unit.model}_")
        if base not in known or name == base:
            return None
        check_text(self._unit.model, base, self._unit.texts.get(name, []))
        return known[base]

    def _added(self, where: Pointer, value: Number, shift: Number) -> None:
        """The addition of a float32 to a word, rounded towards zero."""
        cell = where.cells[where.at]
        if value.kind != "float":
            raise Refuted("an addition that the proof does not know")
        scaled = value.form.times(2.0 ** (cell.low_bits - self._do.whole(shift)))
        self._raise(cell, Number("int64_t", scaled.within(1.0)))

    def _taken_up(self, where: Pointer, value: Number, bits: Number) -> None:
        """The addition of a whole number, shifted as far as `NAME_shifted` does it."""
        shifted = self._call(f"{self._unit.model}_shifted", value, bits)
        self._raise(where.cells[where.at], self._do.converted(shifted, "int64_t"))

    def _raise(self, cell: Cell, value: Number) -> None:
        if cell.form is None:
            raise Refuted("a word is not written")
        total = cell.form + self._do.fitted(value).form
        if not np.all(total.largest < 2.0 ** (31 + cell.low_bits) - 1.0):
            raise Refuted("a state's word may overflow")
        cell.form = total

    def _product(self, d: Number, a: Number, least: Number, cut: Number | None = None) -> Number:
        """A product without its lightest byte products, d in two's complement.

        Those that are left out make up everything below what is shifted away, so that the shift rounds nothing.
        """
        if d.kind == "float" or a.kind == "float":
            raise Refuted("a product that the proof does not know")
        d, a = self._do.converted(d, "int64_t"), self._do.converted(a, "uint32_t")
        columns, cuts = self._do.whole(least), self._do.whole(cut) != 0 if cut is not None else False
        if not 0 <= columns < 4:
            raise Refuted(f"a product without {columns} columns")
        bytes_of = [np.floor(a.form.constant / 2.0 ** (8 * j)) % 256.0 if a.form.known else 255.0 for j in range(4)]
        most: float | FloatArray = 0.0
        for i in range(4):
            for j in range(4):
                if i + j < columns:
                    most = most + 255.0 * bytes_of[j] * 2.0 ** (8 * (i + j))
                elif cuts and i + j == columns:
                    most = most + 255.0 * 2.0 ** (8 * (i + j))
        whole = self._do.fitted(Number("int64_t", self._do.exactly("*", d.form, a.form)))
        lost = self._space.number(-np.asarray(most) / 2.0).within(np.asarray(most) / 2.0)
        natural = d.at_least_0 and a.at_least_0  # what is left out is part of a product that is not negative
        made = self._do.fitted(Number("int64_t", whole.form + lost, natural))
        return Number("int64_t", made.form.times(2.0 ** (-8 * (columns + int(cuts)))), natural)

    def _scaled(self, word: Number, factor: Number) -> Number:
        """2^-30 of the product of a word with a factor: 32 bits that a signed number has on the way, unsigned again."""
        model = self._unit.model
        if self._unit.kinds.get(f"{model}_Sum") != "int64_t":
            raise Refuted("a sum has other than 64 bits")
        for name in ("sum", "plus", "down"):
            check_text(model, name, self._unit.texts.get(f"{model}_{name}", []))
        product = self._product(self._do.converted(factor, "int32_t"), word, self._do.known(2.0, "uint8_t"))
        return self._do.fitted(Number("uint32_t", self._do.shifted(">>", product, 14).form, product.at_least_0))
