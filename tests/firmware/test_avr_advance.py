"""The assembly on the emulated board against the reference, word for word, and how long it takes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from gen.arrays import IntArray, RecordArray
from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedChip
from gen.coefficients import load
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.kinds import ScheduleKind
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.reference.fixed import FixedStep

EXAMPLES = Path(__file__).parents[2] / "examples"
STEPS = 3000
RECORD = np.dtype([("start", "u1"), ("pwm", "<i2"), ("rise", "<i4")])
WORD = np.dtype([("lo", "<u2"), ("hi", "<i4")])
MAIN = """#include "mailbox.h"
#include <avr/interrupt.h>
#include "{name}.h"
#include "{name}_model.h"
struct Input {{ uint8_t start; int16_t pwm; int32_t rise; }};
Input input;
int main() {{
    cli();
    {name}_begin();
    for (;;) {{
        GEN_MAILBOX_NEXT();
        if (input.start) {{
            for (uint8_t i = 0; i < {NAME}_COMPONENTS; ++i) {name}_start(i, input.rise);
        }}
        {name}_step(input.pwm);
        GEN_MAILBOX_DONE();
    }}
}}
"""


@dataclass(frozen=True)
class Run:
    words: IntArray
    cycles: IntArray


def inputs() -> RecordArray:
    rng = np.random.default_rng(7)
    records = np.zeros(STEPS, RECORD)
    third = STEPS // 3
    records["pwm"][:third] = rng.integers(-255, 256, third)
    records["pwm"][third : 2 * third] = np.repeat(rng.integers(-255, 256, third // 20), 20)
    records["pwm"][2 * third :] = np.where(np.arange(third) // 3 % 2, 255, 0)
    records["start"][::250] = 1
    records["rise"][::250] = rng.integers(-90_000, 250_000, len(records["rise"][::250]))
    return records


@cache
def program(example: str, schedule: ScheduleKind = "table") -> Program:
    return lower(load(EXAMPLES / example / "coeffs.json"), "fixed", schedule)


def board(example: str, records: RecordArray, folder: Path, schedule: ScheduleKind = "table") -> Run:
    coefficients, lowered = load(EXAMPLES / example / "coeffs.json"), program(example, schedule)
    name = coefficients.name
    sources = []
    for path, content in render.library(project_context(coefficients, lowered, "coeffs.json")).items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content, encoding="utf-8")
        if file.suffix == ".cpp":
            sources.append(file)
    main = folder / "main.cpp"
    main.write_text(MAIN.format(name=name, NAME=name.upper()), encoding="utf-8")
    elf = build_elf([main, *sources], [MAILBOX_FOLDER, sources[0].parent], folder / "test.elf")
    words = sum(component.order for component in lowered.components)
    with EmulatedChip(elf, folder / "cache") as mega:
        out, cycles = mega.run_records(
            records,
            mega.memory.address("input"),
            RECORD.itemsize,
            mega.memory.address(f"{name}_model"),
            words * WORD.itemsize,
            len(records),
            10**9,
        )
    state = np.ascontiguousarray(out).reshape(len(records), -1).view(np.uint8).view(WORD).reshape(len(records), words)
    return Run(state["hi"].astype(np.int64) * 65536 + state["lo"], np.asarray(cycles, dtype=np.int64))


def reference(lowered: Program, records: RecordArray) -> IntArray:
    columns = []
    low, high = lowered.model.domain_pwm
    for member in [member for shape in lowered.shapes for member in shape.members]:
        component = lowered.components[member]
        assert isinstance(component, FixedComponent)
        step = FixedStep(component)
        state: list[int] = [0] * component.order
        row, rows = -1, []
        for record in records:
            if record["start"]:
                state = step.start(int(record["rise"]))
            wanted = min(max(abs(int(record["pwm"])), low), high) - low
            old, row = row, wanted
            rates, steady = [int(r) for r in component.rates[row]], int(component.steady[row])
            if component.carries and (row != old or record["start"]):
                before = 0
                if not record["start"]:
                    before = step.increment(state, [int(r) for r in component.rates[old]], int(component.steady[old]))
                step.carry(state, before, step.increment(state, rates, steady))
            for _ in range(component.substeps):
                step.advance(state, rates, step.increment(state, rates, steady))
            rows.append(list(state))
        columns.append(np.array(rows, dtype=np.int64))
    return np.concatenate(columns, axis=1)


@pytest.mark.parametrize("example", ["my1016", "two_mass", "my1016_averaged"])
def test_every_word_is_the_references(example: str, tmp_path: Path) -> None:
    records = inputs()
    np.testing.assert_array_equal(board(example, records, tmp_path).words, reference(program(example), records))


def test_a_sample_takes_no_longer_than_the_goals(tmp_path: Path) -> None:
    records = inputs()
    cycles = board("my1016", records, tmp_path).cycles
    constant = np.r_[False, records["pwm"][1:] == records["pwm"][:-1]] & (records["start"] == 0)
    assert cycles[constant].max() < 900
    assert cycles[~constant & (records["start"] == 0)].max() < 1300


def test_a_change_of_pwm_on_board_takes_less_than_15_000_cycles(tmp_path: Path) -> None:
    records = inputs()
    cycles = board("my1016", records, tmp_path, "onboard").cycles
    held = np.r_[False, records["pwm"][1:] == records["pwm"][:-1]] & (records["start"] == 0)
    assert cycles[held].max() < 900
    assert cycles[~held & (records["start"] == 0)].max() < 15_000
