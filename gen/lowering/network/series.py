"""How the board takes the terms of the series in fixed point: the byte products it keeps, a half, a third and so on.

A product of a difference d, signed, with a rate a, unsigned, is the sum of the products of their bytes, of which
d_i a_j weighs 2^(8 (i + j)). What a later term of the series contributes is small: its lightest byte products are left
out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gen.arrays import IntArray

EXTRA_SHIFT: Final = {2: 1, 3: 0, 4: 2, 5: 0}
"""By the series' term k: a half and a fourth are shifts of the sum, a third and a fifth are of the term before."""
WEIGHT: Final = {3: 85, 5: 51}
"""A third as 85/256 (1 + 1/256), a fifth as 51/256 (1 + 1/256): off by 2^-16 of themselves."""


@dataclass(frozen=True)
class Product:
    """``sum of d_i a_j 2^(8 (i + j))`` over i + j >= least, in units of 2^(8 unit).

    Attributes
    ----------
    width
        Bytes of d, and of a: a rate's upper ones.
    least
        Weight in bytes of the lightest product that is kept, at most the width.
    cut
        Whether the lower bytes of the lightest products are left out, too.
    """

    width: int
    least: int
    cut: bool = True

    @property
    def name(self) -> str:
        """Width and lightest weight."""
        return f"{self.width}{self.least}"

    @property
    def unit(self) -> int:
        """Bytes that a sum is short of the whole product."""
        return self.least + int(self.cut)

    @property
    def sum_bytes(self) -> int:
        """Bytes of a sum of such products."""
        return 2 * self.width - self.unit

    @property
    def places(self) -> list[tuple[int, int]]:
        """The bytes (i, j) that are multiplied, lightest first."""
        both = range(self.width)
        return sorted(((i, j) for i in both for j in both if i + j >= self.least), key=lambda pair: (sum(pair), pair))

    @property
    def dropped(self) -> float:
        """What is left out of a product is between 0 and this, in units of the sum."""
        below = sum(255**2 * 2.0 ** (8 * (i + j)) for i in range(self.least) for j in range(self.least - i))
        cut = 255.0 * 2.0 ** (8 * self.least) * sum(i + j == self.least for i, j in self.places) if self.cut else 0.0
        return float(below + cut) * 2.0 ** (-8 * self.unit)

    @property
    def chains(self) -> list[list[tuple[int, int]]]:
        """Those bytes in groups whose 16-bit results lie side by side: each is one chain of additions."""
        left = list(self.places)
        made = []
        while left:
            chain = [left.pop(0)]
            while nearest := [pair for pair in left if sum(pair) == sum(chain[-1]) + 2]:
                chain.append(nearest[0])
                left.remove(nearest[0])
            made.append(chain)
        return made

    @property
    def cost(self) -> float:
        """Cycles that a term takes on the AVR, its operands' loads included."""
        adding = sum(3 * len(chain) - 1 + self.sum_bytes - max(0, sum(chain[0]) - self.unit) for chain in self.chains)
        return adding + 5.0 + 4.5 * self.width

    def of(self, difference: IntArray, rate: IntArray) -> IntArray:
        """Its value; the difference within the signed, the rate within the unsigned numbers of `width` bytes."""
        total: IntArray = difference * rate
        for i in range(self.least):  # byte i times the rate's bytes that with it come below the least place
            total = total - ((difference >> 8 * i & 0xFF) * (rate & (1 << 8 * (self.least - i)) - 1) << 8 * i)
        for i, j in self.places if self.cut else ():
            if i + j == self.least:
                total = total - ((_bytes(difference, i, rate, j) & 0xFF) << 8 * self.least)
        return total >> 8 * self.unit


def _bytes(difference: IntArray, i: int, rate: IntArray, j: int) -> IntArray:
    return (difference >> 8 * i & 0xFF) * (rate >> 8 * j & 0xFF)


WHOLE: Final = Product(4, 2, cut=False)
"""Of everything that a channel scales, and of degrees."""
FIRST: Final = Product(4, 2)
"""Of temperatures."""
CHOICES: Final = {
    2: (Product(3, 1), Product(4, 3), Product(4, 2)),
    3: (Product(2, 1), Product(3, 2), Product(4, 3)),
    4: (Product(1, 0, cut=False), Product(2, 1), Product(3, 2)),
    5: (Product(1, 0, cut=False), Product(2, 1), Product(3, 2)),
}
"""By the series' term: products that it may be made of, the cheapest first."""
