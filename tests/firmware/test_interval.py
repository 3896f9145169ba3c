"""The search for a schedule's interval, compiled as users compile it: optimised, with the compilers that are usual."""

from __future__ import annotations

import subprocess
from bisect import bisect_right
from pathlib import Path

import numpy as np
import pytest

from gen.firmware.onboard_cpp import interval

MOST = 48


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_every_number_of_knots_is_searched_rightly(compiler: str, tmp_path: Path) -> None:
    """g++ 12 at -O2 adds up 8, 16, 20, 24, 32, 40 or 48 comparisons wrongly."""
    rng = np.random.default_rng(12)
    knots = [sorted(rng.choice(np.arange(1, 256), size=count, replace=False).tolist()) for count in range(MOST + 1)]
    functions = "\n".join(
        f"static uint8_t f{count}(uint8_t x) {{ return (uint8_t)({interval('x', k)}); }}"
        if k
        else f"static uint8_t f{count}(uint8_t) {{ return 0; }}"
        for count, k in enumerate(knots)
    )
    calls = "\n".join(f'for (int x = 0; x < 256; ++x) std::printf("%d ", f{i}((uint8_t)x));' for i in range(MOST + 1))
    source = tmp_path / "interval.cpp"
    source.write_text(f"#include <cstdint>\n#include <cstdio>\n{functions}\nint main() {{\n{calls}\n}}\n")
    flags = ["-O2", "-std=gnu++11", "-Wall", "-Wextra", "-Wconversion", "-Werror"]
    subprocess.run([compiler, *flags, source, "-o", tmp_path / "interval"], check=True)
    told = subprocess.run([tmp_path / "interval"], capture_output=True, text=True, check=True).stdout.split()
    assert [int(word) for word in told] == [bisect_right(k, x) for k in knots for x in range(256)]
