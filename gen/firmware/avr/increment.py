"""The increment q of the uppermost state: nested products of the rates.

Products are those of :func:`gen.reference.fixed.product`; the order of their byte products is such that no chain of
additions can carry past the byte at which it stops (each byte product is at most 0xFE01).
"""

from __future__ import annotations

from gen.firmware.avr.registers import COEFFICIENT_BYTES, SIGN, STATE_BYTES, A, B, D, product_bytes, rows
from gen.firmware.avr.text import AsmText
from gen.lowering.fixed.corrected_format import FIRST_DROPPED
from gen.lowering.fixed.formats import Format, dropped_bytes

_HIGH = 2
"""Place of the high word in a state's word."""


def increment(text: AsmText, layout: Format, label: str, *, walks: bool) -> None:
    """The product whose negative is q, in b2..b7 and the sign.

    Parameters
    ----------
    text
        What is written.
    layout
        Formats of the component.
    label
        Where a change of PWM comes in that wants q alone.
    walks
        Whether the pointer to the coefficients is walked along.
    """
    if walks:
        _first_factors_walking(text)
    else:
        _first_factors(text, layout.order, label)
    last = layout.order - 1
    for i, k in enumerate(layout.product_shifts):
        wide = i == last
        first = layout.corrected and i == 0
        dropped = FIRST_DROPPED if first else dropped_bytes(k, wide=wide)
        _multiply(text, dropped, k, wide=wide, zero=i > 0)
        if not wide:
            _next_factors(text, i + 1, product_bytes(k), halves=not layout.corrected)


def _first_factors_walking(text: AsmText) -> None:
    text.group("a = R0", *(f"ld r{a}, Y+" for a in A))
    text.group("d = x1.hi - S", *_high_word(1), *rows(("ld r0, Y+", "{sub} r{d}, r0"), D))


def _first_factors(text: AsmText, order: int, label: str) -> None:
    if order > 1:
        text.group("", f"{label}:")
    steady = COEFFICIENT_BYTES * order
    text.group("d = x1.hi - S", *_high_word(1), *rows((f"ldd r0, Y+{steady}+{{j}}", "{sub} r{d}, r0"), D))
    text.group("a = R0", *_rate(0))


def _next_factors(text: AsmText, number: int, product: list[int], *, halves: bool) -> None:
    """After the product with R[number-1]: what R[number] multiplies."""
    code = ["sec"] if halves else []
    for j, (load, d) in enumerate(zip(_high_word(number + 1), D, strict=True)):
        add = "adc" if j or halves else "add"
        code += [load, f"{add} r{d}, r{product[j]}"]
    extra = " + 1 (half of what two roundings down lose)" if halves else ""
    text.group(f"d = x{number + 1}.hi + product{extra}", *code)
    text.group(f"a = R{number}", *_rate(number))


def _high_word(number: int) -> list[str]:
    """Load d with the high word of x[number]."""
    return [f"ldd r{d}, Z+{STATE_BYTES * (number - 1) + _HIGH + j}" for j, d in enumerate(D)]


def _rate(number: int) -> list[str]:
    """Load a with R[number]."""
    return [f"ldd r{a}, Y+{COEFFICIENT_BYTES * number + j}" for j, a in enumerate(A)]


def _multiply(text: AsmText, dropped: int, k: int, *, wide: bool, zero: bool) -> None:
    """b2..b7 and, if wide, the sign = a * d; ``zero`` if the sign's register is 0 already."""
    text.lines.append(f"        // product, from bit {k} on")
    if not zero:
        text.group("", f"clr r{SIGN}")
    text.lines.append(f"        {text.prefix}_PRODUCT_{dropped * (dropped + 1) // 2}")
    needed = 4 if wide else k // 8
    code = [f"sub r{B[4]}, r18", f"sbc r{B[5]}, r19"]
    if needed > 2:
        code.append(f"sbc r{B[6]}, r20")
    if needed > 3:
        code.append(f"sbc r{B[7]}, r21")
    if wide and k > 16:
        code.append(f"sbc r{SIGN}, r{SIGN}")
    text.group("d < 0: less a * 2^32", "sbrs r25, 7", "rjmp 1f", *code, "1:")
