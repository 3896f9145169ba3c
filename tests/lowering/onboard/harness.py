"""Builds the printed schedules for the host and for the emulated Mega, and runs them."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen import toolchain
from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedChip
from gen.firmware.onboard_cpp import helpers, math_header
from gen.firmware.onboard_shared import schedule_sources
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.lower import lower_component
from gen.lowering.kinds import Arithmetic
from gen.lowering.onboard import OnboardComponent, compile_component
from gen.lowering.recursion.bounds import StateRanges, state_ranges
from gen.lowering.recursion.dynamics import Dynamics, dynamics
from gen.lowering.recursion.reach import SwitchedRecursion
from tests.model.examples import model

NAME = "demo"
LIMIT_K = 1e-5
PWM = np.arange(256)
PLATFORM = """
#ifndef DEMO_PLATFORM_H
#define DEMO_PLATFORM_H
#ifdef __AVR__
#include <avr/pgmspace.h>
#define DEMO_SMALL __attribute__((noinline, optimize("Os")))
#else
#define DEMO_SMALL
#define PROGMEM
#define pgm_read_byte(address) (*(address))
#define pgm_read_dword(address) (*(address))
#define pgm_read_float(address) (*(address))
#endif
#endif
"""


@cache
def lowered(example: str) -> tuple[FixedComponent, ...]:
    return tuple(lower_component(model(example), c, LIMIT_K) for c in model(example).components)


@cache
def compiled(example: str, arithmetic: Arithmetic) -> tuple[OnboardComponent, ...]:
    return tuple(
        compile_component(model(example), component, arithmetic, fixed.layout, fixed.substeps)
        for component, fixed in zip(model(example).components, lowered(example), strict=True)
    )


@cache
def ranges(example: str, place: int) -> tuple[SwitchedRecursion, StateRanges]:
    recursion = SwitchedRecursion(exact(example)[place].exact)
    return recursion, state_ranges(recursion, exact(example)[place])


@cache
def exact(example: str) -> tuple[Dynamics, ...]:
    return tuple(
        dynamics(model(example), component, fixed.substeps)
        for component, fixed in zip(model(example).components, lowered(example), strict=True)
    )


def words(results: list[tuple[NDArray[Any], NDArray[Any]]]) -> NDArray[np.uint32]:
    """Reference results as the harness writes them: for each PWM every component's rates and S, 32 bits each."""
    columns = []
    for rates, steady in results:
        for column in (*rates.T, steady):
            if column.dtype == np.float32:
                columns.append(np.ascontiguousarray(column).view(np.uint32))
            else:
                columns.append((column & 0xFFFFFFFF).astype(np.uint32))
    return np.stack(columns, axis=1)


@dataclass(frozen=True)
class Sources:
    folder: Path
    count: int


def write_header(folder: Path, arithmetic: Arithmetic, called: frozenset[str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{NAME}_platform.h").write_text(PLATFORM, encoding="utf-8")
    (folder / f"{NAME}_onboard_math.h").write_text(math_header(NAME, arithmetic, called), encoding="utf-8")


def write(folder: Path, components: tuple[OnboardComponent, ...]) -> Sources:
    arithmetic = components[0].arithmetic
    rate, steady = ("uint32_t", "int32_t") if arithmetic == "fixed" else ("float", "float")
    write_header(folder, arithmetic, helpers(components))
    text = f'#include "{NAME}_onboard_math.h"\n' + "".join(schedule_sources(NAME, components))
    (folder / "schedule.h").write_text(text, encoding="utf-8")
    calls, place = [], 0
    for c in components:
        calls.append(
            f"    {NAME}_schedule_{c.name}(x, reinterpret_cast<{rate} *>(out + {place}),"
            f" reinterpret_cast<{steady} *>(out + {place + c.order}));"
        )
        place += c.order + 1
    body = "static void run(uint8_t x, uint32_t *out) {\n" + "\n".join(calls) + "\n}\n"
    (folder / "run.h").write_text('#include "schedule.h"\n' + body, encoding="utf-8")
    (folder / "host.cpp").write_text(
        f'#include <stdio.h>\n#include "run.h"\nint main() {{\n    static uint32_t out[{place}];\n'
        "    for (int x = 0; x < 256; ++x) {\n        run((uint8_t)x, out);\n"
        "        fwrite(out, sizeof out, 1, stdout);\n    }\n    return 0;\n}\n",
        encoding="utf-8",
    )
    loop = "GEN_MAILBOX_NEXT();\n        {work}GEN_MAILBOX_DONE();"
    for file, work in (("avr.cpp", "run(gen_input, gen_output);\n        "), ("empty.cpp", "")):
        include = '#include "run.h"\n' if work else ""
        (folder / file).write_text(
            f'#include "mailbox.h"\n#include <stdint.h>\n{include}uint8_t gen_input;\nuint32_t gen_output[{place}];\n'
            f"int main() {{\n    for (;;) {{\n        {loop.format(work=work)}\n    }}\n}}\n",
            encoding="utf-8",
        )
    return Sources(folder, place)


def host_words(sources: Sources, compiler: str, extra: tuple[str, ...]) -> NDArray[np.uint32]:
    target = sources.folder / f"host-{compiler}{len(extra)}"
    flags = ["-std=gnu++11", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off"]
    flags += ["-fno-strict-aliasing", *extra]
    command = [str(toolchain.program(compiler)), *flags, "-o", str(target), str(sources.folder / "host.cpp")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    run = subprocess.run([str(target)], capture_output=True, check=True)
    assert run.stderr == b"", run.stderr.decode()
    return np.frombuffer(run.stdout, dtype="<u4").reshape(256, sources.count)


def mega_words(sources: Sources, cache_folder: Path) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    elf = build_elf([sources.folder / "avr.cpp"], [MAILBOX_FOLDER, sources.folder], sources.folder / "avr.elf")
    with EmulatedChip(elf, cache_folder) as mega:
        inputs = PWM.astype(np.uint8)
        output, cycles = mega.run_records(
            inputs,
            mega.memory.address("gen_input"),
            1,
            mega.memory.address("gen_output"),
            4 * sources.count,
            256,
            100_000_000,
        )
    return output.view("<u4").reshape(256, sources.count), cycles


def flash_bytes(sources: Sources) -> int:
    """Flash of the schedules: the program with them less the same without."""
    sizes = []
    for file in ("avr.cpp", "empty.cpp"):
        elf = build_elf([sources.folder / file], [MAILBOX_FOLDER, sources.folder], sources.folder / f"{file}.size.elf")
        answer = subprocess.run(
            [str(toolchain.program("avr-size")), str(elf)], capture_output=True, text=True, check=True
        )
        text, data = answer.stdout.splitlines()[1].split()[:2]
        sizes.append(int(text) + int(data))
    return sizes[0] - sizes[1]
