"""The float32 firmware against its reference, word for word, on the host and on the emulated Mega; and its cost."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from gen.arrays import IntArray, RecordArray
from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedChip
from gen.coefficients import parse
from gen.lowering.kinds import ScheduleKind
from gen.reference.float32 import accumulated
from gen.templating import environment
from gen.verification.verify import CombinationResult, Target, verify
from tests.examples import ROOT, example

#: Goals of issue 2 for all four MY1016 components together, and an ambient that acts at once.
GOAL_CYCLES, GOAL_RAM = 2_800, 80
GOAL_FLASH = {"table": 10 * 1024, "onboard": 5 * 1024}
#: What a change of PWM costs: an ordinary step, the old q, and handing q/12 over. The goals of 1 300 and 15 000 cycles
#: are out of float's reach: the step alone takes more than the first.
MOST_CHANGE = {"table": 5_300, "onboard": 19_200}
#: What it may cost beside that to let changes of the ambient pass the dynamics: cycles of a change of PWM, flash, RAM.
MOST_OF_AMBIENT = 200, 640, 12

INPUT = np.dtype([("shift", "u1"), ("value", "<f4"), ("lo", "u1"), ("hi", "<i4")])
HARNESS = """
#include "m_accumulator.h"
struct __attribute__((packed)) Input { uint8_t shift; float value; uint8_t lo; int32_t hi; };
Input gen_input;
static void step(Input *one) {
    m_Accumulator sum = {one->lo, one->hi};
    m_add(&sum, one->value, one->shift);
    one->lo = sum.lo;
    one->hi = sum.hi;
}
#ifdef __AVR__
#include "mailbox.h"
int main() {
    for (;;) {
        GEN_MAILBOX_NEXT();
        step(&gen_input);
        GEN_MAILBOX_DONE();
    }
}
#else
#include <stdio.h>
int main() {
    while (fread(&gen_input, sizeof gen_input, 1, stdin) == 1) {
        step(&gen_input);
        fwrite(&gen_input, sizeof gen_input, 1, stdout);
    }
    return 0;
}
#endif
"""


def additions(count: int) -> RecordArray:
    """Sums and values over all byte positions and both signs, with zeros, powers of two and long runs of ones."""
    rng = np.random.default_rng(5)
    records = np.zeros(count, INPUT)
    records["shift"] = rng.integers(0, 42, count)
    exponent = rng.uniform(-30.0, 29.9, count) + records["shift"]
    value = np.exp2(exponent) * rng.choice([-1.0, 1.0], count)
    value[::7] = np.sign(value[::7]) * np.exp2(np.floor(exponent[::7]))
    value[1::7] = np.nextafter(value[::7][: len(value[1::7])].astype(np.float32), np.float32(0.0))
    records["shift"][1::7] = records["shift"][::7][: len(value[1::7])]
    value[2::53] = rng.choice([0.0, -0.0, 1e-38, -1e-44], len(value[2::53]))
    records["value"] = value
    records["hi"] = rng.integers(-(2**30), 2**30, count) >> rng.integers(0, 31, count)
    records["lo"] = rng.choice([0, 1, 127, 128, 255], count)
    return records


def sources(folder: Path) -> list[Path]:
    context = {"name": "m", "NAME": "M", "saturates": False}
    for kind in ("h", "cpp"):
        text = environment("project").get_template(f"lib/model/src/accumulator.{kind}.j2").render(context)
        (folder / f"m_accumulator.{kind}").write_text(text, encoding="utf-8")
    (folder / "harness.cpp").write_text(HARNESS, encoding="utf-8")
    return [folder / "harness.cpp", folder / "m_accumulator.cpp"]


def sums(records: RecordArray) -> IntArray:
    result: IntArray = records["hi"].astype(np.int64) * 256 + records["lo"]
    return result


def test_the_addition_is_the_reference_s_on_host_and_board(tmp_path: Path) -> None:
    records = additions(12_000)
    expected = np.concatenate(
        [accumulated(sums(r), r["value"], int(r["shift"][0])) for r in np.split(records, len(records))]
    )
    flags = ["-std=gnu++11", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off"]
    flags += ["-fsanitize=undefined,address", "-fno-sanitize-recover=all", f"-I{tmp_path}"]
    command = ["g++", *flags, *map(str, sources(tmp_path)), "-o", str(tmp_path / "host")]
    subprocess.run(command, check=True, capture_output=True)
    done = subprocess.run([str(tmp_path / "host")], input=records.tobytes(), capture_output=True, check=True)
    assert np.array_equal(sums(np.frombuffer(done.stdout, INPUT)), expected)
    elf = build_elf(sources(tmp_path), [tmp_path, MAILBOX_FOLDER], tmp_path / "board.elf")
    with EmulatedChip(elf, tmp_path) as mega:
        place = mega.memory.address("gen_input")
        size = INPUT.itemsize
        out, cycles = mega.run_records(records, place, size, place, size, len(records), len(records) * 2_000)
    assert np.array_equal(sums(np.ascontiguousarray(out).reshape(len(records), -1).view(INPUT)[:, 0]), expected)
    print(f"an addition with the harness around it: {cycles.mean():.0f} cycles, at most {cycles.max()}")


@cache
def board(schedule: ScheduleKind, *, at_once: bool) -> CombinationResult:
    tree = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    tree["ambient"]["at_once"] = at_once
    return verify(parse(json.dumps(tree).encode()), ["float"], [schedule], "avr", scale=0.12)[0]


@pytest.mark.parametrize("schedule", ["table", "onboard"])
def test_my1016_meets_its_goals_in_every_step_at_held_pwm(schedule: ScheduleKind) -> None:
    result = board(schedule, at_once=True)
    assert result.passed
    assert result.cost is not None
    print(result.cost)
    assert result.cost.cycles_constant < GOAL_CYCLES
    assert result.cost.ram_bytes < GOAL_RAM
    assert result.cost.flash_bytes < GOAL_FLASH[schedule]
    assert result.cost.cycles_change < MOST_CHANGE[schedule]


@pytest.mark.parametrize("schedule", ["table", "onboard"])
def test_an_ambient_that_moves_costs_little_beside(schedule: ScheduleKind) -> None:
    moving, still = board(schedule, at_once=False), board(schedule, at_once=True)
    assert moving.passed
    assert moving.cost is not None
    assert still.cost is not None
    print(moving.cost)
    assert moving.cost.cycles_constant < GOAL_CYCLES
    cycles, flash, ram = MOST_OF_AMBIENT
    assert moving.cost.cycles_change < still.cost.cycles_change + cycles
    assert moving.cost.flash_bytes < still.cost.flash_bytes + flash
    assert moving.cost.ram_bytes <= still.cost.ram_bytes + ram


Files = dict[str, str]


def replaced(path_end: str, old: str, new: str) -> Callable[[Files], Files]:
    """A fault: some text in one file replaced; the text must be there."""

    def mutate(files: Files) -> Files:
        path = next(path for path in files if path.endswith(path_end))
        assert old in files[path], f"nothing to replace in {path}"
        return files | {path: files[path].replace(old, new, 1)}

    return mutate


FAULTS: dict[str, tuple[Target, Callable[[Files], Files]]] = {
    "lost low bits": ("host", replaced("_accumulator.cpp", "whole & 0xFF", "whole & 0xFE")),
    "wrong shift": ("host", replaced("_step.h", "&state->x[1]), 13)", "&state->x[1]), 12)")),
    "carry forgotten": ("host", replaced("_step.h", "(&state->x[1], carried, 0)", "(&state->x[1], 0.0f, 0)")),
    "lost carry between bytes": ("avr", replaced("_accumulator.cpp", "adc r0, %B[f]", "add r0, %B[f]")),
    "complement without its carry": ("avr", replaced("_accumulator.cpp", "lsl %[sign]", "clc")),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_caught(fault: str) -> None:
    target, mutation = FAULTS[fault]
    result = verify(
        example("my1016"), ["float"], ["table"], target, mutation=mutation, scale=0.04, host_builds=["g++ -O2"]
    )[0]
    assert not result.passed
