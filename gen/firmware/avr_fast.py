"""One sample of the fast form as one block of assembly for the AVR.

Every component's code stands by itself and reaches the model by absolute addresses: loads and stores, not products,
bound this form, and a direct load costs as much as one through a pointer that would have to be set up and saved.

=========  =============================================================================================
register   holds
=========  =============================================================================================
r18..r21   a: a rate, unsigned (r18..r20 if it has 24 bits)
r22..r27,  d and the result of a product, in turns; then what is added to the state
r30, r31
r17        0
r16        a fifth byte where one is needed
=========  =============================================================================================

Products are those of :mod:`gen.lowering.fast_format`.  The order of the byte products is such that no chain of
additions can carry past the byte at which it stops (each byte product is at most 0xFE01).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gen.firmware.asm_text import AsmText
from gen.lowering.fast_format import BLOCK, RESIDUE_BITS, FastComponent
from gen.lowering.lower import Program

_A = (18, 19, 20, 21)
_FIRST, _SECOND = (24, 25, 26, 27), (22, 23, 30, 31)
_ZERO, _FIFTH = 17, 16
_WORD_BYTES = 5

Registers = Sequence[int]


@dataclass(frozen=True)
class FastBlock:
    """What the templates print.

    Attributes
    ----------
    lines
        The assembly, as lines of a C++ string with comments; the operand ``m`` is the model's address.
    clobbers
        Registers that it changes.
    state_bytes, model_bytes
        Sizes that it takes for granted, for the compiler to check.
    rounded, terms
        For a change of PWM: the product to nearest, and the series' second and third term.
    """

    lines: tuple[str, ...]
    clobbers: str
    rounded: tuple[str, ...]
    terms: tuple[str, ...]
    state_bytes: int
    model_bytes: int


def coefficient_bytes(component: FastComponent) -> int:
    """Size of a component's coefficients on the board."""
    steady = 3 if component.layout.narrow else 4
    first = 3 if component.layout.narrow and component.order > 1 else 4
    return first + 4 * (component.order - 1) + steady


def fast_block(program: Program) -> FastBlock:
    """The block of a fast program, whose components lie in the board's state in the order of its shapes."""
    members = [
        component
        for shape in program.shapes
        for member in shape.members
        if isinstance(component := program.components[member], FastComponent)
    ]
    state_bytes = sum(_WORD_BYTES * component.order for component in members)
    coefficients = state_bytes
    state = 0
    text = AsmText()
    text.group("", f"clr r{_ZERO}")
    turns: list[list[tuple[FastComponent, int, int]]] = [[] for _ in range(BLOCK)]
    fifth = False
    for component in members:
        if component.order == 1:
            turns[component.slot].append((component, state, coefficients))
        else:
            text.lines.append(f"        // ---- {component.name} ----")
            _Component(text, component, state, coefficients).emit()
            fifth = fifth or component.order == 2 or component.layout.increment_shift > 0
        state += _WORD_BYTES * component.order
        coefficients += coefficient_bytes(component)
    model_bytes = coefficients + 4
    _take_turns(text, turns, model_bytes - 1)
    text.group("The compiler wants r1 = 0.", "clr r1")
    used = [*([_FIFTH] if fifth else []), _ZERO, *range(18, 28), 30, 31]
    clobbers = ", ".join(f'"r{r}"' for r in used)
    return FastBlock(tuple(text.lines), clobbers, _rounded_product(), _series_terms(), state_bytes, model_bytes)


def _take_turns(text: AsmText, turns: list[list[tuple[FastComponent, int, int]]], phase: int) -> None:
    """Advance the phase, then the first-order components whose block ends now."""
    text.lines.append("        // ---- first order: whose turn is it ----")
    text.group("", f"lds r18, {_at(phase)}", "inc r18", f"sts {_at(phase)}, r18")
    if not any(turns):
        return
    text.group("", "sbrc r18, 1", "rjmp 3f", "sbrc r18, 0", "rjmp 2f")
    for number, members in enumerate(turns):
        if number == 2:
            text.group("", "3:", "sbrc r18, 0", "rjmp 4f")
        elif number:
            text.group("", f"{number + 1}:")
        for component, state, coefficients in members:
            text.lines.append(f"        // ---- {component.name} ----")
            _block_end(text, state, coefficients)
        if any(turns[number + 1 :]):
            text.group("", "rjmp 9f")
    text.group("", "9:")


def _block_end(text: AsmText, state: int, coefficients: int) -> None:
    """x1 -= y (x1 - S)."""
    d = (22, 23, 24, 25)  # its lowest byte counts as 0
    text.group(
        "d = x1.hi - S, 24 bits",
        *(f"lds r{r}, {_at(state + 2 + j)}" for j, r in enumerate(d[1:])),
        *_bytes(("lds r0, {at}", "{sub} r{v}, r0"), coefficients + 4, d[1:]),
    )
    text.group("a = y", *_load(_A, coefficients))
    b = (26, 27, 30, 31)
    _product(text, d, _A, b, narrow=True)
    text.group("x1 -= product", *_subtract_from(state, b))


class _Component:
    """Emits a component of order 2 to 4."""

    def __init__(self, text: AsmText, component: FastComponent, state: int, coefficients: int) -> None:
        self.text, self.layout, self.order = text, component.layout, component.order
        self.at = [state + _WORD_BYTES * i for i in range(self.order)]
        self.coefficients = coefficients

    def emit(self) -> None:
        """The products, then the chain of additions."""
        p = list(self._products())
        shift = self.layout.increment_shift
        if shift:
            fifth = _FIFTH
            code = [f"mov r{fifth}, r{p[3]}", f"lsl r{fifth}", f"sbc r{fifth}, r{fifth}"]
            for _ in range(shift):
                code += [f"lsl r{p[0]}", *(f"rol r{r}" for r in [*p[1:], fifth])]
            self.text.group(f"-q = product << {shift}", *code)
            p.append(fifth)
        {2: self._chain_2, 3: self._chain_3, 4: self._chain_4}[self.order](p)

    def _products(self) -> Registers:
        """-q before its shift, in four registers."""
        group, narrow = self.text.group, self.layout.narrow
        d: Registers = (21, 22, 23) if narrow else _FIRST
        a: Registers = _A[: len(d)]
        after = self.coefficients + len(d) + 4 * (self.order - 1)
        group(
            f"d = x1.hi - S, {8 * len(d)} bits",
            *(f"lds r{r}, {_at(self.at[0] + _WORD_BYTES - len(d) + j)}" for j, r in enumerate(d)),
            *_bytes(("lds r0, {at}", "{sub} r{v}, r0"), after, d),
        )
        group("a = R0", *_load(a, self.coefficients))
        b: Registers = _FIRST if narrow else _SECOND
        if narrow:
            _narrow_product(self.text, d, a, b)
        else:
            _product(self.text, d, a, b)
        for i in range(1, self.order):
            d, b = b, _SECOND if b is _FIRST else _FIRST
            group(f"d = x{i + 1}.hi + product", *_bytes(("lds r0, {at}", "{add} r{v}, r0"), self.at[i] + 1, d))
            group(f"a = R{i}", *_load(_A, self.coefficients + len(a) + 4 * (i - 1)))
            _product(self.text, d, _A, b)
        return b

    def _chain_2(self, p: Registers) -> None:
        group = self.text.group
        half, z = _A, [*(_FIRST if p[0] == _SECOND[0] else _SECOND), _FIFTH]
        group("-q/2", *(f"mov r{h}, r{r}" for h, r in zip(half, p, strict=True)), *_right(half, 1))
        group(
            "x2 + q/2",
            *_load(z, self.at[1]),
            *_bytes(("{sub} r{v}, r{w}",), 0, z[:4], half),
            f"sbc r{z[4]}, r{_ZERO}",
            f"sbrc r{half[3]}, 7",
            f"inc r{z[4]}",
        )
        self._add_to_first(z[1:], scratch=(18, 19, 20, 21))
        group("x2 += q", *_subtract_from(self.at[1], p))

    def _chain_3(self, p: Registers) -> None:
        y = [18, 19, 20, 21, 22 if p[0] == _FIRST[0] else 24]
        self._increment_last(p, y)
        free = [r for r in (*_FIRST, *_SECOND) if r not in (y[4], 23)]
        z = [*free[:3], 23]
        self.text.group("x2.hi", *_load(z, self.at[1] + 1))
        self._add_to_first(z, scratch=(18, *free[3:]))
        code = [f"lds r0, {_at(self.at[1])}", f"add r0, r{y[1]}", f"sts {_at(self.at[1])}, r0"]
        for j in range(3):
            code += [f"adc r{z[j]}, r{y[j + 2]}", f"sts {_at(self.at[1] + 1 + j)}, r{z[j]}"]
        code += [f"adc r{z[3]}, r{_ZERO}", f"sbrc r{y[4]}, 7", f"dec r{z[3]}", f"sts {_at(self.at[1] + 4)}, r{z[3]}"]
        self.text.group("x2 += x3, shifted", *code)

    def _chain_4(self, p: Registers) -> None:
        group = self.text.group
        v = [18, 19, 20, 21, 24 if p[0] == _SECOND[0] else 22]
        self._increment_last(p, v)
        u = (25, 26, 27, 30)
        code = [f"lds r0, {_at(self.at[2])}", f"add r0, r{v[1]}", f"sts {_at(self.at[2])}, r0"]
        for j, r in enumerate(u):
            code += [f"lds r{r}, {_at(self.at[2] + 1 + j)}", f"mov r0, r{r}"]
            code += [f"adc r0, r{v[j + 2]}"] if j < 3 else [f"adc r0, r{_ZERO}", f"sbrc r{v[4]}, 7", "dec r0"]
            code.append(f"sts {_at(self.at[2] + 1 + j)}, r0")
        group("x3 += x4, shifted; the old x3.hi stays", *code)
        group("the old x3, shifted", *_right(u, self.layout.gaps[1] - RESIDUE_BITS))
        z = (18, 19, 20, 21, 22)
        code = []
        for j, r in enumerate(z):
            code += [f"lds r{r}, {_at(self.at[1] + j)}", f"mov r0, r{r}"]
            if j < 4:
                code.append(f"{'adc' if j else 'add'} r0, r{u[j]}")
            else:
                code += [f"adc r0, r{_ZERO}", f"sbrc r{u[3]}, 7", "dec r0"]
            code.append(f"sts {_at(self.at[1] + j)}, r0")
        group("x2 += x3, shifted; the old x2 stays", *code)
        group(
            "x2 + x3/2",
            *_right(u, 1),
            *_bytes(("{add} r{v}, r{w}",), 0, z[:4], u),
            f"adc r{z[4]}, r{_ZERO}",
            f"sbrc r{u[3]}, 7",
            f"dec r{z[4]}",
        )
        self._add_to_first(z[1:], scratch=(18, 23, 24, 31))

    def _increment_last(self, p: Registers, y: Registers) -> None:
        """x[n] += q; its high word, shifted for x[n-1], stays in y[1:]."""
        at = self.at[-1]
        code = []
        for j in range(4):
            code += [f"lds r{y[j]}, {_at(at + j)}", f"{'sbc' if j else 'sub'} r{y[j]}, r{p[j]}"]
            code.append(f"sts {_at(at + j)}, r{y[j]}")
        code.append(f"lds r{y[4]}, {_at(at + 4)}")
        if len(p) == 5:
            code.append(f"sbc r{y[4]}, r{p[4]}")
        else:
            code += [f"sbc r{y[4]}, r{_ZERO}", f"sbrc r{p[3]}, 7", f"inc r{y[4]}"]
        self.text.group(f"x{self.order} += q", *code, f"sts {_at(at + 4)}, r{y[4]}")
        shift = self.layout.gaps[-1] - RESIDUE_BITS
        if shift:
            self.text.group(f"x{self.order} >> {self.layout.gaps[-1]}", *_right(y[1:], shift))

    def _add_to_first(self, source: Registers, scratch: Registers) -> None:
        """x1 += source >> (gap - 8); the highest byte of source and scratch[0] lie in r16..r23."""
        shift = self.layout.gaps[0] - RESIDUE_BITS
        value = list(source)
        if shift:  # a product by 2^(8 - shift) leaves the bits of each byte in two, which do not overlap
            factor, *low = scratch
            code = [f"ldi r{factor}, {1 << (8 - shift)}"]
            for j in range(4):
                code.append(f"{'mulsu' if j == 3 else 'mul'} r{source[j]}, r{factor}")
                if j:
                    code.append(f"or r{low[j - 1]}, r0")
                if j < 3:
                    code.append(f"mov r{low[j]}, r1")
            self.text.group(f"x2 >> {self.layout.gaps[0]}", *code)
            value = [*low, 1]
        at = self.at[0]
        code = _bytes(("lds r0, {at}", "{add} r0, r{v}", "sts {at}, r0"), at, value)
        code += [f"lds r0, {_at(at + 4)}", f"adc r0, r{_ZERO}", f"sbrc r{value[3]}, 7", "dec r0"]
        self.text.group("x1 += it", *code, f"sts {_at(at + 4)}, r0")


def _product(text: AsmText, d: Registers, a: Registers, b: Registers, *, narrow: bool = False) -> None:
    """b = d * a from bit 32 on (:func:`gen.lowering.fast_format.fast_product`); d is lost."""
    hold = d[0]
    text.group("(1,3)@4 and (3,3)@6, fresh", f"mul r{d[1]}, r{a[3]}", f"movw r{b[0]}, r0")
    text.group("", f"mul r{d[3]}, r{a[3]}", f"movw r{b[2]}, r0")

    def small(i: int, j: int) -> list[str]:
        return [f"mul r{d[i]}, r{a[j]}", f"add r{b[0]}, r1", f"adc r{b[1]}, r{_ZERO}"]

    def high(i: int, j: int) -> list[str]:
        return [f"mul r{d[i]}, r{a[j]}", f"add r{b[1]}, r0", f"adc r{b[2]}, r1", f"adc r{b[3]}, r{_ZERO}"]

    def both(upper: tuple[int, int], lower: tuple[int, int]) -> list[str]:
        return [
            f"mul r{d[upper[0]]}, r{a[upper[1]]}",
            f"movw r{hold}, r0",
            f"mul r{d[lower[0]]}, r{a[lower[1]]}",
            f"add r{b[0]}, r1",
            f"adc r{b[1]}, r{hold}",
            f"adc r{b[2]}, r{hold + 1}",
            f"adc r{b[3]}, r{_ZERO}",
        ]

    if narrow:
        text.group("(1,2), (3,0)@3 by their high bytes: stop at b5", *small(1, 2), *small(3, 0))
        text.group("(2,3)@5, held in the dead d0:d1, with (2,1)@3; (3,2)@5", *both((2, 3), (2, 1)), *high(3, 2))
    else:
        text.group("(0,3), (1,2)@3 by their high bytes: stop at b5", *small(0, 3), *small(1, 2))
        text.group("(2,3)@5, held in the dead d0:d1, with (2,1)@3", *both((2, 3), (2, 1)))
        text.group("(3,2)@5 with (3,0)@3", *both((3, 2), (3, 0)))
    for i, j in ((2, 2), (3, 1)):
        text.group(
            f"({i},{j})@4",
            f"mul r{d[i]}, r{a[j]}",
            f"add r{b[0]}, r0",
            f"adc r{b[1]}, r1",
            f"adc r{b[2]}, r{_ZERO}",
            f"adc r{b[3]}, r{_ZERO}",
        )
    text.group(
        "d < 0: less a",
        f"sbrs r{d[3]}, 7",
        "rjmp 1f",
        *_bytes(("{sub} r{v}, r{w}",), 0, b, a),
        "1:",
    )


def _narrow_product(text: AsmText, d: Registers, a: Registers, b: Registers) -> None:
    """b = d * a from bit 16 on, 24 bits each (:func:`gen.lowering.fast_format.narrow_product`)."""
    text.group("(0,2)@2 and (2,2)@4, fresh", f"mul r{d[0]}, r{a[2]}", f"movw r{b[0]}, r0")
    text.group("", f"mulsu r{d[2]}, r{a[2]}", f"movw r{b[2]}, r0")
    for i, j in ((0, 1), (1, 0)):
        text.group(
            f"({i},{j})@1 by its high byte: stops at b3",
            f"mul r{d[i]}, r{a[j]}",
            f"add r{b[0]}, r1",
            f"adc r{b[1]}, r{_ZERO}",
        )
    at_2 = (f"add r{b[0]}, r0", f"adc r{b[1]}, r1", f"adc r{b[2]}, r{_ZERO}", f"adc r{b[3]}, r{_ZERO}")
    at_3 = (f"add r{b[1]}, r0", f"adc r{b[2]}, r1", f"adc r{b[3]}, r{_ZERO}")
    text.group("(1,1)@2", f"mul r{d[1]}, r{a[1]}", *at_2)
    text.group(
        "(2,0)@2; mulsu leaves the sign in the carry",
        *(f"mulsu r{d[2]}, r{a[0]}", f"sbc r{b[2]}, r{_ZERO}", f"sbc r{b[3]}, r{_ZERO}"),
        *at_2,
    )
    text.group("(1,2)@3", f"mul r{d[1]}, r{a[2]}", *at_3)
    text.group("(2,1)@3", f"mulsu r{d[2]}, r{a[1]}", f"sbc r{b[3]}, r{_ZERO}", *at_3)


def _rounded_product() -> tuple[str, ...]:
    """r22..r25 = r22..r25 * r18..r21 / 2^32 to nearest; exact, byte by byte of d.

    Each byte's products are added to the five bytes that the sum has from there on; the lowest is then complete.
    """
    text = AsmText()
    d, a, c = (22, 23, 24, 25), _A, [26, 27, 30, 31, _FIFTH]
    text.group("", f"clr r{_ZERO}")
    text.group("byte 0", f"mul r{d[0]}, r{a[0]}", f"movw r{c[0]}, r0", f"mul r{d[0]}, r{a[2]}", f"movw r{c[2]}, r0")
    text.group("", f"mul r{d[0]}, r{a[1]}", f"add r{c[1]}, r0", f"adc r{c[2]}, r1", f"adc r{c[3]}, r{_ZERO}")
    text.group("", f"mul r{d[0]}, r{a[3]}", f"mov r{c[4]}, r1", f"add r{c[3]}, r0", f"adc r{c[4]}, r{_ZERO}")
    for i in range(1, 4):
        c = [*c[1:], c[0]]
        text.group(f"byte {i}", f"clr r{c[4]}")
        for j in range(4):
            carries = [f"adc r{r}, r{_ZERO}" for r in c[j + 2 :]]
            text.group("", f"mul r{d[i]}, r{a[j]}", f"add r{c[j]}, r0", f"adc r{c[j + 1]}, r1", *carries)
    text.group(
        "d < 0: less a; then the highest bit below",
        *(f"sbrs r{d[3]}, 7", "rjmp 1f", *_bytes(("{sub} r{v}, r{w}",), 0, c[1:], a), "1:", f"lsl r{c[0]}"),
        *(f"adc r{r}, r{_ZERO}" for r in c[1:]),
        *(f"mov r{target}, r{r}" for target, r in zip(d, c[1:], strict=True)),
        "clr r1",
    )
    return tuple(text.lines)


def _series_terms() -> tuple[str, ...]:
    """r22..r25 = (r20 y + r18 y^2) / 2^8 for y in r22..r25; r19 = 0."""
    text = AsmText()
    zero = 19
    text.group("r30:r31 = square of the upper half of y, its upper half", f"clr r{zero}")
    text.group("", "mul r24, r24", "mov r26, r1", "mul r25, r25", "movw r30, r0", "mul r24, r25")
    text.group("", *("add r26, r0", "adc r30, r1", f"adc r31, r{zero}") * 2)
    text.group("second * (y >> 8) in r26:r27:r22:r23", "mul r23, r20", "movw r26, r0", "mul r25, r20", "movw r22, r0")
    text.group("", "mul r24, r20", "add r27, r0", "adc r22, r1", f"adc r23, r{zero}")
    text.group("third * square", "mul r30, r18", "add r26, r0", "adc r27, r1", f"adc r22, r{zero}", f"adc r23, r{zero}")
    text.group("", "mul r31, r18", "add r27, r0", "adc r22, r1", f"adc r23, r{zero}")
    text.group("its upper three bytes", "mov r24, r23", "mov r23, r22", "mov r22, r27", "clr r25", "clr r1")
    return tuple(text.lines)


def _at(offset: int) -> str:
    return f"%[m]+{offset}"


def _load(registers: Registers, offset: int) -> list[str]:
    return [f"lds r{r}, {_at(offset + j)}" for j, r in enumerate(registers)]


def _bytes(patterns: tuple[str, ...], offset: int, values: Registers, others: Registers | None = None) -> list[str]:
    """Fill the patterns for each byte: at, v, w, and sub/add without the carry at the first."""
    result = []
    for j, v in enumerate(values):
        names = {
            "at": _at(offset + j),
            "v": v,
            "w": others[j] if others is not None else 0,
            "sub": "sbc" if j else "sub",
            "add": "adc" if j else "add",
        }
        result += [pattern.format(**names) for pattern in patterns]
    return result


def _subtract_from(offset: int, p: Registers) -> list[str]:
    """Subtract a signed number of four bytes, or five, from a word in memory."""
    code = _bytes(("lds r0, {at}", "{sub} r0, r{v}", "sts {at}, r0"), offset, p[:4])
    code.append(f"lds r0, {_at(offset + 4)}")
    if len(p) == 5:
        code.append(f"sbc r0, r{p[4]}")
    else:
        code += [f"sbc r0, r{_ZERO}", f"sbrc r{p[3]}, 7", "inc r0"]
    return [*code, f"sts {_at(offset + 4)}, r0"]


def _right(registers: Registers, shift: int) -> list[str]:
    code = []
    for _ in range(shift):
        code += [f"asr r{registers[-1]}", *(f"ror r{r}" for r in reversed(registers[:-1]))]
    return code
