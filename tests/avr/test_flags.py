"""What is measured is what users build: the flags of PlatformIO's atmelavr, and a sketch of the size that it prints.

The stand-in's list of flags (`tests/platformio/standins`) was copied from platform-atmelavr's own builder
(`builder/frameworks/arduino.py`), by hand and without a look at `gen/avr`.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

import gen.avr.compile as compiling
from gen.avr.compile import ArduinoCore, sizes
from gen.emulate.firmware import build_firmware
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.lower import lower
from gen.verification.runners import AvrRunner, write_library
from tests.examples import ROOT, example
from tests.platformio.environment import STANDINS, install, pio_run

BUILDER = (STANDINS / "platforms" / "atmelavr" / "arduino_framework.py").read_text(encoding="utf-8")
CODE = {"-Os", "-O0", "-O1", "-O2", "-O3", "-flto", "-ffunction-sections", "-fdata-sections", "-fno-exceptions"}
CODE |= {"-fno-threadsafe-statics", "-std=gnu++11", "-std=gnu11", "-Wl,--gc-sections", "-fuse-linker-plugin"}
"""Flags that change what the compiler makes."""


def listed(*names: str) -> set[str]:
    """Flags in the stand-in's lists of these names."""
    found: set[str] = set()
    for name in names:
        for text in re.findall(rf"{name}\s*=\s*\[([^\]]*)\]", BUILDER):
            found |= set(re.findall(r'"([^"]+)"', text))
    return found & CODE


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch) -> list[Sequence[str]]:
    """Every command of a compiler or linker that is run from here on."""
    run: list[Sequence[str]] = []
    original = compiling._run

    def recorded(command: list[str]) -> str:
        run.append(command)
        return original(command)

    monkeypatch.setattr(compiling, "_run", recorded)
    return run


def check(commands: Sequence[Sequence[str]]) -> None:
    compiled = [command for command in commands if "-c" in command and str(command[0]).endswith("g++")]
    linked = [command for command in commands if "-Wl,--gc-sections" in command]
    assert compiled and linked
    for command in compiled:
        language = command[command.index("-x") + 1] if "-x" in command else "c++"
        if language != "assembler-with-cpp":
            assert set(command) & CODE == listed("compiler_flags", "CXXFLAGS" if language == "c++" else "CFLAGS")
    for command in linked:
        assert set(command) & CODE == listed("LINKFLAGS")


def test_the_stand_ins_list_is_read() -> None:
    assert listed("compiler_flags", "CXXFLAGS") >= {"-Os", "-flto", "-std=gnu++11"}
    assert listed("LINKFLAGS") == {"-Os", "-flto", "-Wl,--gc-sections", "-fuse-linker-plugin"}


def test_gen_verify_compiles_the_library_as_users_do(tmp_path: Path, commands: list[Sequence[str]]) -> None:
    coefficients = example("my1016_averaged")
    program = lower(coefficients, "float", "table")
    context = project_context(coefficients, program, "coeffs.json")
    AvrRunner(write_library(program, context, render.library(context), tmp_path), tmp_path / "cache")
    check(commands)


def test_the_emulated_sketch_is_compiled_as_users_do(tmp_path: Path, commands: list[Sequence[str]]) -> None:
    build_firmware(example("my1016_averaged"), "fixed", "table", "coeffs.json", tmp_path)
    check(commands)


def test_the_emulated_sketch_has_the_size_that_pio_prints(tmp_path: Path) -> None:
    """Of the project in the repository; from another path, in another order of files, by PlatformIO's own build."""
    project = tmp_path / "project"
    shutil.copytree(ROOT / "firmware_out", project)
    variables = install(tmp_path / "pio", project)
    output = pio_run(project, variables=variables).output
    printed = [int(used) for used in re.findall(r"used (\d+) bytes", output)]
    core = ArduinoCore(tmp_path, link_time=True)
    library = next((project / "lib").iterdir()) / "src"
    sources = [*(project / "src").glob("*.cpp"), *library.glob("*.cpp")]
    elf = compiling.build_elf(
        sources, [project / "src", library], tmp_path / "own.elf", core=core, link_time=True, own_warnings=False
    )
    own = sizes(elf)
    assert printed == pytest.approx([own.ram, own.flash], rel=0.005)


def test_objects_of_the_core_keep_their_symbols(tmp_path: Path) -> None:
    """An archive of objects for the link-time optimiser needs the compiler's own archiver."""
    archive = ArduinoCore(tmp_path, link_time=True).archive
    listing = subprocess.run(["avr-gcc-nm", "-s", str(archive)], capture_output=True, text=True, check=True).stdout
    assert "millis in wiring.c.o" in re.sub(r"\d{3}-", "", listing)
