"""What a board on a bench meets and a tidy run does not: floods, worn cells, long programs, idle sleep's habits."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gen import toolchain
from gen.avr.compile import ArduinoCore, build_elf
from gen.coefficients import parse
from gen.emulate.wiring.devices import ResetCause
from gen.errors import CheckFailed, InputError
from gen.firmware.context import project_context
from gen.lowering.lower import lower
from tests.device.board import LATE, NOISY, Board, program_crc, warm
from tests.device.conftest import Open
from tests.device.variants import BASE, variant

ADCSRA, ADEN, ADIE = 0x7A, 0x80, 0x08
RECORD = 64


def test_a_noisy_encoder_line_does_not_stop_the_clock(power_up: Open) -> None:
    """Interrupts without a gap leave no turn to Timer 0's, which has less priority: millis() would fall behind."""
    board = power_up()
    board.encoder.attach(2)
    board.started()
    board.send("rows 1")
    board.encoder.send(5 * 360_000, 5.0)
    board.hear(1.0)
    began = board.seconds
    rows = board.hear(3.0).rows
    passed = float(rows[-1]["time_s"]) - float(rows[0]["time_s"]) + 0.25
    assert passed == pytest.approx(board.seconds - began, abs=0.26)
    assert all(int(row["flags"]) & NOISY for row in rows)


def test_a_few_pulses_close_together_cost_no_speed(power_up: Open) -> None:
    """A switch that bounces once is no flood: the samples after it have a speed."""
    board = power_up()
    board.encoder.attach(2)
    board.started()
    board.send("rows 1")
    board.hear(1.0)
    board.encoder.send(40, 40 / 400_000)
    rows = board.hear(1.0).rows
    assert not any(int(row["flags"]) & NOISY for row in rows)
    assert all(row["speed_rpm"] for row in rows)


def test_samples_that_catch_up_have_no_wild_speed(power_up: Open) -> None:
    """One pulse in a revolution: in the milliseconds from a late sample to the next one it would mean 10 000 rpm."""
    board = power_up("one_pulse")
    board.encoder.attach(2)
    board.started()
    board.send("rows 1")
    board.hear(0.5)
    board.encoder.send(44 * 20, 20.0)  # 2640 rpm
    board.hear(2.0)
    late = 0
    for _ in range(15):
        board.hold_up(600)
        rows = board.hear(1.0).rows
        late += sum(bool(int(row["flags"]) & LATE) for row in rows)
        assert not any(int(row["flags"]) & NOISY for row in rows)
    assert late >= 30


def test_the_converter_is_off_while_nothing_is_converted(power_up: Open) -> None:
    """The data sheet ("ADC Noise Canceler"): idle sleep begins a conversion if the converter is on and waits.

    Its interrupt would add a number behind the last sum. The emulator does not do so.
    """
    board = power_up("voltages")
    board.pins.drive_analog(54, 2.5)
    board.pins.drive_analog(55, 1.0)
    board.started()
    board.hear(1.0)
    on = 0
    for _ in range(250):
        board.run_seconds(0.001)
        control = board.memory.peek(ADCSRA, 1)[0]
        if control & ADEN:
            assert control & ADIE
            on += 1
        else:
            assert board.read("converting") == 2
    assert 2 <= on <= 30
    row = board.hear(1.0).rows[-1]
    assert float(row["a_V"]) == pytest.approx(2.5, abs=0.011)
    assert float(row["b_V"]) == pytest.approx(1.0, abs=0.011)


@pytest.mark.parametrize("frequency_hz", [490.2, 976.6])
def test_a_chopped_current_is_measured_over_whole_periods(built: Callable[..., Path], frequency_hz: float) -> None:
    """The driver's PWM on a current sensor, at any duty and phase; conversions follow each other every 112 us."""
    source = (built("voltages").parent / "src" / "converter.cpp").read_text()
    (conversions,) = {int(found) for found in re.findall(r" (\d+)\},  // \$\.wiring\.channels", source)}
    choose = np.random.default_rng(1)
    duty, phase = choose.uniform(0.0, 1.0, (2, 2000, 1))
    cycles = frequency_hz * 112e-6 * np.arange(conversions) + phase
    measured = (cycles % 1.0 < duty).mean(axis=1)
    assert np.abs(measured - duty[:, 0]).max() < 0.06
    assert np.sqrt(np.mean((measured - duty[:, 0]) ** 2)) < 0.015


def test_a_copy_that_failed_does_not_hide_the_next_one(power_up: Open) -> None:
    """A cell of slot 1 is worn out: the copy there has the right identity and number, and a wrong CRC."""
    board = warm(power_up("often_copied"))
    board.started()
    begun = board.eeprom.counts.writes
    while board.eeprom.counts.writes < begun + 40 or board.eeprom.busy:
        board.run_seconds(0.002)
    worn = bytearray(board.eeprom.image)
    worn[RECORD + 30] ^= 0x10
    board.eeprom.image = bytes(worn)
    said = board.hear(15.0)
    assert any(int(row["flags"]) & 0x800 for row in said.rows)
    board.hear(65.0)
    assert not int(board.hear(1.5).rows[-1]["flags"]) & 0x800
    board.cut_power(1.0, seed=2)  # nothing is left in RAM
    assert board.started().events[-1].endswith("start from memory")


def test_a_long_program_is_summed_up_before_the_watchdog_bites(
    built: Callable[..., Path], cache: Path, tmp_path: Path
) -> None:
    """200 KB: across both borders of 64 KB that RAMPZ has to cross, and longer to sum up than the watchdog waits."""
    built("my1016")
    folder = cache / "my1016-False"
    library = folder / "lib" / "my1016" / "src"
    filler = tmp_path / "filler.cpp"
    filler.write_text(
        '__asm__(".section .fini1,\\"ax\\",@progbits\\n.rept 42500\\n.word 0x1234, 0xABCD\\n.endr\\n.text\\n");\n'
    )
    sources = sorted([filler, *(folder / "src").glob("*.cpp"), *library.glob("*.cpp")])
    elf = build_elf(
        sources, [folder / "src", library], tmp_path / "long.elf", core=ArduinoCore(cache), optimisation="-Os"
    )
    image = tmp_path / "image.bin"
    subprocess.run([str(toolchain.program("avr-objcopy")), "-O", "binary", str(elf), str(image)], check=True)
    assert image.stat().st_size > 190_000
    board = Board(elf, cache, variant("my1016"))
    said = board.started()
    assert said.comments["firmware"].startswith(f"crc32 {program_crc(elf, tmp_path)} of ")
    assert board.resets == 0


def test_a_reset_by_the_watchdog_is_told_though_the_boot_loader_cleared_its_cause(power_up: Open) -> None:
    """The stock boot loader clears MCUSR; its way after the watchdog's reset leaves SRAM and UART alone."""
    board = power_up()
    board.started()
    board.cut_power(1.0, cause=ResetCause(0))  # the SRAM holds noise then
    assert board.started().comments["reset"] == "unknown"
    board.write("tick_due", board.read("tick_due") + 3000)  # no sample for 3 s
    resets = board.resets
    while board.resets == resets:
        board.run_seconds(0.01)
    assert board.started().comments["reset"] == "watchdog"
    board.press_reset(cause=ResetCause(0))
    assert board.started().comments["reset"] == "watchdog"


def test_a_drive_on_the_boot_loaders_led_is_refused() -> None:
    tree = json.loads(json.dumps(BASE))
    del tree["wiring"]["led_pin"]
    tree["wiring"]["drive"]["reverse_pin"] = 13
    with pytest.raises(InputError, match=r"\$\.wiring\.drive\.reverse_pin: pin 13 is the boot loader's LED"):
        parse(json.dumps(tree).encode())


def test_a_table_that_the_compiler_does_not_take_is_refused() -> None:
    tree = json.loads(json.dumps(BASE))
    casing = next(component for component in tree["components"] if component["name"] == "casing")
    tree["components"] = [{**casing, "name": f"part_{i}"} for i in range(16)]
    tree["alarms"] = []
    del tree["wiring"], tree["provenance"]
    coefficients = parse(json.dumps(tree).encode())
    with pytest.raises(CheckFailed, match=r"32768 bytes.*--schedule onboard"):
        project_context(coefficients, lower(coefficients, "fixed", "table"), "coeffs.json")
    project_context(coefficients, lower(coefficients, "fixed", "onboard"), "coeffs.json")
    project_context(coefficients, lower(coefficients, "float", "table"), "coeffs.json")


def test_a_reading_never_comes_before_the_longest_conversion_has_ended(power_up: Open) -> None:
    """Whatever a late sample leaves until the next one: millis() counts in steps, so 220 of them may be 219 ms."""
    board = power_up()
    board.started()
    read = next(iter(board.chips.values()))
    before = read.counts.reads
    for later in [220, 221, 222, 223] * 12:
        at = board.read("read_at")
        while board.read("read_at") == at:  # until the next reading
            board.run_seconds(0.0005)
        board.write("tick_due", board.read("read_at") + later)
    counts = [chip.counts for chip in board.chips.values()]
    assert all(count.early == 0 for count in counts)
    assert counts[0].reads - before >= 24


@pytest.mark.parametrize("pulses_per_s", [0, 4000])
def test_the_share_of_sleep_that_it_tells_is_the_emulator_s(power_up: Open, pulses_per_s: int) -> None:
    """With nothing to wake it but its timer, and with an encoder that does."""
    board = power_up()
    board.started()
    board.encoder.attach(2)
    if pulses_per_s:
        board.encoder.send(15 * pulses_per_s, 15.0)
    board.hear(15.0)
    share = board.asleep / board.cycle
    board.send("?")
    status = next(event for event in board.hear(1.0).events if "sleep_permille" in event)
    assert int(status.split("sleep_permille ")[1].split()[0]) == pytest.approx(1000.0 * share, abs=25.0)
