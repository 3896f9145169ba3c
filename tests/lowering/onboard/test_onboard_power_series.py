"""Sums of exponentials as polynomials against the exact ones, and the board's Horner rule against exact arithmetic."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen import toolchain
from gen.arrays import IntArray
from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedChip
from gen.firmware.onboard_cpp import five_bytes
from gen.firmware.onboard_shared import schedule_sources
from gen.lowering.onboard import compile_component, tuned
from gen.lowering.onboard.evaluate import RangeError, evaluate
from gen.lowering.onboard.evaluate import power_series as horner
from gen.lowering.onboard.interpolate import largest_sum, power_series
from gen.lowering.onboard.tape import GUARD_BITS
from tests.lowering.onboard import harness
from tests.lowering.onboard.harness import NAME, PWM, write_header
from tests.model.examples import model

INPUTS = range(256)
#: Coefficients of the board's rule, whose sums come near both ends of 40 bits.
TABLES = (
    (2**39 - 129,),
    (-(2**39),),
    (2**38 - 64, 2**38 - 64),
    (-(2**38), -(2**38)),
    (3, -(2**39) + 1, 2**39 - 200),
    (-1, 1, -1, 255, -256, 257, -65537),
    (123456789012, -223456789012, 198765432101, -98765432109, 12345678901, 987654321, -5),
)


@settings(max_examples=30, deadline=None)
@given(
    st.tuples(st.floats(-1.0, 1.0), st.floats(-0.03, 0.03), st.floats(-1.0, 1.0), st.floats(-0.03, 0.03)),
    st.sampled_from((1e-8, 1e-10)),
)
def test_a_power_series_follows_the_exponentials(terms: tuple[float, float, float, float], tolerance: float) -> None:
    a, b, c, d = map(Decimal, terms)

    def exact(x: Decimal) -> Decimal:
        return a * (b * x).exp() + c * (d * x).exp()

    with localcontext() as context:
        context.prec = 50
        series = power_series(exact, INPUTS, tolerance)
        values = [exact(Decimal(x)) for x in INPUTS]
        largest = max(map(abs, values))
        for x, value in zip(INPUTS, values, strict=True):
            allowed = max(Decimal(tolerance) * abs(value), largest / 2**33)
            assert abs(series.sums(Decimal(x))[-1] - value) <= allowed * Decimal("1.000001")


@pytest.mark.parametrize("rate", [0.02, -0.02])
def test_the_sums_on_the_way_stay_below_the_result(rate: float) -> None:
    series = power_series(lambda x: (Decimal(rate) * x).exp(), INPUTS, 1e-10)
    highest = Decimal(max(1.0, float(np.exp(255 * rate))))
    assert largest_sum(series, INPUTS) <= highest * Decimal("1.001")


def exact_horner(table: tuple[int, ...], u: int) -> Fraction:
    total = Fraction(0)
    for coefficient in table:
        total = total * Fraction(u, 256) + coefficient
    return total / Fraction(2**GUARD_BITS)


@pytest.mark.parametrize("table", TABLES)
def test_the_rule_is_within_a_half_and_its_guard_bits(table: tuple[int, ...]) -> None:
    got = horner(table, PWM)
    most = Fraction(1, 2) + Fraction(len(table), 2**GUARD_BITS)
    assert all(abs(int(got[u]) - exact_horner(table, u)) <= most for u in INPUTS)


def test_a_sum_beyond_40_bits_is_noticed() -> None:
    with pytest.raises(RangeError):
        horner((2**39 - 1, 2**39 - 1), PWM)


def test_the_rule_on_the_mega_and_its_twins_equal_the_reference(tmp_path: Path) -> None:
    write_header(tmp_path, "fixed", frozenset({"power_series"}))
    text = f'#include "{NAME}_onboard_math.h"\n'
    calls = []
    for i, table in enumerate(TABLES):
        numbers = ", ".join(five_bytes(c) for c in table)
        text += f"static const uint8_t table{i}[] PROGMEM = {{{numbers}}};\n"
        calls.append(f"    out[{i}] = {NAME}_power_series(table{i}, {len(table)}, u);\n")
    text += "static void run(uint8_t u, int32_t *out) {\n" + "".join(calls) + "}\n"
    (tmp_path / "avr.cpp").write_text(
        f'#include "mailbox.h"\n{text}uint8_t gen_input;\nint32_t gen_output[{len(TABLES)}];\nint main() {{\n'
        "    for (;;) {\n        GEN_MAILBOX_NEXT();\n        run(gen_input, gen_output);\n"
        "        GEN_MAILBOX_DONE();\n    }\n}\n",
        encoding="utf-8",
    )
    (tmp_path / "host.cpp").write_text(
        f"#include <stdio.h>\n{text}int main() {{\n    static int32_t out[{len(TABLES)}];\n"
        "    for (int u = 0; u < 256; ++u) {\n        run((uint8_t)u, out);\n"
        "        fwrite(out, sizeof out, 1, stdout);\n    }\n    return 0;\n}\n",
        encoding="utf-8",
    )
    want = np.stack([horner(table, PWM) for table in TABLES], axis=1)
    elf = build_elf([tmp_path / "avr.cpp"], [MAILBOX_FOLDER, tmp_path], tmp_path / "avr.elf")
    with EmulatedChip(elf, tmp_path) as mega:
        inputs, outputs = mega.memory.address("gen_input"), mega.memory.address("gen_output")
        output, _ = mega.run_records(PWM.astype(np.uint8), inputs, 1, outputs, 4 * len(TABLES), 256, 100_000_000)
    np.testing.assert_array_equal(output.view("<i4").reshape(256, -1), want)
    flags = ["-std=gnu++11", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-fsanitize=undefined"]
    for compiler in ("g++", "clang++"):
        program = [str(toolchain.program(compiler)), *flags, "-o", str(tmp_path / compiler), str(tmp_path / "host.cpp")]
        subprocess.run(program, check=True)
        done = subprocess.run([str(tmp_path / compiler)], capture_output=True, check=True)
        assert done.stderr == b""
        np.testing.assert_array_equal(np.frombuffer(done.stdout, dtype="<i4").reshape(256, -1), want)


def test_components_with_series_of_different_lengths_share_one_body(tmp_path: Path) -> None:
    components = harness.compiled("my1016", "fixed")[1:]
    lengths = {len(s.table) for c in components for s in c.steps if s.op == "power_series"}
    assert len(lengths) > 1  # what the test is about
    assert len(schedule_sources(NAME, components)) == 1
    want = harness.words([evaluate(c, PWM) for c in components])
    np.testing.assert_array_equal(harness.host_words(harness.write(tmp_path, components), "g++", ()), want)


def test_tuning_brings_the_worst_coefficient_nearer() -> None:
    fixed, exact = harness.lowered("my1016")[0], harness.exact("my1016")[0]
    assert fixed.layout is not None
    plain = compile_component(model("my1016"), model("my1016").components[0], "fixed", fixed.layout, fixed.substeps)
    weights = harness.ranges("my1016", 0)[1].distance / exact.c[:, :1]
    place = next(i for i, s in enumerate(plain.steps) if s.op == "power_series")
    table = plain.steps[place].table
    worse = (*table[:-1], table[-1] + 3 * 2**GUARD_BITS)  # three units off
    spoiled = replace(
        plain, steps=(*plain.steps[:place], replace(plain.steps[place], table=worse), *plain.steps[place + 1 :])
    )

    def cost(candidate: IntArray) -> float:
        rates = candidate * 2.0 ** -np.array(fixed.layout.rate_fraction_bits)
        c = np.cumprod(rates[:, ::-1], axis=1)[:, ::-1]  # C[i] = R[i] .. R[n-1]
        return float((weights * np.abs(c - exact.c)).sum(axis=1).max())

    before = cost(evaluate(spoiled, PWM)[0])
    after = cost(evaluate(tuned(spoiled, exact.c, weights), PWM)[0])
    assert after < 0.6 * before
