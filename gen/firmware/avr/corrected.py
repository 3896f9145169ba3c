"""The additions of the corrected form (:mod:`gen.lowering.fixed.correction`).

-q is in r27, r16, r17, r15, r13 and the sign, R2 still in a.
"""

from __future__ import annotations

from gen.firmware.avr.registers import SIGN, SPARE, WORD, rows
from gen.firmware.avr.text import AsmText
from gen.firmware.avr.words import add, again, load, shift
from gen.lowering.fixed.formats import GAIN_FACTOR, Format

_GAIN = 21
_LAST = (26, 27, 14, 18, 19)
"""Bytes 1 to 5 of x3."""
_COPY = (11, 15, 16, 17, 0, 1)
"""Another word than the one in WORD."""
_D = (24, 25, 22, 22, 22, 22)
"""The correction d with its sign."""


def add_corrected(text: AsmText, layout: Format) -> None:
    """x3 += q; x1 += x2, shifted; x2 += x3, shifted, and the correction d."""
    first, second = layout.chain_shifts
    text.group("r21: 4/3 of R2's uppermost byte", f"ldi r22, {GAIN_FACTOR}", "fmul r21, r22", f"mov r{_GAIN}, r1")
    _add_increment(text)
    _correction(text, layout.first_rate_cut)
    added = shift(text, [SPARE, *_LAST], second, extra=16).registers
    text.group(f"x3 >> {second} and d", *rows(("{add} r{v}, r{d}",), _D, added))
    load(text, 2, WORD)
    again(text, 2, _COPY, first)
    add(text, 1, shift(text, _COPY, first, fill=SIGN, extra=13), 2, first)
    text.group(f"x2 += x3 >> {second} and d", *rows(("{add} r{v}, r{d}", "std Z+6+{j}, r{v}"), added, WORD))


def _add_increment(text: AsmText) -> None:
    code = ["ldd r0, Z+12", "sub r0, r27", "std Z+12, r0"]
    for j, (r, q) in enumerate(zip(_LAST, (16, 17, 15, 13, SIGN), strict=True)):
        code += [f"ldd r{r}, Z+{13 + j}", f"sbc r{r}, r{q}", f"std Z+{13 + j}, r{r}"]
    text.group("x3 += q; its bytes 1 to 5 stay in r26, r27, r14, r18, r19", *code)


def _correction(text: AsmText, cut: int) -> None:
    """d from short numbers; R0's byte is ``cut`` bits shorter."""
    shorten = (["swap r17", "andi r17, 15"] if cut >= 4 else []) + ["lsr r17"] * (cut % 4)
    text.group(
        "r22:r23 = x3 >> 33, and R0's byte times x2's",
        "movw r22, r18",
        "asr r23",
        "ror r22",
        "ldd r20, Z+11",
        "ldd r17, Y+3",
        *shorten,
        "mulsu r20, r17",
        "add r22, r0",
        "adc r23, r1",
    )
    text.group(
        "r16:r17 = that times R1's byte",
        "ldd r20, Y+7",
        "mulsu r23, r20",
        "movw r16, r0",
        "mul r22, r20",
        f"clr r{SIGN}",
        "add r16, r1",
        f"adc r17, r{SIGN}",
    )
    text.group("and 2 q: the change of q", "lsl r15", "rol r13", "sub r16, r15", "sbc r17, r13")
    text.group(
        "d in r24:r25 and its sign r22 = that times r21, >> 7",
        f"mulsu r17, r{_GAIN}",
        "sbc r22, r22",
        "movw r24, r0",
        f"mul r16, r{_GAIN}",
        "add r24, r1",
        f"adc r25, r{SIGN}",
        f"adc r22, r{SIGN}",
        "lsl r0",
        "rol r24",
        "rol r25",
    )
