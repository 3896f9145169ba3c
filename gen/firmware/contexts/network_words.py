"""AVR instructions for a network's sums: byte products in registers that never change their part, and shifts that are
mostly renamed bytes.

A block of assembly is one state in one term of the series. Registers, the same in every block:

    r2 .. r7    the sum, its lowest byte first
    r8 .. r11   the state's own value
    r12 .. r15  the difference (one of one byte: r20)
    r16 .. r19  the rate
    r20 .. r23  products that are about to be added
    r24, r25    what is shifted out of the sum; 0
    X           rates and heats of this sample, in the order of their use
    Z           the values that differences are taken of, then those that are handed on
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from gen.lowering.network.fixed import LOW_BITS
from gen.lowering.network.series import FIRST, Product

STATE_BYTES = 4 + LOW_BITS // 8
_REACH = 63
"""Largest displacement of a load or a store."""
_IN_A_ROW = 4
_ZERO, _OVER, _SIGN = "r25", "r24", "r23"


@dataclass(frozen=True)
class Registers:
    """Names of bytes, the lowest first."""

    sum: Sequence[str]
    d: Sequence[str]
    a: Sequence[str]
    low: Sequence[str] = ("r20", "r21")
    middle: Sequence[str] = ("r22", "r23")
    zero: str = _ZERO


def _registers(first: int, count: int) -> list[str]:
    return [f"r{first + k}" for k in range(count)]


def fixed_registers(product: Product) -> Registers:
    """The registers of every block."""
    d = ["r20"] if product.width == 1 else _registers(12, product.width)
    return Registers(_registers(2, product.sum_bytes), d, _registers(16, product.width))


def operands() -> Registers:
    """Operands of the one function that multiplies where it is called."""
    names = {name: [f"%{byte}[{name}]" for byte in "ABCD"] for name in ("lo", "hi", "d", "a", "low", "middle")}
    sums = [*names["lo"][:2], *names["hi"]]
    return Registers(sums, names["d"], names["a"], names["low"][:2], names["middle"][:2], "%[zero]")


def multiply(product: Product, use: Registers) -> list[str]:
    """Adds a product to a sum; N tells the sign of the difference if it has more than a byte."""
    width, sums = product.width, use.sum
    if width == 1:
        return [f"mulsu {use.d[0]}, {use.a[0]}", f"add {sums[0]}, r0", f"adc {sums[1]}, r1"]
    # A negative difference is taken for 2^(8 width) more: multiplications leave the flags of its subtraction alone.
    lines = ["brpl 1f"]
    for k, byte in enumerate(sums[width - product.unit :]):
        lines.append(f"{'sbc' if k else 'sub'} {byte}, {use.a[k]}")
    lines.append("1:")
    for chain in product.chains:
        kept = [use.low, use.middle][: len(chain) - 1]
        results = [byte for pair in kept for byte in pair] + ["r0", "r1"]
        for k, (i, j) in enumerate(chain):
            lines.append(f"mul {use.d[i]}, {use.a[j]}")
            if k < len(kept):
                lines.append(f"movw {kept[k][0]}, r0")
        place = sum(chain[0]) - product.unit
        if place < 0:  # without the lower byte
            place, results = 0, results[1:]
        for k, byte in enumerate(sums[place:]):
            lines.append(f"{'adc' if k else 'add'} {byte}, {results[k] if k < len(results) else use.zero}")
    return lines


def shift(names: Sequence[str], bits: int, wanted: int) -> tuple[list[str], list[str]]:
    """Lines that shift a signed word down by `bits`, or up by -`bits`, and its `wanted` lowest bytes' places then."""
    rest = (bits + 3) % 8 - 3
    if rest > 0 and bits < rest:
        rest -= 8  # up, as there is no byte below
    skipped = (bits - rest) // 8
    lines: list[str] = []
    sign = [f"mov {_SIGN}, {names[-1]}", f"lsl {_SIGN}", f"sbc {_SIGN}, {_SIGN}"]
    places = [*names]
    if rest < 0:
        if max(0, -skipped) + len(places[max(0, skipped) :]) < wanted:
            lines += [*sign, f"mov {_OVER}, {_SIGN}"]
            sign = []
            places.append(_OVER)
        moved = places[max(0, skipped - 1) :]
        lines += [f"{'rol' if k else 'lsl'} {byte}" for _ in range(-rest) for k, byte in enumerate(moved)]
    elif rest > 0:
        moved = list(reversed(places[skipped:]))
        lines += [f"{'ror' if k else 'asr'} {byte}" for _ in range(rest) for k, byte in enumerate(moved)]
    found = [_ZERO] * max(0, -skipped) + places[max(0, skipped) :]
    if len(found) < wanted:
        lines += sign
        found += [_SIGN] * (wanted - len(found))
    return lines, found[:wanted]


def take_up(names: Sequence[str], bits: int, place: int) -> list[str]:
    """Adds a sum, shifted down by `bits`, to the state whose word lies `place` bytes behind the first one's."""
    lines, found = shift(names, bits, STATE_BYTES)
    first = next(k for k, byte in enumerate(found) if byte != _ZERO)
    for k, byte in enumerate(found[first:], start=first):
        at = f"%[T]+{place + k}"
        lines += [f"lds r0, {at}", f"{'adc' if k > first else 'add'} r0, {byte}", f"sts {at}, r0"]
    return lines


def _move(to: Sequence[str], given: Sequence[str]) -> list[str]:
    """Copies in an order in which nothing is overwritten that is still to be read."""
    pairs = list(zip(to, given, strict=True))
    if any(place in given[k + 1 :] for k, place in enumerate(to)):
        pairs.reverse()
    return [f"mov {place}, {byte}" for place, byte in pairs if place != byte]


def fraction(given: Sequence[str], factor: int) -> tuple[list[str], list[str]]:
    """A third or a fifth of a word: factor/256 of it, and a 256th of that more; and where it is then."""
    width = len(given)
    moved, part = _registers(16, width), _registers(8, width)
    lines = [*_move(moved, given), f"ldi r22, {factor}"]
    for k, byte in enumerate(moved):
        lines.append(f"{'muls' if k == width - 1 else 'mul'} {byte}, r22")
        if k:
            lines.append(f"add {part[k - 1]}, r0")
        lines.append(f"mov {part[k]}, r1")
        if k:
            lines.append(f"adc {part[k]}, {_ZERO}")
    lines += [f"mov {_SIGN}, {part[-1]}", f"lsl {_SIGN}", f"sbc {_SIGN}, {_SIGN}"]
    for k, byte in enumerate(part):
        lines.append(f"{'adc' if k else 'add'} {byte}, {part[k + 1] if k + 1 < width else _SIGN}")
    return lines, part


def warm(bits: int) -> list[str]:
    """Adds an unsigned 32-bit word in the rate's registers, shifted up by `bits`, to a whole sum."""
    given, sums = _registers(16, 4), fixed_registers(FIRST).sum
    rest, skipped = bits % 8, bits // 8
    lines = [f"clr {_OVER}"] if rest else []
    places = given
    if 0 < rest <= 4:
        places = [*given, _OVER]
        lines += [f"{'rol' if k else 'lsl'} {byte}" for _ in range(rest) for k, byte in enumerate(places)]
    elif rest:
        places = [_OVER, *given]
        lines += [f"{'ror' if k else 'lsr'} {byte}" for _ in range(8 - rest) for k, byte in enumerate(reversed(places))]
    for k, byte in enumerate(sums[skipped:]):
        lines.append(f"{'adc' if k else 'add'} {byte}, {places[k] if k < len(places) else _ZERO}")
    return lines


def _reached(operation: str, names: Sequence[str], place: int) -> list[str]:
    """Loads or stores of bytes from Z + place on."""

    def line(byte: str, at: int) -> str:
        return f"ldd {byte}, Z+{at}" if operation == "ldd" else f"std Z+{at}, {byte}"

    if place + len(names) - 1 <= _REACH:
        return [line(byte, place + k) for k, byte in enumerate(names)]
    there = [f"subi r30, lo8(-({place}))", f"sbci r31, hi8(-({place}))"]
    back = [f"subi r30, lo8({place})", f"sbci r31, hi8({place})"]
    return [*there, *(line(byte, k) for k, byte in enumerate(names)), *back]


@dataclass
class Block:
    """One state in one term of the series.

    Attributes
    ----------
    product
        Of its sum.
    position
        Where X is, in bytes from the first rate.
    parts
        Comments and lines, in order; a line that begins with `#` names a macro.
    """

    product: Product
    position: int
    parts: list[dict[str, Any]] = field(default_factory=list)

    def add(self, note: str | None, lines: Sequence[str]) -> None:
        """Append lines under a comment."""
        self.parts.append({"note": note, "lines": list(lines)})

    def begin(self, own: int) -> None:
        """Clear the sum, load the state's own value from Z + own."""
        names = fixed_registers(self.product).sum
        lines = [f"clr {_ZERO}", "clr r2", "clr r3"]
        lines += [f"movw r{2 + k}, r2" for k in range(2, len(names), 2)]
        self.add(None, [*lines, *_reached("ldd", _registers(8, self.product.width), own)])

    def term(self, note: str, source: int | None, rate: int | None, word: int, *, growing: bool) -> None:
        """Add a term.

        Parameters
        ----------
        note
            What it is.
        source
            Place of the value that the own one is subtracted from, None: it is 0.
        rate
            The rate's word where it is constant.
        word
            Elsewhere: which word behind X's first.
        growing
            Whether it is subtracted from the own one.
        """
        use, width = fixed_registers(self.product), self.product.width
        own, d = _registers(8, width), use.d
        if rate is None:
            lines = self._load(use.a, 4 * word + 4 - width)
        else:
            lines = [f"ldi {byte}, {rate >> 8 * (4 - width + k) & 0xFF}" for k, byte in enumerate(use.a)]
        copy = [f"mov {to}, {byte}" for to, byte in zip(d, own, strict=True)]
        if source is None and growing:
            lines += [*copy, f"tst {d[-1]}"]
        elif source is None:
            lines += [f"clr {byte}" for byte in d] + _difference(d, own)
        elif growing:
            there = _registers(20, width) if width > 1 else ["r21"]
            lines += _reached("ldd", there, source) + copy + _difference(d, there)
        else:
            lines += _reached("ldd", d, source) + _difference(d, own)
        self.add(note, [*lines, f"#ADD{self.product.name}"])

    def heat(self, note: str, word: int, left: int) -> None:
        """Add a heat's word, shifted up."""
        self.add(note, [*self._load(_registers(16, 4), 4 * word), *warm(left)])

    def scaled_heat(self, note: str, word: int) -> None:
        """Add the product of a factor with a heat's word."""
        use = fixed_registers(FIRST)
        loads = [*self._load(use.d, 4 * word), *self._load(use.a, 4 * word + 4), f"tst {use.d[-1]}"]
        self.add(note, [*loads, f"#ADD{self.product.name}"])

    def _load(self, names: Sequence[str], place: int) -> list[str]:
        """Bytes from X, which moves behind them."""
        skipped, self.position = place - self.position, place + len(names)
        lines = [f"adiw r26, {skipped}"] if 0 < skipped <= _REACH else []
        if not 0 <= skipped <= _REACH:
            lines = [f"subi r26, lo8({-skipped})", f"sbci r27, hi8({-skipped})"]
        return lines + [f"ld {byte}, X+" for byte in names]

    def hand_on(self, to_state: int, state: int, to_next: int, place: int, width: int, factor: int | None) -> None:
        """Let a state take the sum up, and hand it on as a word of `width` bytes to Z + place.

        Parameters
        ----------
        to_state, to_next
            By how many bits it is shifted down.
        state
            Place of the state's word.
        place, width
            Of the word that is handed on; width 0: none is.
        factor
            Of 256, for a third or a fifth of it.
        """
        names = fixed_registers(self.product).sum
        copy = _registers(12, len(names))
        spare = [f"movw r{12 + k}, r{2 + k}" for k in range(0, len(names), 2)] if width else []
        self.add("taken up", [*spare, *take_up(names, to_state, state)])
        if width and factor is None:
            lines, found = shift(copy, to_next, width)
            self.add("handed on", [*lines, *_reached("std", found, place)])
        elif width and factor is not None:
            below = int(width < 4)
            lines, found = shift(copy, to_next - 8 * below, width + below)
            divided, part = fraction(found, factor)
            self.add("handed on", [*lines, *divided, *_reached("std", part[below:], place)])

    def rows(self, prefix: str) -> list[dict[str, Any]]:
        """The parts, as rows of string literals and macros."""
        made = []
        for part in self.parts:
            rows: list[str] = []
            held: list[str] = []
            for line in [*part["lines"], None]:
                if held and (line is None or line.startswith("#") or len(held) == _IN_A_ROW):
                    rows.append('"' + "".join(f"{one}\\n\\t" for one in held) + '"')
                    held = []
                if line is not None and line.startswith("#"):
                    rows.append(prefix + line[1:])
                elif line is not None:
                    held.append(line)
            made.append({"note": part["note"], "rows": rows})
        return made

    def still(self, places: Sequence[int], width: int) -> None:
        """Hand on 0 for states that take no part."""
        for place in places:
            self.add("no part in this term", _reached("std", [_ZERO] * width, place))


def _difference(one: Sequence[str], other: Sequence[str]) -> list[str]:
    return [f"{'sbc' if k else 'sub'} {a}, {b}" for k, (a, b) in enumerate(zip(one, other, strict=True))]
