"""Which register holds what in the recursion's assembly, and lines of code for one byte after another.

=========  =============================================================================================
register   holds
=========  =============================================================================================
Z, Y       the state and the coefficients of the component at work
r18..r21   a: a rate, unsigned
r22..r25   d: what it multiplies, signed
r26:r27    b2:b3 of the product, whose bytes are b0..b7 (b0, b1 are not wanted)
r16:r17    b4:b5
r14:r15    scratch, b6
r12:r13    scratch, b7
r11        0 within a product, then its sign extension
r10, r9    components and runs left (a block in the step looks at Z instead of r10)
=========  =============================================================================================
"""

from __future__ import annotations

from collections.abc import Sequence

A = (18, 19, 20, 21)
D = (22, 23, 24, 25)
B = {2: 26, 3: 27, 4: 16, 5: 17, 6: 15, 7: 13}
SIGN = 11
COMPONENTS, RUNS = 10, 9
WORD = (20, 21, 22, 23, 24, 25)
"""A word in the dead a and d."""
FILL, SPARE = 12, 14
"""The bytes above a shifted word, and a byte to shift into or to add with."""
STATE_BYTES = 6
"""Of a state's word."""
COEFFICIENT_BYTES = 4
"""Of a rate, and of the steady rise."""


def product_bytes(k: int) -> list[int]:
    """Registers of a product's bytes from bit k on, as many as a state has; the sign's stands for all above."""
    registers = [B[j] for j in range(k // 8, 8)]
    return registers + [SIGN] * (STATE_BYTES - len(registers))


def word_copy(last_product: int) -> tuple[int, ...]:
    """Registers for another word than :data:`WORD`, while the product from bit ``last_product`` on is kept.

    Its bytes leave r26 or r11 free.
    """
    return (12, 11 if last_product == 16 else 26, 18, 19, 0, 1)


def rows(patterns: tuple[str, ...], data: Sequence[int], values: Sequence[int] | None = None) -> list[str]:
    """Fill the patterns for each byte: j, d, v, and sub/add without the carry at the first."""
    result = []
    for j, d in enumerate(data):
        names = {
            "j": j,
            "d": d,
            "v": values[j] if values is not None else 0,
            "sub": "sbc" if j else "sub",
            "add": "adc" if j else "add",
        }
        result += [pattern.format(**names) for pattern in patterns]
    return result


def moves(target: Sequence[int], source: Sequence[int]) -> list[str]:
    """Copy bytes, pairs at once where both are aligned."""
    code, j = [], 0
    while j < len(target):
        pair = j + 1 < len(target) and target[j] % 2 == source[j] % 2 == 0
        pair = pair and target[j + 1] == target[j] + 1 and source[j + 1] == source[j] + 1
        code.append(f"{'movw' if pair else 'mov'} r{target[j]}, r{source[j]}")
        j += 2 if pair else 1
    return code


def load_pointer(register: int, address: str) -> list[str]:
    """Let a pair of registers hold an address."""
    return [f"ldi r{register}, lo8({address})", f"ldi r{register + 1}, hi8({address})"]


def step_pointer(register: int, distance: int) -> list[str]:
    """Move a pair of registers on by so many bytes."""
    return [f"subi r{register}, lo8({-distance})", f"sbci r{register + 1}, hi8({-distance})"]
