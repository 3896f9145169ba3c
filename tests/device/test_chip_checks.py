"""The checks of the chip itself, on the emulated Mega: the CPU's registers, the clock by the watchdog's oscillator."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedChip
from gen.firmware import render
from gen.firmware.sketch.chip_checks import chip_checks
from tests.device.board import Board
from tests.device.conftest import Open
from tests.device.test_protection import pwm, running

MAIN = """
#include "mailbox.h"
#include "cpu.h"
#include <avr/interrupt.h>
extern "C" {
volatile uint8_t gen_given;
volatile struct { uint8_t holds, flags; uint16_t stack; } gen_output;
}
int main() {
    cli();
    for (;;) {
        GEN_MAILBOX_NEXT();
        SREG = gen_given & 0x7F;
        gen_output.holds = cpu::registers_hold();
        gen_output.flags = SREG & 0x80;
        gen_output.stack = SP;
        GEN_MAILBOX_DONE();
    }
}
"""
OUT_SREG_R16 = bytes([0x0F, 0xBF])


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The emitted test of the registers in a program of its own."""
    folder = tmp_path_factory.mktemp("cpu")
    templates = {f"{name}": f"src/{name}.j2" for name in ("cpu.h", "cpu.cpp")}
    for path, text in render.render(templates, {"name": "cpu", **chip_checks(0.25)}).items():
        (folder / path).write_text(text)
    (folder / "main.cpp").write_text(MAIN)
    sources = [folder / "main.cpp", folder / "cpu.cpp"]
    return build_elf(sources, [MAILBOX_FOLDER, folder], folder / "cpu.elf", optimisation="-Os")


def verdict(elf: Path, cache: Path) -> tuple[bool, int]:
    """Whether the registers hold, and how many cycles it took."""
    with EmulatedChip(elf, cache) as mega:
        given, output = (mega.memory.address(name) for name in ("gen_given", "gen_output"))
        found, cycles = mega.run_records(np.zeros(2, dtype="u1"), given, 1, output, 4, 2, 100_000)
    assert found[0, 1] == 0, "interrupts are as they were"
    assert found[0, 2:].tolist() == found[1, 2:].tolist(), "the stack is as it was"
    assert found[0, 0] == found[1, 0]
    return bool(found[0, 0]), int(cycles[0])


def of_registers(elf: bytes) -> Iterator[int]:
    """Places in the file of all `ldi`: each gives a register what it has to hold, or what is expected of it."""
    start = struct.unpack_from("<I", elf, 28)[0]
    entry, count = struct.unpack_from("<HH", elf, 42)
    segments = [struct.unpack_from("<5I", elf, start + entry * number) for number in range(count)]
    for kind, offset, _, flash, size in segments:
        if kind == 1 and flash < 0x800000:
            for place in range(offset, offset + size, 2):
                word = struct.unpack_from("<H", elf, place)[0]
                if word & 0xF000 == 0xE000:
                    yield place


def test_sound_registers_hold_within_the_cycles_that_the_header_tells(program: Path) -> None:
    holds, cycles = verdict(program, program.parent)
    assert holds
    assert cycles <= chip_checks(0.25)["cpu_cycles"]


@pytest.mark.parametrize("bit", [0, 3, 7])
def test_a_bit_that_is_stuck_in_any_register_is_found(program: Path, bit: int) -> None:
    """The number that goes into a register has another bit than the one that is looked for: as if it were stuck."""
    elf = program.read_bytes()
    fill = ldi_of_the_test(elf)
    assert len(fill) >= 2 * 32
    for place in fill:
        damaged = bytearray(elf)
        word = struct.unpack_from("<H", elf, place)[0]
        struct.pack_into("<H", damaged, place, word ^ (1 << bit if bit < 4 else 1 << (bit + 4)))
        path = program.parent / "damaged.elf"
        path.write_bytes(damaged)
        holds, _ = verdict(path, program.parent)
        assert not holds, f"at {place:#x}"


def ldi_of_the_test(elf: bytes) -> list[int]:
    """Those that fill a register or say what it has to hold: from the first pattern's first on."""
    places = list(of_registers(elf))
    values = [(struct.unpack_from("<H", elf, place)[0] >> 4 & 0xF0) | elf[place] & 0xF for place in places]
    pattern = list(chip_checks(0.25)["cpu_patterns"][0])
    first = next(at for at in range(len(values)) if values[at : at + 32] == pattern)
    return places[first : first + 2 * (32 + 16)]


def test_flags_that_are_not_what_was_written_are_found(program: Path) -> None:
    """Nothing is written in place of either pattern."""
    elf = program.read_bytes()
    after = ldi_of_the_test(elf)[-1]
    writes = [place for place in range(after, after + 40, 2) if elf[place : place + 2] == OUT_SREG_R16]
    assert len(writes) == 2
    for place in writes:
        path = program.parent / "damaged.elf"
        path.write_bytes(elf[:place] + bytes(2) + elf[place + 2 :])
        assert not verdict(path, program.parent)[0]


def test_a_register_that_does_not_hold_stops_the_motor(power_up: Open) -> None:
    board = running(power_up)
    board.write("bad_cpu", 1)  # as the test leaves it
    said = board.hear(1.0)
    assert any("protection cpu_check begins" in event for event in said.events)
    assert pwm(board) == 0
    board.send("reset")
    board.send("test")
    assert any("test cpu FAILED" in event for event in board.hear(4.0).events)
    assert pwm(board) == 0


def took_us(board: Board) -> int:
    board.send("test")
    (found,) = [re.search(r"test clock \w+ (\d+) us", event) for event in board.hear(5.0).events if "clock" in event]
    assert found is not None
    return int(found[1])


@pytest.mark.parametrize(
    ("hertz", "off"), [(128_000, False), (109_000, False), (155_000, False), (96_000, True), (175_000, True)]
)
def test_a_clock_that_disagrees_with_the_watchdog_s_oscillator_is_told(power_up: Open, hertz: int, off: bool) -> None:
    board = power_up("protected")
    board.encoder.attach(2)
    board.run_watchdog_at(hertz)
    board.started()
    events = board.hear(22.0).events
    assert any("protection clock_check begins" in event for event in events) == off
    assert took_us(board) == pytest.approx(2048e6 / hertz, rel=0.01)
    board.run_watchdog_at(128_000)
    events = board.hear(22.0).events
    assert any("protection clock_check ends" in event for event in events) == off


def test_an_oscillator_that_stands_still_is_told(power_up: Open) -> None:
    board = power_up("protected")
    board.encoder.attach(2)
    board.run_watchdog_at(1000)  # two seconds for what is 16 ms
    events = board.started().events + board.hear(1.0).events
    assert any("protection clock_check begins" in event for event in events)


def test_a_board_that_hangs_while_the_watchdog_is_measured_is_reset_all_the_same(power_up: Open) -> None:
    board = power_up()
    board.started()
    for _ in range(2000):  # until a measurement is under way
        board.run_seconds(0.005)
        if board.read("measuring"):
            break
    assert board.read("measuring")
    before = board.resets
    board.write("tick_due", board.read("tick_due") + 1_000_000)  # no sample for 1000 s
    board.run_seconds(1.7)
    assert board.resets == before
    assert board.hear(1.2).comments["reset"] == "watchdog"
    assert board.resets == before + 1
