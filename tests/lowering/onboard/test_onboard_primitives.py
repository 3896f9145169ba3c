"""Products, quotients and exponentials: the reference against exact arithmetic, and the board against the reference."""

from __future__ import annotations

import subprocess
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen import toolchain
from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedChip
from gen.lowering.onboard.evaluate import divide, mul_byte, mul_shift, wrapped
from gen.lowering.onboard.graph import exponential_factors
from tests.lowering.onboard.harness import NAME, write_header

SIGNED = st.integers(-(2**31) + 1, 2**31 - 1)
CORNERS = [0, 1, 2, 127, 128, 255, 256, 65535, 65536, 0xFFFFFF, 0x1000000, 0x7FFFFFFE, 0x7FFFFFFF]


def one(value: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    return np.array([value], dtype=np.int64)


@given(SIGNED, st.integers(0, 2**32 - 1), st.integers(0, 7))
def test_a_product_is_within_a_half_and_what_it_leaves_out(a: int, b: int, shift: int) -> None:
    exact = Fraction(a * b, 2 ** (32 - shift))
    assert abs(int(mul_shift(one(a), one(b), shift)[0]) - exact) <= Fraction(1, 2) + Fraction(2**16, 2 ** (32 - shift))


@given(SIGNED, st.integers(0, 255), st.integers(0, 8))
def test_a_product_with_a_byte_is_within_a_half(a: int, x: int, shift: int) -> None:
    exact = Fraction(a * x, 2 ** (8 - shift))
    assert abs(int(mul_byte(one(a), one(x), shift)[0]) - exact) <= Fraction(1, 2)


@given(SIGNED, st.integers(1, 2**32 - 1), st.integers(24, 40))
def test_a_quotient_is_within_a_half_or_truncated(a: int, b: int, shift: int) -> None:
    exact = Fraction(a * 2**shift, b)
    if abs(exact) >= 2**31 - 1:
        return
    assert abs(int(divide(one(a), one(b), shift, rounded=True)[0]) - exact) <= Fraction(1, 2)
    assert int(divide(one(a), one(b), shift, rounded=False)[0]) == int(exact)


@settings(max_examples=50)
@given(st.floats(-0.05, 0.05), st.integers(0, 255))
def test_exponential_factors_multiply_to_the_exponential(b: float, x: int) -> None:
    high, low = exponential_factors(Decimal(3), Decimal(b))
    with localcontext() as context:
        context.prec = 60
        exact = 3 * (Decimal(b) * x).exp()
        assert abs(high[x >> 4] * low[x & 15] / exact - 1) < Decimal("1e-37")


INPUT = np.dtype([("a", "<i4"), ("b", "<u4"), ("shift", "u1"), ("x", "u1")])
BODY = f"""
struct Input {{ int32_t a; uint32_t b; uint8_t shift; uint8_t x; }} __attribute__((packed));
struct Output {{ int32_t product, times, quotient, down; }};
static void run(const Input &in, Output &out) {{
    out.product = {NAME}_mul_shift(in.a, in.b, in.shift);
    // Only products that fit: the shift is limited to what the operands leave.
    uint8_t room = 0;
    const uint32_t size = in.a < 0 ? 0u - (uint32_t)in.a : (uint32_t)in.a;
    while (room < 8 && (size >> (30 - room)) == 0) {{ ++room; }}
    out.times = {NAME}_times(in.a, in.x, in.shift < room ? in.shift : room);
    const uint32_t divisor = in.b | 0x40000000u;
    out.quotient = {NAME}_divide_signed(in.a / 4, divisor, (uint8_t)(in.shift % 8), (in.x & 1) != 0);
    out.down = {NAME}_round_shift(in.a / 2, (uint8_t)(in.x % 31));
}}
"""


def expected(records: np.ndarray[tuple[int], np.dtype[np.void]]) -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
    a, b = records["a"].astype(np.int64), records["b"].astype(np.int64)
    shift, x = records["shift"].astype(np.int64), records["x"].astype(np.int64)
    rows = []
    for i in range(len(records)):
        size, room = abs(int(a[i])), 0
        while room < 8 and size >> (30 - room) == 0:
            room += 1
        quarter = int(a[i] / 4)
        half = one(int(a[i] / 2))
        rows.append(
            [
                int(wrapped(mul_shift(a[i : i + 1], b[i : i + 1], int(shift[i])))[0]),
                int(mul_byte(a[i : i + 1], x[i : i + 1], min(int(shift[i]), room))[0]),
                int(
                    divide(one(quarter), one(int(b[i]) | 0x40000000), 24 + int(shift[i]) % 8, rounded=bool(x[i] & 1))[0]
                ),
                int((((half >> int(x[i]) % 31) + 1) >> 1)[0]),
            ]
        )
    return np.array(rows)


@pytest.fixture(scope="module")
def records() -> np.ndarray[tuple[int], np.dtype[np.void]]:
    generator = np.random.default_rng(7)
    signed = [sign * c for c in CORNERS for sign in (1, -1)]
    unsigned = [*CORNERS, 0x80000000, 0xFFFFFFFF, 0xFF00FF00, 0x00FF00FF]
    crossed = [(a, b, int(generator.integers(8)), int(generator.integers(256))) for a in signed for b in unsigned]
    random = [
        (
            int(generator.integers(-(2**31) + 1, 2**31)),
            int(generator.integers(2**32)),
            i % 8,
            int(generator.integers(256)),
        )
        for i in range(2000)
    ]
    return np.array(crossed + random, dtype=INPUT)


def test_primitives_on_the_mega_and_their_twins_equal_the_reference(
    tmp_path: Path, records: np.ndarray[tuple[int], np.dtype[np.void]]
) -> None:
    write_header(tmp_path, "fixed", frozenset({"mul", "times", "div", "div_signed", "shr"}))
    text = f'#include "{NAME}_onboard_math.h"\n{BODY}'
    (tmp_path / "avr.cpp").write_text(
        f'#include "mailbox.h"\n{text}Input gen_input;\nOutput gen_output;\nint main() {{\n    for (;;) {{\n'
        "        GEN_MAILBOX_NEXT();\n        run(gen_input, gen_output);\n        GEN_MAILBOX_DONE();\n    }\n}\n",
        encoding="utf-8",
    )
    elf = build_elf([tmp_path / "avr.cpp"], [MAILBOX_FOLDER, tmp_path], tmp_path / "avr.elf")
    with EmulatedChip(elf, tmp_path) as mega:
        addresses = mega.memory.address("gen_input"), mega.memory.address("gen_output")
        output, _ = mega.run_records(records, addresses[0], INPUT.itemsize, addresses[1], 16, len(records), 500_000_000)
    want = expected(records)
    np.testing.assert_array_equal(output.view("<i4"), want)
    (tmp_path / "host.cpp").write_text(
        f"#include <stdio.h>\n{text}int main() {{\n    Input in;\n    Output out;\n"
        "    while (fread(&in, sizeof in, 1, stdin) == 1) {\n        run(in, out);\n"
        "        fwrite(&out, sizeof out, 1, stdout);\n    }\n    return 0;\n}\n",
        encoding="utf-8",
    )
    flags = ["-std=gnu++11", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-fsanitize=undefined"]
    for compiler in ("g++", "clang++"):
        program = tmp_path / compiler
        subprocess.run(
            [str(toolchain.program(compiler)), *flags, "-o", str(program), str(tmp_path / "host.cpp")], check=True
        )
        done = subprocess.run([str(program)], input=records.tobytes(), capture_output=True, check=True)
        assert done.stderr == b""
        np.testing.assert_array_equal(np.frombuffer(done.stdout, dtype="<i4").reshape(-1, 4), want)
