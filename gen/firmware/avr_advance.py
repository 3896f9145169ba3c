"""The AVR's recursion as one block of assembly, for every shape that cannot saturate.

One block does the whole sample, so that registers are saved once and the code's speed does not depend on the
compiler's options.  Where a change of PWM needs -q too (the carried form) the block is a function of its own, and the T
flag tells whether to leave after -q; else it stands in the step itself and knows where everything lies.

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

Products are those of :func:`gen.reference.fixed.product`; the order of their byte products is such that no chain of
additions can carry past the byte at which it stops (each byte product is at most 0xFE01).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gen.firmware.asm_text import AsmText
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.corrected_format import FIRST_DROPPED
from gen.lowering.fixed.formats import GAIN_FACTOR, Format, dropped_bytes
from gen.lowering.program import Program

_A = (18, 19, 20, 21)
_D = (22, 23, 24, 25)
_B = {2: 26, 3: 27, 4: 16, 5: 17, 6: 15, 7: 13}
_X, _Y, _SIGN = 14, 12, 11
_COMPONENTS, _RUNS = 10, 9
_WORD = (20, 21, 22, 23, 24, 25)  # a word in the dead a and d
_FILL, _SPARE = 12, 14  # bytes above a shifted word
_BYTES = 6
_ONE_BYTE = 256


@dataclass(frozen=True)
class Block:
    """What the templates print.

    Attributes
    ----------
    lines
        The assembly, as lines of a C++ string with comments.
    clobbers
        Registers that it changes besides its operands.
    first
        Place of the shape at which its pointers start, "" if there is no shape to advance.
    tasks
        What to ask for, by the identifier of each shape of order 2 and more.
    """

    lines: tuple[str, ...]
    clobbers: str
    first: str
    tasks: dict[str, int]


def block(program: Program) -> Block:
    """The block of a program.

    Parameters
    ----------
    program
        What is emitted; its shapes lie in the board's state in their order.
    """
    name = program.model.name.upper()
    text, after = AsmText(name), AsmText(name)
    shapes = [
        (shape, component)
        for shape in program.shapes
        if isinstance(component := program.components[shape.members[0]], FixedComponent)
    ]
    kept = [number for number, (_, component) in enumerate(shapes) if not component.saturates]
    carried = [number for number in kept if shapes[number][1].carries]
    tasks = {shapes[number][0].identifier: 2 * index + 1 for index, number in enumerate(carried)}
    text.group("", "push r28", "push r29")
    if carried:
        text.group("Y: coefficients; T: whether to leave after q.", "movw r28, r26")
        text.group("", "bst r20, 0", "brtc 1f", "rjmp 6f", "1:")
    else:
        text.group("Z: state; Y: coefficients.", *_load_pointer(30, "%[state]"), *_load_pointer(28, "%[now]"))
    skipped = [0, 0]  # bytes of state and coefficients
    passed = 0  # bytes of state
    for number in range(kept[0] if kept else 0, kept[-1] + 1 if kept else 0):
        shape, component = shapes[number]
        order, count = component.order, len(shape.members)
        passed += _BYTES * order * count
        if component.saturates:
            skipped[0] += _BYTES * order * count
            skipped[1] += 4 * (order + 1) * count
            continue
        if any(skipped):
            text.group("Past what saturates.", *_step_pointer(30, skipped[0]), *_step_pointer(28, skipped[1]))
            skipped = [0, 0]
        names = ", ".join(program.components[member].name for member in shape.members)
        text.lines.append(f"        // ---- {names} ----")
        emitter = _Shape(text, shape.identifier, component.layout, count, component.substeps, last=number == kept[-1])
        if not carried and _BYTES * order * count <= _ONE_BYTE:
            emitter.end = f"%[state]+{passed}"
        emitter.emit(carried=number in carried)
        if number in carried:
            emitter.leave(after)
    if carried:
        text.group("", "rjmp 9f")
        text.lines.append("        // ---- q for a change of PWM ----")
        text.lines.append("        // q of the shape that is asked for.")
        text.group("", "6:")
        for number in reversed(carried[1:]):
            identifier = shapes[number][0].identifier
            text.group("", f"cpi r20, {tasks[identifier]}", "brlo 1f", f"rjmp .Lq{identifier}%=", "1:")
        text.group("", f"rjmp .Lq{shapes[carried[0]][0].identifier}%=")
        text.lines += after.lines
    text.group("The compiler wants r1 = 0.", "9:", "pop r29", "pop r28", "clr r1")
    used = [0, 1, 11, 12, 13, 14, 15, 16, 17, 18, 19, 21]
    if not carried:  # else they are operands
        used += [20, 22, 23, 24, 25, 26, 27, 30, 31]
    if any("mov r10," in line for line in text.lines):
        used.append(_COMPONENTS)
    if any(shapes[number][1].substeps > 1 for number in kept):
        used.append(_RUNS)
    clobbers = ", ".join(f'"r{register}"' for register in sorted(used))
    return Block(tuple(text.lines), clobbers, shapes[kept[0]][0].place if kept else "", tasks)


class _Shape:
    """Emits one shape's part."""

    def __init__(self, text: AsmText, name: str, layout: Format, count: int, runs: int, *, last: bool) -> None:
        self.text, self.name, self.layout, self.count, self.runs, self.last = text, name, layout, count, runs, last
        self.order = layout.order
        #: Where Z is after the last component, where that is known: its lowest byte tells whether another one is left.
        self.end = ""
        # Another word; the product's bytes leave r26 or r11 free.
        self.copy = (12, 11 if layout.product_shifts[-1] == 16 else 26, 18, 19, 0, 1)
        # Order 1 walks its pointers along as it goes.
        self.walks = self.order == 1 and runs == 1 and (count > 1 or not last)

    def emit(self, *, carried: bool) -> None:
        """The increment and the chain of additions, for each component and run."""
        group = self.text.group
        if self.count > 1:
            counter = [] if self.end else [f"ldi r18, {self.count}", f"mov r{_COMPONENTS}, r18"]
            group("Each component.", *counter, f".Lc{self.name}%=:")
        if self.runs > 1:
            group("Each run.", f"ldi r18, {self.runs}", f"mov r{_RUNS}, r18", f".Lr{self.name}%=:")
        self._increment()
        if carried:
            group("T: only q was wanted.", "brtc 1f", f"rjmp .Lt{self.name}%=", "1:")
        self._chain()
        if self.runs > 1:
            group("", f"dec r{_RUNS}", "breq 1f", f"rjmp .Lr{self.name}%=", "1:")
        if not self.walks and (self.count > 1 or not self.last):
            group("The next component.", f"adiw r30, {_BYTES * self.order}", f"adiw r28, {4 * self.order + 4}")
        if self.count > 1:
            done = f"cpi r30, lo8({self.end})" if self.end else f"dec r{_COMPONENTS}"
            group("", done, "breq 1f", f"rjmp .Lc{self.name}%=", "1:")

    def _increment(self) -> None:
        """The product whose negative is q, in b2..b7 and the sign."""
        group, n = self.text.group, self.order
        if self.walks:
            group("a = R0", *(f"ld r{a}, Y+" for a in _A))
            group(
                "d = x1.hi - S",
                *(f"ldd r{d}, Z+{2 + j}" for j, d in enumerate(_D)),
                *_rows(("ld r0, Y+", "{sub} r{d}, r0"), _D),
            )
        else:
            if n > 1:
                group("", f".Lq{self.name}%=:")
            group(
                "d = x1.hi - S",
                *(f"ldd r{d}, Z+{2 + j}" for j, d in enumerate(_D)),
                *_rows((f"ldd r0, Y+{4 * n}+{{j}}", "{sub} r{d}, r0"), _D),
            )
            group("a = R0", *(f"ldd r{a}, Y+{j}" for j, a in enumerate(_A)))
        shifts = self.layout.product_shifts
        for i, k in enumerate(shifts):
            wide = i == n - 1
            first = self.layout.corrected and i == 0
            _multiply(self.text, FIRST_DROPPED if first else dropped_bytes(k, wide=wide), k, wide=wide, zero=i > 0)
            if not wide:
                taken = _product_bytes(k)
                plain = self.layout.corrected
                code = [] if plain else ["sec"]
                for j, d in enumerate(_D):
                    add = "add" if plain and j == 0 else "adc"
                    code += [f"ldd r{d}, Z+{_BYTES * (i + 1) + 2 + j}", f"{add} r{d}, r{taken[j]}"]
                extra = "" if plain else " + 1 (half of what two roundings down lose)"
                group(f"d = x{i + 2}.hi + product{extra}", *code)
                group(f"a = R{i + 1}", *(f"ldd r{a}, Y+{4 * (i + 1) + j}" for j, a in enumerate(_A)))

    def _chain(self) -> None:
        group, n, shift = self.text.group, self.order, self.layout.chain_shifts
        product = self._q()
        if n == 1:
            if self.walks:
                group("x1 += q", *_rows(("ld r0, Z", "{sub} r0, r{d}", "st Z+, r0"), product))
            else:
                group("x1 += q", *_rows(("ldd r0, Z+{j}", "{sub} r0, r{d}", "std Z+{j}, r0"), product))
            return
        if n == 2:
            self._load(2, _WORD)
            self._add_shifted(1, 2, shift[0])
            group("x2 += q", *_rows(("{sub} r{v}, r{d}", "std Z+6+{j}, r{v}"), product, _WORD))
            self._half(product, shift[0] + 1)
            return
        if self.layout.corrected:
            self._corrected_chain()
            return
        if n == 3:
            self._load(2, _WORD)
            self._add_shifted(1, 2, shift[0])
        else:
            self._load(2, self.copy)
            self._add(1, *self._shifted(list(self.copy), shift[0]), 2, shift[0])
            self._load(3, _WORD)
            self._add_shifted(2, 3, shift[1])
            self._add_shifted(1, 3, shift[0] + shift[1] + 1)
        # x[n-1] is still in _WORD; x[n] takes over the copy, but for its lowest byte when nothing needs it.
        regs = [_SPARE, *self.copy[1:]]
        group(
            f"x{n} += q",
            *(f"ldd r{r}, Z+{_BYTES * (n - 1) + j}" for j, r in enumerate(regs)),
            *_rows(("{sub} r{v}, r{d}", f"std Z+{_BYTES * (n - 1)}+{{j}}, r{{v}}"), product, regs),
        )
        whole, fill, _ = self._shifted(regs, shift[-1], extra=16)
        values = [whole[j] if j < len(whole) else fill for j in range(_BYTES)]
        group(
            f"x{n - 1} += x{n} >> {shift[-1]}",
            *_rows(("{add} r{v}, r{d}", f"std Z+{_BYTES * (n - 2)}+{{j}}, r{{v}}"), values, _WORD),
        )

    def _corrected_chain(self) -> None:
        """Those of :mod:`gen.lowering.fixed.correction`; -q is in r27, r16, r17, r15, r13 and sign, R2 still in a."""
        group, shift = self.text.group, self.layout.chain_shifts
        gain, last = 21, (26, 27, 14, 18, 19)
        group("r21: 4/3 of R2's uppermost byte", f"ldi r22, {GAIN_FACTOR}", "fmul r21, r22", f"mov r{gain}, r1")
        code = ["ldd r0, Z+12", "sub r0, r27", "std Z+12, r0"]
        for j, (r, q) in enumerate(zip(last, (16, 17, 15, 13, _SIGN), strict=True)):
            code += [f"ldd r{r}, Z+{13 + j}", f"sbc r{r}, r{q}", f"std Z+{13 + j}, r{r}"]
        group("x3 += q; its bytes 1 to 5 stay in r26, r27, r14, r18, r19", *code)
        cut = self.layout.first_rate_cut
        shorten = (["swap r17", "andi r17, 15"] if cut >= 4 else []) + ["lsr r17"] * (cut % 4)
        group(
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
        group(
            "r16:r17 = that times R1's byte",
            "ldd r20, Y+7",
            "mulsu r23, r20",
            "movw r16, r0",
            "mul r22, r20",
            f"clr r{_SIGN}",
            "add r16, r1",
            f"adc r17, r{_SIGN}",
        )
        group("and 2 q: the change of q", "lsl r15", "rol r13", "sub r16, r15", "sbc r17, r13")
        group(
            "d in r24:r25 and its sign r22 = that times r21, >> 7",
            f"mulsu r17, r{gain}",
            "sbc r22, r22",
            "movw r24, r0",
            f"mul r16, r{gain}",
            "add r24, r1",
            f"adc r25, r{_SIGN}",
            f"adc r22, r{_SIGN}",
            "lsl r0",
            "rol r24",
            "rol r25",
        )
        whole, fill, _ = self._shifted([_SPARE, *last], shift[1], extra=16)
        values = [*whole, *[fill] * (_BYTES - len(whole))]
        group(f"x3 >> {shift[1]} and d", *_rows(("{add} r{v}, r{d}",), (24, 25, 22, 22, 22, 22), values))
        self._load(2, _WORD)
        copy = [11, 15, 16, 17, 0, 1]
        skipped = min(shift[0] // 8, _BYTES - 1)
        self.text.group("x2 again", *_copy(copy[skipped:], _WORD[skipped:]))
        self._add(1, *self._shifted(copy, shift[0], fill=_SIGN, extra=13), 2, shift[0])
        group(f"x2 += x3 >> {shift[1]} and d", *_rows(("{add} r{v}, r{d}", "std Z+6+{j}, r{v}"), values, _WORD))

    def _q(self) -> list[int]:
        """Registers of the last product's six bytes."""
        return _product_bytes(self.layout.product_shifts[-1])

    def _load(self, number: int, regs: Sequence[int]) -> None:
        self.text.group(f"x{number}", *(f"ldd r{r}, Z+{_BYTES * (number - 1) + j}" for j, r in enumerate(regs)))

    def _add_shifted(self, target: int, source: int, total: int) -> None:
        """x[target] += x[source] >> total, with x[source] in _WORD and kept."""
        whole = min(total // 8, _BYTES - 1)
        self.text.group(f"x{source} again", *_copy(self.copy[whole:], _WORD[whole:]))
        self._add(target, *self._shifted(list(self.copy), total), source, total)

    def _add(self, target: int, value: list[int], fill: int, free: int, source: int, total: int) -> None:
        self.text.group(f"x{target} += x{source} >> {total}", *self._sum(target, value, fill, free))

    @staticmethod
    def _sum(target: int, value: list[int], fill: int, free: int) -> list[str]:
        at = _BYTES * (target - 1)
        values = [value[j] if j < len(value) else fill for j in range(_BYTES)]
        return _rows((f"ldd r{free}, Z+{at}+{{j}}", f"{{add}} r{free}, r{{d}}", f"std Z+{at}+{{j}}, r{free}"), values)

    def _shifted(
        self, regs: list[int], total: int, *, extra: int = _SPARE, fill: int = _FILL
    ) -> tuple[list[int], int, int]:
        """Shift a word right in place: its bytes, the sign above them, and a register that is free.

        Bits are shifted to the right, or to the left beyond the byte above when that is shorter.
        """
        whole, bits = divmod(total, 8)
        top = regs[-1]
        sign = [f"mov r{fill}, r{top}", f"lsl r{fill}", f"sbc r{fill}, r{fill}"]
        if whole >= _BYTES:
            self.text.group("sign", *sign)
            return [], fill, extra
        rest = regs[whole:]
        if whole and bits > 4:
            code = [*sign, f"mov r{extra}, r{fill}"]
            for _ in range(8 - bits):
                code += [f"lsl r{rest[0]}", *(f"rol r{r}" for r in [*rest[1:], extra])]
            self.text.group(f">> {total}", *code)
            return [*rest[1:], extra], fill, rest[0]
        code = []
        for _ in range(bits):
            code += [f"asr r{rest[-1]}", *(f"ror r{r}" for r in reversed(rest[:-1]))]
        if whole:
            code += [f"mov r{fill}, r{rest[-1]}", *sign[1:]]
        if code:
            self.text.group(f">> {total}", *code)
        return rest, fill, extra

    def _half(self, product: list[int], total: int) -> None:
        """x1 += q >> total = -1 - ((product - 1) >> total)."""
        regs = list(product)
        if regs[5] == regs[4]:  # the sign stands for two bytes: make them two
            self.text.group("", f"mov r{_WORD[0]}, r{regs[5]}")
            regs[5] = _WORD[0]
        self.text.group(
            "product - 1",
            f"clr r{_WORD[1]}",
            "sec",
            *(f"sbc r{r}, r{_WORD[1]}" for r in regs),
        )
        value, fill, _ = self._shifted(regs, total)
        values = [value[j] if j < len(value) else fill for j in range(_BYTES)]
        code = ["sec"]
        for j, r in enumerate(values):
            code += [f"ldd r0, Z+{j}", f"sbc r0, r{r}", f"std Z+{j}, r0"]
        self.text.group(f"x1 += q >> {total}: less the product's part, and one", *code)

    def leave(self, text: AsmText) -> None:
        """Give back what a change of PWM needs of the product."""
        first = self.layout.carry_byte
        taken = self._q()[first : first + 4]
        text.group(
            "The result.", f".Lt{self.name}%=:", *(f"mov r{d}, r{r}" for d, r in zip(_D, taken, strict=True)), "rjmp 9f"
        )


def _multiply(text: AsmText, dropped: int, k: int, *, wide: bool, zero: bool) -> None:
    """b2..b7 and, if wide, the sign = a * d; ``zero`` if the sign's register is 0 already."""
    text.lines.append(f"        // product, from bit {k} on")
    if not zero:
        text.group("", f"clr r{_SIGN}")
    text.lines.append(f"        {text.prefix}_PRODUCT_{dropped * (dropped + 1) // 2}")
    needed = 4 if wide else k // 8
    code = [f"sub r{_B[4]}, r18", f"sbc r{_B[5]}, r19"]
    if needed > 2:
        code.append(f"sbc r{_B[6]}, r20")
    if needed > 3:
        code.append(f"sbc r{_B[7]}, r21")
    if wide and k > 16:
        code.append(f"sbc r{_SIGN}, r{_SIGN}")
    text.group("d < 0: less a * 2^32", "sbrs r25, 7", "rjmp 1f", *code, "1:")


def _product_bytes(k: int) -> list[int]:
    """Registers of the bytes from bit k on, as many as six."""
    regs = [_B[j] for j in range(k // 8, 8)]
    return regs + [_SIGN] * (_BYTES - len(regs))


def _rows(patterns: tuple[str, ...], data: Sequence[int], values: Sequence[int] | None = None) -> list[str]:
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


def _copy(target: Sequence[int], source: Sequence[int]) -> list[str]:
    """Move bytes, pairs at once where both are aligned."""
    code, j = [], 0
    while j < len(target):
        pair = j + 1 < len(target) and target[j] % 2 == source[j] % 2 == 0
        pair = pair and target[j + 1] == target[j] + 1 and source[j + 1] == source[j] + 1
        code.append(f"{'movw' if pair else 'mov'} r{target[j]}, r{source[j]}")
        j += 2 if pair else 1
    return code


def _load_pointer(register: int, address: str) -> list[str]:
    return [f"ldi r{register}, lo8({address})", f"ldi r{register + 1}, hi8({address})"]


def _step_pointer(register: int, distance: int) -> list[str]:
    return [f"subi r{register}, lo8({-distance})", f"sbci r{register + 1}, hi8({-distance})"]
