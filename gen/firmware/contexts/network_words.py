"""AVR instructions for the words of a network: sums of byte products, and shifts that are mostly renamed bytes.

Every function gives lines of inline assembly; what a line names in square brackets is an operand of the template's.
"""

from __future__ import annotations

from typing import Any

from gen.lowering.network.fixed import LOW_BITS
from gen.lowering.network.series import Product

_STATE_BYTES = 4 + LOW_BITS // 8
_BYTES = "ABCD"


def byte_names(operand: str, count: int) -> list[str]:
    """A word's bytes, the lowest first."""
    return [f"%{_BYTES[k]}[{operand}]" for k in range(count)]


def sum_names(count: int) -> list[str]:
    """A sum's bytes: up to 4 in `hi`, those below in `lo`."""
    high = high_bytes(count)
    return [*byte_names("lo", count - high), *byte_names("hi", high)]


def high_bytes(count: int) -> int:
    """How many of a sum's bytes are in `hi`: a type has 1, 2 or 4."""
    return 4 if count >= 4 else 2


def _low_bytes(count: int) -> int:
    return count - high_bytes(count)


def sum_context(product: Product) -> dict[str, Any]:
    """A kind of sum, and the lines that add a product to it."""
    count = product.sum_bytes
    return {
        "bytes": count,
        "high": 8 * high_bytes(count),
        "low": 8 * _low_bytes(count),
        "width": product.width,
        "least": product.least,
        "lines": _multiply(product),
        "middle": any(len(chain) > 2 for chain in _chains(product)),
    }


def _chains(product: Product) -> list[list[tuple[int, int]]]:
    """Byte products in groups whose 16-bit results lie side by side: one chain of additions each."""
    left = list(product.places)
    made = []
    while left:
        chain = [left.pop(0)]
        while nearest := [pair for pair in left if sum(pair) == sum(chain[-1]) + 2]:
            chain.append(nearest[0])
            left.remove(nearest[0])
        made.append(chain)
    return made


def _multiply(product: Product) -> list[str]:
    width, sums = product.width, sum_names(product.sum_bytes)
    d, a = byte_names("d", width), byte_names("a", width)
    if width == 1:
        return ["mulsu %[d], %[a]", f"add {sums[0]}, r0", f"adc {sums[1]}, r1", "clr r1"]
    lines = []
    for chain in _chains(product):
        kept = [*("low", "middle")[: len(chain) - 1]]
        results = [f"%{byte}[{name}]" for name in kept for byte in "AB"] + ["r0", "r1"]
        for k, (i, j) in enumerate(chain):
            lines.append(f"mul {d[i]}, {a[j]}")
            if k < len(kept):
                lines.append(f"movw %A[{kept[k]}], r0")
        place = sum(chain[0]) - product.least
        for k, byte in enumerate(sums[place:]):
            lines.append(f"{'adc' if k else 'add'} {byte}, {results[k] if k < len(results) else '%[zero]'}")
    # A negative difference was taken for 2^(8 width) more.
    lines += [f"sbrs {d[-1]}, 7", "rjmp 1f"]
    for k, byte in enumerate(sums[width - product.least :]):
        lines.append(f"{'sbc' if k else 'sub'} {byte}, {a[k]}")
    return [*lines, "1:", "clr r1"]


def _shift(names: list[str], bits: int, wanted: int) -> tuple[list[str], list[str | None]]:
    """Lines that shift a signed word down by `bits` and where its `wanted` lowest bytes are then; None: 0."""
    rest = (bits + 3) % 8 - 3
    if rest > 0 and bits < rest:
        rest -= 8  # up, as there is no byte below
    skipped = (bits - rest) // 8
    lines: list[str] = []
    sign = ["mov %[sign], " + names[-1], "lsl %[sign]", "sbc %[sign], %[sign]"]
    places = [*names]
    if rest < 0:
        lines += [*sign, "mov %[over], %[sign]"]
        sign = []
        places.append("%[over]")
        moved = places[max(0, skipped - 1) :]
        lines += [f"{'rol' if k else 'lsl'} {byte}" for _ in range(-rest) for k, byte in enumerate(moved)]
    elif rest > 0:
        moved = list(reversed(places[skipped:]))
        lines += [f"{'ror' if k else 'asr'} {byte}" for _ in range(rest) for k, byte in enumerate(moved)]
    found: list[str | None] = [None] * max(0, -skipped)
    found += places[max(0, skipped) :]
    if len(found) < wanted:
        lines += sign
        found += ["%[sign]"] * (wanted - len(found))
    return lines, found[:wanted]


def take_up(count: int, bits: int) -> dict[str, Any]:
    """Adds a sum of `count` bytes, shifted down by `bits`, to a state."""
    lines, found = _shift(sum_names(count), bits, _STATE_BYTES)
    first = next(k for k, byte in enumerate(found) if byte)
    for k, byte in enumerate(found[first:], start=first):
        lines += [f"ldd r0, %a[T]+{k}", f"{'adc' if k > first else 'add'} r0, {byte}", f"std %a[T]+{k}, r0"]
    return {"sum": count, "low": _low_bytes(count), "bits": bits, "lines": lines}


def word(count: int, bits: int, width: int) -> dict[str, Any]:
    """A sum of `count` bytes, shifted down by `bits`, as a word of `width` bytes that it is proven to fit."""
    lines, found = _shift(sum_names(count), bits, width)
    for to, byte in zip(byte_names("word", width), found, strict=True):
        lines.append(f"mov {to}, {byte}" if byte else f"clr {to}")
    return {"sum": count, "low": _low_bytes(count), "bits": bits, "width": width, "lines": lines}


def heat(bits: int) -> dict[str, Any]:
    """Adds an unsigned 32-bit word, shifted up by `bits`, to a sum of 6 bytes."""
    given, sums = byte_names("word", 4), sum_names(_STATE_BYTES)
    rest, skipped = bits % 8, bits // 8
    lines = ["clr %[over]"] if rest else []
    places = given
    if 0 < rest <= 4:
        places = [*given, "%[over]"]
        lines += [f"{'rol' if k else 'lsl'} {byte}" for _ in range(rest) for k, byte in enumerate(places)]
    elif rest:
        places = ["%[over]", *given]
        lines += [f"{'ror' if k else 'lsr'} {byte}" for _ in range(8 - rest) for k, byte in enumerate(reversed(places))]
    for k, byte in enumerate(sums[skipped:]):
        lines.append(f"{'adc' if k else 'add'} {byte}, {places[k] if k < len(places) else '%[zero]'}")
    return {"bits": bits, "lines": lines}


def fraction(width: int, factor: int, name: str) -> dict[str, Any]:
    """A third or a fifth of a word: factor/256 of it, and a 256th of that more."""
    given, part = byte_names("y", width), byte_names("part", width)
    lines = []
    for k, byte in enumerate(given):
        lines.append(f"{'muls' if k == width - 1 else 'mul'} {byte}, %[factor]")
        if k:
            lines.append(f"add {part[k - 1]}, r0")
        lines.append(f"mov {part[k]}, r1")
        if k:
            lines.append(f"adc {part[k]}, %[zero]")
    lines += [f"mov %[sign], {part[-1]}", "lsl %[sign]", "sbc %[sign], %[sign]"]
    for k, byte in enumerate(part):
        lines.append(f"{'adc' if k else 'add'} {byte}, {part[k + 1] if k + 1 < width else '%[sign]'}")
    return {"name": name, "width": width, "factor": factor, "lines": [*lines, "clr r1"]}
