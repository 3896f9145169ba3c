"""Lines of assembly against a machine of registers of its own."""

from __future__ import annotations

import re

import pytest

from gen.firmware.avr.registers import moves


@pytest.mark.parametrize(
    ("target", "source", "lines"),
    [
        ((20, 21, 22, 23), (12, 13, 14, 15), 2),
        ((20, 21, 22, 23, 24), (12, 13, 14, 15, 16), 3),
        ((21, 22, 23), (12, 13, 14), 3),
        ((20, 21, 22), (13, 14, 15), 3),
        ((20, 21, 24, 25), (12, 14, 16, 17), 3),
        ((12,), (30,), 1),
        ((), (), 0),
    ],
)
def test_bytes_are_copied_two_at_once_where_the_chip_can(
    target: tuple[int, ...], source: tuple[int, ...], lines: int
) -> None:
    """`movw` copies an even register and the one above it, `mov` one (the AVR's instruction set manual)."""
    code = moves(target, source)
    assert len(code) == lines
    held = {register: f"byte {register}" for register in range(32)}
    for line in code:
        found = re.fullmatch(r"(movw?) r(\d+), r(\d+)", line)
        assert found
        to, by = int(found[2]), int(found[3])
        held[to] = held[by]
        if found[1] == "movw":
            assert to % 2 == by % 2 == 0
            held[to + 1] = held[by + 1]
    assert [held[register] for register in target] == [f"byte {register}" for register in source]
