"""The library alone on an emulated Uno: bit for bit, or refused with the sizes."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from gen.avr.chip import MEGA, UNO, Chip
from gen.avr.compile import sizes
from gen.avr.room import check_room
from gen.coefficients import load
from gen.errors import CheckFailed
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from gen.toolchain import arduino_core
from gen.verification.runners import TAKEN, Library, link_harness, write_library
from gen.verification.verify import verify
from tests.examples import ROOT

MY1016 = ROOT / "examples" / "my1016" / "coeffs.json"


def emitted(folder: Path, chip: Chip) -> Library:
    coefficients = load(MY1016)
    program = lower(coefficients, "fixed", "onboard")
    context = project_context(coefficients, program, "coeffs.json")
    return write_library(program, context, render.library(context), folder, chip)


def harness(folder: Path, flash: int, ram: int) -> Path:
    """A program of about so many bytes."""
    source = folder / "large.cpp"
    source.write_text(
        "#include <avr/pgmspace.h>\n"
        f"const volatile uint8_t constants[{flash}] PROGMEM = {{1}};\n"
        f"volatile uint8_t variables[{ram}];\n"
        "int main() { variables[0] = pgm_read_byte((const uint8_t *)constants); }\n"
    )
    return source


@pytest.mark.parametrize(
    ("path", "arithmetic", "schedule"),
    [("my1016", "fixed", "table"), ("my1016", "float", "onboard"), ("network", "fixed", "table")],
)
def test_no_word_differs_on_an_uno(path: str, arithmetic: Arithmetic, schedule: ScheduleKind) -> None:
    coefficients = load(ROOT / "examples" / path / "coeffs.json")
    (found,) = verify(coefficients, [arithmetic], [schedule], "avr", scale=0.02, board="uno")
    assert found.equal
    assert {target.target.split(" (")[0] for target in found.targets} == {"ATmega328P"}
    assert found.cost is not None
    assert found.cost.flash_bytes < UNO.flash_bytes


@pytest.mark.parametrize(("flash", "ram"), [(32_200, 10), (10, 2_040), (10, 2_100), (32_700, 10)])
def test_what_has_no_room_is_refused_with_its_sizes(flash: int, ram: int, tmp_path: Path) -> None:
    """More than the boot loader leaves, and what the linker itself refuses."""
    library = emitted(tmp_path, UNO)
    with pytest.raises(CheckFailed, match=r"and an ATmega328P has 32256 and 2048$") as caught:
        check_room(
            TAKEN,
            sizes(link_harness(library, [harness(tmp_path, flash, ram)], [library.include], "large.elf")),
            20,
            UNO,
        )
    assert "\n" not in str(caught.value)
    numbers = re.search(r"take (\d+) bytes of flash and (\d+) of RAM", str(caught.value))
    assert numbers is not None
    assert flash < int(numbers[1]) < flash + 6_000
    assert ram <= int(numbers[2]) < ram + 200
    made = link_harness(replace(library, chip=MEGA), [harness(tmp_path, flash, ram)], [library.include], "mega.elf")
    assert sizes(made).flash > flash


def test_the_boards_memories_are_those_of_the_arduino_core() -> None:
    text = (arduino_core() / "boards.txt").read_text(encoding="utf-8")
    said = dict(re.findall(r"^([\w.]+)=(.*)$", text, re.MULTILINE))
    for prefix, chip in (("uno", UNO), ("mega.menu.cpu.atmega2560", MEGA)):
        assert said[f"{prefix}.build.mcu"] == chip.mcu
        assert int(said[f"{prefix}.upload.maximum_size"]) == chip.flash_bytes
        assert f"ARDUINO_{said[f'{prefix}.build.board']}" == chip.define
    assert int(said["uno.upload.maximum_data_size"]) == UNO.ram_bytes
