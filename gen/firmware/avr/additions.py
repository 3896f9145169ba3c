"""The chain of additions, x[i] += x[i+1] shifted, for each order; q's negative is in the last product's registers."""

from __future__ import annotations

from gen.firmware.avr.corrected import add_corrected
from gen.firmware.avr.registers import SPARE, STATE_BYTES, WORD, product_bytes, rows, word_copy
from gen.firmware.avr.text import AsmText
from gen.firmware.avr.words import Shifted, add, add_shifted, load, shift
from gen.lowering.fixed.formats import Format


def additions(text: AsmText, layout: Format, *, walks: bool) -> None:
    """Every state of a component after its increment.

    Parameters
    ----------
    text
        What is written.
    layout
        Formats of the component.
    walks
        Whether the pointer to the state is walked along.
    """
    if layout.order == 1:
        _first_order(text, layout, walks=walks)
    elif layout.order == 2:
        _second_order(text, layout)
    elif layout.corrected:
        add_corrected(text, layout)
    else:
        _higher_order(text, layout)


def _first_order(text: AsmText, layout: Format, *, walks: bool) -> None:
    steps = ("ld r0, Z", "st Z+, r0") if walks else ("ldd r0, Z+{j}", "std Z+{j}, r0")
    text.group("x1 += q", *rows((steps[0], "{sub} r0, r{d}", steps[1]), _product(layout)))


def _second_order(text: AsmText, layout: Format) -> None:
    (between,) = layout.chain_shifts
    load(text, 2, WORD)
    add_shifted(text, 1, 2, between, word_copy(layout.product_shifts[-1]))
    text.group("x2 += q", *rows(("{sub} r{v}, r{d}", "std Z+6+{j}, r{v}"), _product(layout), WORD))
    _add_half(text, _product(layout), between + 1)


def _add_half(text: AsmText, product: list[int], total: int) -> None:
    """x1 += q >> total = -1 - ((product - 1) >> total)."""
    registers = list(product)
    if registers[5] == registers[4]:  # the sign stands for two bytes: make them two
        text.group("", f"mov r{WORD[0]}, r{registers[5]}")
        registers[5] = WORD[0]
    text.group("product - 1", f"clr r{WORD[1]}", "sec", *(f"sbc r{r}, r{WORD[1]}" for r in registers))
    code = ["sec"]
    for j, r in enumerate(shift(text, registers, total).registers):
        code += [f"ldd r0, Z+{j}", f"sbc r0, r{r}", f"std Z+{j}, r0"]
    text.group(f"x1 += q >> {total}: less the product's part, and one", *code)


def _higher_order(text: AsmText, layout: Format) -> None:
    """Orders 3 and 4 in the carried form."""
    n, between = layout.order, layout.chain_shifts
    copy = word_copy(layout.product_shifts[-1])
    if n == 3:
        load(text, 2, WORD)
        add_shifted(text, 1, 2, between[0], copy)
    else:
        load(text, 2, copy)
        add(text, 1, shift(text, copy, between[0]), 2, between[0])
        load(text, 3, WORD)
        add_shifted(text, 2, 3, between[1], copy)
        add_shifted(text, 1, 3, between[0] + between[1] + 1, copy)
    # x[n-1] is still in WORD; x[n] takes over the copy, but for its lowest byte when nothing needs it.
    last = [SPARE, *copy[1:]]
    at = STATE_BYTES * (n - 1)
    text.group(
        f"x{n} += q",
        *(f"ldd r{r}, Z+{at + j}" for j, r in enumerate(last)),
        *rows(("{sub} r{v}, r{d}", f"std Z+{at}+{{j}}, r{{v}}"), _product(layout), last),
    )
    _add_to_word(text, n - 1, shift(text, last, between[-1], extra=16), between[-1])


def _add_to_word(text: AsmText, target: int, value: Shifted, total: int) -> None:
    """x[target], which is in WORD, += value, which is x[target+1] >> total."""
    store = f"std Z+{STATE_BYTES * (target - 1)}+{{j}}, r{{v}}"
    code = rows(("{add} r{v}, r{d}", store), value.registers, WORD)
    text.group(f"x{target} += x{target + 1} >> {total}", *code)


def _product(layout: Format) -> list[int]:
    """Registers of the last product's six bytes."""
    return product_bytes(layout.product_shifts[-1])
