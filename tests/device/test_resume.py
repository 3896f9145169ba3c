"""Going on from kept states: bit for bit as without the interruption."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from gen import toolchain
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from tests.examples import example

MAIN = """
#include <stdio.h>
#include <string.h>
#include "NAME.h"
#include "NAME_model.h"
static uint32_t seed = 1;
static int16_t next_pwm(int sample) {
    static int16_t pwm;
    if (sample == 0) {
        seed = 1;
        pwm = 0;
    }
    seed = seed * 1664525u + 1013904223u;
    if (seed >> 28 == 0) {
        pwm = (int16_t)((int)(seed >> 8) % 256);
    }
    return pwm;
}
static NAME_Model kept[SAMPLES];
int main() {
    NAME_begin();
    for (int i = 0; i < SAMPLES; ++i) {
        NAME_step(next_pwm(i));
        kept[i] = NAME_model;
    }
    for (int cut = 100; cut < SAMPLES; cut += 171) {
        NAME_begin();
        memset(&NAME_model, 0x5A, sizeof NAME_model);
        NAME_begin();
        NAME_model.state = kept[cut].state;
        NAME_resume(kept[cut].command);
        for (int i = 0; i <= cut; ++i) {
            next_pwm(i);
        }
        for (int i = cut + 1; i < SAMPLES && i < cut + 60; ++i) {
            NAME_step(next_pwm(i));
            const bool same = memcmp(&NAME_model.state, &kept[i].state, sizeof kept[i].state) == 0;
            if (!same || NAME_flags() != (kept[i].flags & 0x7F)) {
                printf("differs %d samples after sample %d\\n", i - cut, cut);
                return 1;
            }
        }
    }
    return 0;
}
"""


CASES: list[tuple[str, Arithmetic, ScheduleKind]] = [
    ("my1016", "fixed", "table"),
    ("my1016", "fixed", "onboard"),
    ("my1016", "float", "table"),
    ("my1016", "float", "onboard"),
    ("two_mass", "fixed", "table"),  # orders 2 and 4
]


@pytest.mark.parametrize(("name", "arithmetic", "schedule"), CASES)
def test_the_model_goes_on_bit_for_bit(
    tmp_path: Path, name: str, arithmetic: Arithmetic, schedule: ScheduleKind
) -> None:
    coefficients = example(name)
    context = project_context(coefficients, lower(coefficients, arithmetic, schedule), "coeffs.json")
    sources = []
    for path, text in render.library(context).items():
        target = tmp_path / Path(path).name
        target.write_text(text)
        sources += [str(target)] if target.suffix == ".cpp" else []
    main = tmp_path / "main.cpp"
    main.write_text(MAIN.replace("NAME", name).replace("SAMPLES", "4000"))
    command = [str(toolchain.program("g++")), "-std=gnu++11", "-O1", "-ffp-contract=off", str(main), *sources]
    subprocess.run([*command, "-o", str(tmp_path / "run")], check=True)
    done = subprocess.run([str(tmp_path / "run")], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "")
