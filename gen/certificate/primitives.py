"""What the smallest functions of the C++ mean: each has one known text, and a function here that does the same.

48-bit words (fixed point) and 40-bit accumulators (float32) are whole numbers; a state's word is a :class:`Cell`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.certificate.affine import Affine, Space
from gen.certificate.document import LOW_BITS
from gen.certificate.exact import Ratio
from gen.certificate.refuted import Refuted


@dataclass
class Cell:
    """A word of the state, or a variable that holds one: a whole number, of which ``hi`` is read.

    Attributes
    ----------
    value
        The whole number.
    low_bits
        Bits below ``hi``.
    """

    value: Affine
    low_bits: int

    def high(self, space: Space) -> Affine:
        """What is read, rounded down."""
        return space.shifted(self.value, self.low_bits).as_kind("int32_t")

    def put(self, space: Space, value: Affine, what: str) -> None:
        """Replace the number.

        Raises
        ------
        Refuted
            If ``hi`` would not fit 32 bits.
        """
        self.value = space.fits(value.as_kind("word"), 1 << 31 + self.low_bits, what)


WORD_BITS = LOW_BITS["fixed"]
ACCUMULATOR_BITS = LOW_BITS["float"]


def _product(space: Space, d: Affine, a: Affine, columns: int) -> Affine:
    """d * a without the byte products (i,j) with i + j below ``columns``; d in two's complement, a known."""
    if not a.known:
        raise Refuted("a product of two numbers that depend on the state")
    value = d.times(a.constant).as_kind("int64_t")
    most = np.frompyfunc(lambda rate: _most_dropped(int(rate), columns), 1, 1)(a.constant)
    return space.uncertain(value, -most, Ratio(0))


def _most_dropped(rate: int, columns: int) -> Ratio:
    """What the byte products left out can be, the bytes of d at most 255."""
    low = [rate >> 8 * j & 0xFF for j in range(columns)]
    return Ratio(sum(255 * low[j] << 8 * (i + j) for i in range(columns) for j in range(columns - i)))


def _high(space: Space, shift: int, columns: int, d: Affine, a: Affine) -> Affine:
    return space.fits(space.shifted(_product(space, d, a, columns), shift).as_kind("int32_t"))


def _subtract(space: Space, shift: int, columns: int, word: Cell, d: Affine, a: Affine) -> None:
    word.put(space, word.value - space.shifted(_product(space, d, a, columns), shift), "q")


def _add_word(space: Space, word: Cell, term: Cell) -> None:
    word.put(space, word.value + term.value, "a sum")


def _carry(space: Space, word: Cell, change: Affine, place: Affine) -> None:
    part = space.fits(space.shifted(change.times(Ratio(5461)), 16).as_kind("int32_t"), None, "a twelfth of q's change")
    bits = _whole(place)
    if not (bits in (0, 8, 16) or -31 <= bits < 0):
        raise Refuted(f"a carry in place {bits}")
    moved = part.times(Ratio(1 << bits)) if bits >= 0 else space.shifted(part, -bits)
    word.put(space, word.value + moved, "a sum")


def _add_float(space: Space, word: Cell, value: Affine, shift: Affine) -> None:
    scaled = value.times(Ratio(1 << ACCUMULATOR_BITS, 1 << _whole(shift))).as_kind("word")
    space.fits(scaled, 1 << 31 + ACCUMULATOR_BITS, "what is added to a word")
    word.put(space, word.value + space.uncertain(scaled, Ratio(-1), Ratio(1)), "a sum")  # rounded towards zero


def _whole(number: Affine) -> int:
    values = {int(value) for value in number.constant}
    if not number.known or len(values) != 1:
        raise Refuted("a shift that is no constant")
    return values.pop()


Primitive = Callable[..., Any]

_CAST_HIGH = (
    "static inline int32_t N_high{k}(int32_t d, uint32_t a) {{ return (int32_t)(N_product(d, a, {columns}) >> {k}); }}"
)
_SUBTRACT = (
    "static inline void N_subtract{k}(N_Word &word, int32_t d, uint32_t a) "
    "{{ word = N_word(N_whole(word) - (N_product(d, a, {columns}) >> {k})); }}"
)
_WHOLE = "static inline int64_t N_whole(N_Word word) { return (int64_t)word.hi * 65536 + word.lo; }"
_WORD = (
    "static inline N_Word N_word(int64_t whole) "
    "{ N_Word word = {(uint16_t)(whole & 0xFFFF), (int32_t)(whole >> 16)}; return word; }"
)
_PRODUCT = (
    "static inline int64_t N_product(int32_t d, uint32_t a, uint8_t columns) { "
    "int64_t product = (int64_t)d * (int64_t)a; "
    "for (uint8_t column = 0; column < columns; ++column) { for (uint8_t i = 0; i <= column; ++i) { "
    "const int64_t part = (int64_t)((d >> 8 * i) & 0xFF) * (int64_t)((a >> 8 * (column - i)) & 0xFF); "
    "product -= part * ((int64_t)1 << 8 * column); } } return product; }"
)
_CARRY = (
    "static inline void N_carry(N_Word *word, int32_t change, int8_t place) { "
    "const int32_t part = (int32_t)(int16_t)(change >> 16) * 5461 "
    "+ (int32_t)(((uint32_t)(uint16_t)change * 5461u) >> 16); "
    "int32_t high = part >> 16; uint16_t low = (uint16_t)part; "
    "if (place == 8) { high = part >> 8; low = (uint16_t)(low << 8); } "
    "else if (place == 16) { high = part; low = 0; } "
    "else if (place < 0) { const int32_t less = part >> -place; high = less >> 16; low = (uint16_t)less; } "
    "const uint16_t sum = (uint16_t)(word->lo + low); word->hi += high + (sum < low ? 1 : 0); word->lo = sum; }"
)
_ADD_WORD = "static inline void N_add(N_Word &sum, N_Word term) { sum = N_word(N_whole(sum) + N_whole(term)); }"
_ADD_FLOAT = (
    "void N_add(N_Accumulator *sum, float value, uint8_t shift) { "
    "const float scale = 256.0f / static_cast<float>(UINT64_C(1) << shift); "
    "const int64_t whole = static_cast<int64_t>(sum->hi) * 256 + sum->lo + static_cast<int64_t>(value * scale); "
    "sum->lo = static_cast<uint8_t>(whole & 0xFF); sum->hi = static_cast<int32_t>(whole >> 8); }"
)
_READ = "static inline float N_read(const N_Accumulator *sum) { return static_cast<float>(sum->hi); }"


def primitive(model: str, name: str, functions: dict[str, str]) -> Primitive | None:
    """The meaning of a function by its name without the prefix; None if it is not one of the smallest.

    Raises
    ------
    Refuted
        If its text, or that of what it calls, is not the known one.
    """
    number = name.lstrip("abcdefghijklmnopqrstuvwxyz")
    base = name.removesuffix(number)
    k = int(number) if number.isdecimal() else 0
    columns = 1 if (base, k) in {("high", 16), ("high", 24), ("subtract", 16)} else 2
    known: dict[str, tuple[Primitive, dict[str, str]]] = {
        "whole": (lambda space, word: word.value.as_kind("int64_t"), {"whole": _WHOLE}),
        "word": (lambda space, value: Cell(value.as_kind("word"), WORD_BITS), {"word": _WORD}),
        "product": (lambda space, d, a, c: _product(space, d, a, _whole(c)), {"product": _PRODUCT}),
        "read": (lambda space, word: space.as_float(word.high(space)), {"read": _READ}),
        "carry": (_carry, {"carry": _CARRY}),
        "high": (
            lambda space, d, a: _high(space, k, columns, d, a),
            {name: _CAST_HIGH.format(k=k, columns=columns), "product": _PRODUCT},
        ),
        "subtract": (
            lambda space, word, d, a: _subtract(space, k, columns, word, d, a),
            {name: _SUBTRACT.format(k=k, columns=columns), "product": _PRODUCT, "word": _WORD, "whole": _WHOLE},
        ),
        "right": (
            lambda space, word: Cell(space.shifted(word.value, k), WORD_BITS),
            {
                name: f"static inline N_Word N_right{k}(N_Word word) {{ return N_word(N_whole(word) >> {k}); }}",
                "word": _WORD,
                "whole": _WHOLE,
            },
        ),
        "add": (
            (_add_word, {"add": _ADD_WORD, "word": _WORD, "whole": _WHOLE})
            if "word" in functions
            else (_add_float, {"add": _ADD_FLOAT})
        ),
    }
    if base not in known:
        return None
    meaning, texts = known[base]
    for function, text in texts.items():
        if functions.get(function) != text.replace("N_", f"{model}_"):
            raise Refuted(f"{model}_{function} is not the function that the proof knows")
    return meaning
