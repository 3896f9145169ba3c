"""The emitted products of a signed by an unsigned word, as this computer computes them, against the reference."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from gen import toolchain
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.lower import lower
from gen.reference.fixed import product
from tests.examples import example

#: The result's least bit -> its function.
HIGH = {16: "my1016_high16", 24: "my1016_high24", 32: "my1016_high32"}
MAIN = """
#include <stdio.h>
#include "my1016_word.h"
int main() {{
    long d;
    unsigned long a;
    while (scanf("%ld %lu", &d, &a) == 2) {{
        printf("%ld\\n", (long){name}((int32_t)d, (uint32_t)a));
    }}
    return 0;
}}
"""


@pytest.mark.parametrize("shift", sorted(HIGH))
def test_a_high_word_is_the_reference_s(shift: int, tmp_path: Path) -> None:
    coefficients = example("my1016")
    program = lower(coefficients, "fixed", "table")
    for path, text in render.library(project_context(coefficients, program, "coeffs.json")).items():
        if path.endswith(".h"):
            (tmp_path / Path(path).name).write_text(text, encoding="utf-8")
    (tmp_path / "main.cpp").write_text(MAIN.format(name=HIGH[shift]), encoding="utf-8")
    compiler = str(toolchain.program("g++"))
    built = [compiler, "-std=gnu++11", f"-I{tmp_path}", str(tmp_path / "main.cpp"), "-o", str(tmp_path / "main")]
    subprocess.run(built, check=True)
    random = np.random.default_rng(shift)
    d = [-1, 0, 1, 255, -256, *random.integers(-(2**31), 2**31, 300).tolist()]
    most = 2 ** min(shift, 32) - 1  # so that the result has 32 bits
    a = [1, most, most, most, most, *random.integers(0, most, 300, endpoint=True).tolist()]
    given = "".join(f"{one} {other}\n" for one, other in zip(d, a, strict=True))
    said = subprocess.run([str(tmp_path / "main")], input=given, capture_output=True, text=True, check=True).stdout
    want = [int(product(one, other, shift, wide=False)) for one, other in zip(d, a, strict=True)]
    assert [int(line) for line in said.split()] == want
