"""Numbers of the C++ and what is computed with them: every one is held against its type.

On the AVR an ``int`` has 16 bits: a product or a sum of two numbers of at most 16 bits has to fit 16 of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.network.forms import Form, Space
from gen.certificate.refuted import Refuted

#: Below this whole numbers are exact in float64.
_EXACT = 2.0**53
#: float32's largest number.
_LARGEST = float(np.finfo(np.float32).max)


@dataclass(frozen=True, eq=False)
class Number:
    """A number of the C++.

    Attributes
    ----------
    kind
        Its type.
    form
        What it is.
    natural
        Whether it is known not to be negative, whatever the form says: factors may come close to 0.
    """

    kind: str
    form: Form
    natural: bool = False

    @property
    def at_least_0(self) -> bool:
        """Whether it is known not to be negative."""
        return self.natural or self.kind.startswith("u")

    @property
    def bits(self) -> int:
        """How many it has, of a whole number."""
        return int(self.kind.strip("uint_"))

    @property
    def signed(self) -> bool:
        """Whether it may be negative."""
        return not self.kind.startswith("u")


class Arithmetic:
    """Computes with numbers.

    Parameters
    ----------
    space
        What they are made of.
    """

    def __init__(self, space: Space) -> None:
        self._space = space

    def known(self, value: float | FloatArray, kind: str = "int32_t") -> Number:
        """A number that is known."""
        return Number(kind, self._space.number(value))

    def binary(self, op: str, left: Number, right: Number) -> Number:
        """A sum, a difference, a product or a shift.

        Raises
        ------
        Refuted
            If it is none of these, or may leave its type.
        """
        if op in (">>", "<<") and "float" not in (left.kind, right.kind):
            return self.shifted(op, left, self.whole(right))
        if op not in ("+", "-", "*"):
            raise Refuted(f"an operation that the proof does not know: {op}")
        kind = _common(left, right)
        left, right = self.converted(left, kind), self.converted(right, kind)
        if kind == "float":
            return self._single(op, left.form, right.form)
        natural = op != "-" and left.at_least_0 and right.at_least_0
        return self.fitted(Number(kind, self.exactly(op, left.form, right.form), natural))

    def exactly(self, op: str, left: Form, right: Form) -> Form:
        """A sum, a difference or a product as if nothing were rounded; the same for forms that are known."""
        if left.known and right.known:
            made = _OPERATIONS[op](left.constant, right.constant)
            if np.all(np.abs(made) <= _EXACT):
                return self._space.number(made)
        match op:
            case "+":
                return (left + right).trimmed()
            case "-":
                return (left - right).trimmed()
            case _:
                return left.product(right).trimmed()

    def _single(self, op: str, left: Form, right: Form) -> Number:
        if left.known and right.known:
            made = _OPERATIONS[op](left.constant.astype(np.float32), right.constant.astype(np.float32))
            return self._finite(self._space.number(made.astype(np.float64)))
        return self._rounded(self.exactly(op, left, right))

    def _rounded(self, form: Form) -> Number:
        """Round to nearest float32."""
        return self._finite(form.within(_half_ulp(form.largest)))

    @staticmethod
    def _finite(form: Form) -> Number:
        if not np.all(form.largest < _LARGEST):
            raise Refuted("a number of float32 has no bound")
        return Number("float", form)

    def shifted(self, op: str, value: Number, bits: int) -> Number:
        """A whole number shifted up, or down, which rounds down.

        Raises
        ------
        Refuted
            If it may leave its type, or has fewer bits than that.
        """
        value = self.converted(value, _promoted(value))
        if not 0 <= bits < value.bits:
            raise Refuted(f"a shift by {bits} bits")
        if op == "<<":
            return self.fitted(Number(value.kind, value.form.times(2.0**bits), value.at_least_0))
        scaled = value.form.times(2.0**-bits)
        if value.form.known:
            return Number(value.kind, self._space.number(np.floor(scaled.constant)))
        lost = 1.0 - 2.0**-bits  # rounded down
        made = (scaled + self._space.number(-lost / 2.0)).within(lost / 2.0) if bits else scaled
        return Number(value.kind, made, value.at_least_0)

    def converted(self, value: Any, kind: str | None) -> Any:  # noqa: ANN401
        """The same number in another type; what is no number, or has any type in a template, stays as it is.

        Raises
        ------
        Refuted
            If it does not fit, or is a float32 as a whole number.
        """
        if not isinstance(value, Number) or kind is None or value.kind == kind:
            return value
        if kind == "float":
            if value.form.known and np.all(np.abs(value.form.constant) <= 2.0**24):
                return Number(kind, value.form)
            return self._rounded(value.form)
        if value.kind == "float":
            raise Refuted("a float32 as a whole number")
        return self.fitted(Number(kind, value.form, value.at_least_0))

    @staticmethod
    def fitted(value: Number) -> Number:
        """The number itself, within its type.

        Raises
        ------
        Refuted
            If it may leave it.
        """
        low, high = value.form.ends
        natural = value.natural or bool(np.all(low >= 0.0))
        low = np.maximum(low, 0.0) if natural else low
        room = value.bits - (1 if value.signed else 0)
        least = -(2.0**room) if value.signed else 0.0
        if not (np.all(low >= least) and np.all(high <= 2.0**room - (1.0 if room < 53 else 2.0**11))):
            raise Refuted(f"a number of {value.kind} can reach {low.min():.6g} .. {high.max():.6g}")
        return Number(value.kind, value.form, natural)

    @staticmethod
    def whole(value: Any) -> int:  # noqa: ANN401
        """A whole number that is known, and the same at every |PWM|.

        Raises
        ------
        Refuted
            If it is none.
        """
        if isinstance(value, Number) and value.kind != "float" and value.form.known:
            found = value.form.constant
            if np.all(found == found[0]):
                return int(found[0])
        raise Refuted("a count, a place or a shift that is no constant")


_OPERATIONS: dict[str, Callable[[FloatArray, FloatArray], FloatArray]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
}


def _promoted(value: Number) -> str:
    """A small number's type where it is computed with."""
    if value.bits >= 32:
        return value.kind
    return "uint16_t" if value.kind == "uint16_t" else "int16_t"


def _common(left: Number, right: Number) -> str:
    """The type in which two numbers are computed with; a change of sign is refuted where it would change the number."""
    if "float" in (left.kind, right.kind):
        return "float"
    kinds = {_promoted(left), _promoted(right)}
    for kind in ("uint64_t", "int64_t", "uint32_t", "int32_t", "uint16_t"):
        if kind in kinds:
            return kind
    return "int16_t"


def _half_ulp(largest: FloatArray) -> FloatArray:
    """Half the distance of float32 numbers of at most this magnitude."""
    found: FloatArray = np.maximum(np.ldexp(1.0, np.frexp(largest)[1] - 25), 2.0**-150)
    return np.asarray(np.where(largest == 0.0, 0.0, found), dtype=np.float64)
