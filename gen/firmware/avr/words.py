"""Loads, shifts and additions of the states' words of six bytes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gen.firmware.avr.registers import FILL, SPARE, STATE_BYTES, WORD, moves, rows
from gen.firmware.avr.text import AsmText


@dataclass(frozen=True)
class Shifted:
    """A word that was shifted right.

    Attributes
    ----------
    kept
        Registers of the bytes that are left of it, the lowest first.
    fill
        Register of the sign above them.
    free
        A register that holds nothing any more.
    """

    kept: tuple[int, ...]
    fill: int
    free: int

    @property
    def registers(self) -> list[int]:
        """Registers of all six bytes."""
        return [*self.kept, *[self.fill] * (STATE_BYTES - len(self.kept))]


def load(text: AsmText, number: int, registers: Sequence[int]) -> None:
    """Load x[number]."""
    text.group(f"x{number}", *(f"ldd r{r}, Z+{_place(number) + j}" for j, r in enumerate(registers)))


def shift(text: AsmText, registers: Sequence[int], total: int, *, extra: int = SPARE, fill: int = FILL) -> Shifted:
    """Shift a word right in place.

    Bits are shifted to the right, or to the left beyond the byte above (``extra``) when that is shorter.
    """
    whole, bits = divmod(total, 8)
    top = registers[-1]
    signs = [f"lsl r{fill}", f"sbc r{fill}, r{fill}"]
    if whole >= STATE_BYTES:
        text.group("sign", f"mov r{fill}, r{top}", *signs)
        return Shifted((), fill, extra)
    rest = registers[whole:]
    if whole and bits > 4:
        code = [f"mov r{fill}, r{top}", *signs, f"mov r{extra}, r{fill}"]
        for _ in range(8 - bits):
            code += [f"lsl r{rest[0]}", *(f"rol r{r}" for r in [*rest[1:], extra])]
        text.group(f">> {total}", *code)
        return Shifted((*rest[1:], extra), fill, rest[0])
    code = []
    for _ in range(bits):
        code += [f"asr r{rest[-1]}", *(f"ror r{r}" for r in reversed(rest[:-1]))]
    if whole:
        code += [f"mov r{fill}, r{rest[-1]}", *signs]
    if code:
        text.group(f">> {total}", *code)
    return Shifted(tuple(rest), fill, extra)


def add(text: AsmText, target: int, value: Shifted, source: int, total: int) -> None:
    """x[target] += value, which is x[source] >> total."""
    at, free = _place(target), value.free
    patterns = (f"ldd r{free}, Z+{at}+{{j}}", f"{{add}} r{free}, r{{d}}", f"std Z+{at}+{{j}}, r{free}")
    text.group(f"x{target} += x{source} >> {total}", *rows(patterns, value.registers))


def add_shifted(text: AsmText, target: int, source: int, total: int, copy: Sequence[int]) -> None:
    """x[target] += x[source] >> total, with x[source] in WORD and kept; ``copy``: registers for a word."""
    again(text, source, copy, total)
    add(text, target, shift(text, copy, total), source, total)


def again(text: AsmText, source: int, copy: Sequence[int], total: int) -> None:
    """Copy those bytes of x[source], which is in WORD, that a shift by ``total`` looks at."""
    whole = min(total // 8, STATE_BYTES - 1)
    text.group(f"x{source} again", *moves(copy[whole:], WORD[whole:]))


def _place(number: int) -> int:
    return STATE_BYTES * (number - 1)
