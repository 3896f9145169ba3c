from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gen.arrays import SingleArray
from gen.avr import simulator
from gen.avr.compile import ArduinoCore
from gen.avr.simulator import MARKER_OVERHEAD, EmulatedChip, EmulationFailed, Stop

from .conftest import Emulate

# Cycles by the datasheet of the ATmega2560 (22-bit program counter), in the order of instructions.cpp.
DATASHEET = {
    "nop": 1,
    "add": 1,
    "adiw": 2,
    "mul": 2,
    "muls": 2,
    "mulsu": 2,
    "movw": 1,
    "ld": 2,
    "ldd": 2,
    "st": 2,
    "lds": 2,
    "push, pop": 2 + 2,
    "lpm": 3,
    "elpm": 3,
    "rjmp": 2,
    "call, ret, rjmp": 5 + 5 + 2,
    "rcall, ret, rjmp": 4 + 5 + 2,
    "sec, brcs taken": 1 + 2,
    "clc, brcs not taken": 1 + 1,
}
CLR = 1  # each probe ends with a clr r1


def records(
    mega: EmulatedChip, inputs: NDArray[np.generic], out_size: int, *, max_cycles: int = 100_000_000
) -> tuple[NDArray[np.uint8], NDArray[np.uint32]]:
    """Run one record for each element of ``inputs`` (a structured or plain array)."""
    return mega.run_records(
        inputs,
        mega.memory.address("gen_input"),
        inputs.dtype.itemsize,
        mega.memory.address("gen_output"),
        out_size,
        len(inputs),
        max_cycles,
    )


def float_pairs() -> SingleArray:
    """Corner cases against each other, then random bit patterns that are no NaN, then pairs of like size."""
    tiny, smallest = float(np.finfo(np.float32).tiny), 1e-45
    corners: list[float] = [
        0.0,
        1.0,
        1.5,
        2.0,
        3.0,
        1e-30,
        1e30,
        16777216.0,
        16777217.0,
        0.1,
        tiny,
        smallest,
        tiny * 0.75,
    ]
    corners += [float(np.finfo(np.float32).max), float("inf")]
    signed = np.array([sign * value for value in corners for sign in (1.0, -1.0)], dtype=np.float32)
    crossed = np.stack(np.meshgrid(signed, signed), axis=-1).reshape(-1, 2)
    generator = np.random.default_rng(20240607)
    bits = generator.integers(0, 2**32, size=(20_000, 2), dtype=np.uint32).view(np.float32)
    near = generator.normal(size=(5_000, 2)).astype(np.float32)
    pairs = np.concatenate([crossed, bits[~np.isnan(bits).any(axis=1)], near])
    return np.ascontiguousarray(pairs)


def test_float_sums_and_products_equal_numpys_bit_for_bit(emulate: Emulate) -> None:
    pairs = float_pairs()
    inputs = pairs.view([("a", "<f4"), ("b", "<f4")]).reshape(-1)
    with emulate("floats.cpp") as mega:
        outputs, _ = records(mega, inputs, 12)
    got = outputs.view("<f4")
    a, b = pairs[:, 0], pairs[:, 1]
    with np.errstate(all="ignore"):
        expected = np.stack([a + b, a - b, a * b], axis=1)
    numbers = ~np.isnan(expected)
    np.testing.assert_array_equal(np.isnan(got), ~numbers)
    np.testing.assert_array_equal(got.view("<u4")[numbers], expected.view("<u4")[numbers])
    assert numbers.sum() > 60_000


def test_instruction_cycles_match_the_datasheet(emulate: Emulate) -> None:
    with emulate("instructions.cpp") as mega:
        _, cycles = records(mega, np.zeros(len(DATASHEET), dtype=np.uint8), 1)
    measured = dict(zip(DATASHEET, (cycles - MARKER_OVERHEAD - CLR).tolist(), strict=True))
    assert measured == DATASHEET


def test_marker_overhead_is_that_of_an_empty_step(emulate: Emulate) -> None:
    with emulate("instructions.cpp") as mega:
        _, cycles = records(mega, np.zeros(len(DATASHEET) + 100, dtype=np.uint8), 1)
    assert set(cycles[len(DATASHEET) :].tolist()) == {MARKER_OVERHEAD}
    header = (simulator.MAILBOX_FOLDER / "mailbox.h").read_text(encoding="utf-8")
    assert f"#define GEN_MAILBOX_OVERHEAD {MARKER_OVERHEAD}\n" in header


def test_records_make_the_round_trip_and_calls_continue(emulate: Emulate) -> None:
    generator = np.random.default_rng(5)
    inputs = np.zeros(1000, dtype=[("weight", "u1"), ("value", "<i4")])
    inputs["weight"] = generator.integers(0, 256, 1000)
    inputs["value"] = generator.integers(-(2**12), 2**12, 1000)
    with emulate("accumulate.cpp") as mega:
        first, cycles = records(mega, inputs[:400], 4)
        nothing, _ = records(mega, inputs[:0], 4)
        second, _ = records(mega, inputs[400:], 4)
        assert mega.memory.peek(mega.memory.address("gen_output"), 4) == second[-1].tobytes()
    assert nothing.shape == (0, 4)
    assert cycles.dtype == np.uint32
    assert cycles.shape == (400,)
    got = np.concatenate([first, second]).view("<i4").reshape(-1)
    expected = np.cumsum(inputs["weight"].astype(np.int64) * inputs["value"])
    np.testing.assert_array_equal(got, expected)


def test_records_of_the_wrong_size_are_refused(emulate: Emulate) -> None:
    with (
        emulate("accumulate.cpp") as mega,
        pytest.raises(ValueError, match="3 records of 5 bytes need 15 bytes"),
    ):
        mega.run_records(b"12345", 0x200, 5, 0x210, 4, 3, 1000)


def test_mailbox_outside_the_sram_is_refused(emulate: Emulate) -> None:
    with emulate("accumulate.cpp") as mega, pytest.raises(EmulationFailed, match="outside the SRAM"):
        mega.run_records(b"12345", 0x21FE, 5, 0x210, 4, 1, 1000)


def test_cycle_limit_ends_a_run_of_records(emulate: Emulate) -> None:
    inputs = np.zeros(1000, dtype=[("weight", "u1"), ("value", "<i4")])
    with (
        emulate("accumulate.cpp") as mega,
        pytest.raises(EmulationFailed, match=r"10000 cycles .* of 1000 record"),
    ):
        records(mega, inputs, 4, max_cycles=10_000)


def test_broken_mailbox_protocol_is_an_error(emulate: Emulate) -> None:
    text = '#include "mailbox.h"\nint main() { GEN_MAILBOX_NEXT(); GEN_MAILBOX_NEXT(); }\n'
    with (
        emulate("twice.cpp", text=text) as mega,
        pytest.raises(EmulationFailed, match="before it finished record 0"),
    ):
        mega.run_records(b"1234", 0x200, 2, 0x210, 2, 2, 1000)


def test_early_end_is_an_error(emulate: Emulate) -> None:
    end = '__asm__("cli\\n sleep");'
    text = f'#include "mailbox.h"\nint main() {{ GEN_MAILBOX_NEXT(); GEN_MAILBOX_DONE(); {end} }}\n'
    with (
        emulate("once.cpp", text=text) as mega,
        pytest.raises(EmulationFailed, match=r"ended.*1 of 2 records"),
    ):
        mega.run_records(b"1234", 0x200, 2, 0x210, 2, 2, 1000)


@pytest.mark.parametrize("levels", [1, 10, 100, 255])
def test_stack_watermark_equals_a_known_recursion(emulate: Emulate, levels: int) -> None:
    with emulate("recursion.cpp") as mega:
        records(mega, np.array([200], dtype=np.uint8), 1)
        mega.stack.paint()
        base = 0x21FF - mega.stack.pointer
        records(mega, np.array([levels], dtype=np.uint8), 1)
        use = mega.stack.use()
        static_end = mega.memory.address("_end")
    assert use.below_paint == pytest.approx(4 * levels, abs=2)
    assert use.deepest - use.below_paint == base
    assert use.deepest + use.free == 0x2200 - static_end


def test_stack_is_painted_when_the_emulator_opens(emulate: Emulate) -> None:
    with emulate("recursion.cpp") as mega:
        assert mega.stack.use().deepest == 0
        records(mega, np.array([50], dtype=np.uint8), 1)
        assert mega.stack.use().deepest == pytest.approx(3 + 4 * 50, abs=2)  # 3 for the call of main


def test_uart_echo_through_the_arduino_core(emulate: Emulate, core: ArduinoCore) -> None:
    message = bytes(range(200))
    with emulate("echo.ino", core=core) as mega:
        assert mega.run_until_bytes(b"ready\r\n", 16_000_000) == b"ready\r\n"
        mega.uart.send(message[:120])
        mega.uart.send(message[120:])
        echoed = mega.run_until_bytes(bytes([200]), 16_000_000)
        assert echoed == bytes(byte + 1 for byte in message)
        with pytest.raises(EmulationFailed, match="without sending b'never'; it sent b'Y'"):
            mega.uart.send(b"X")
            mega.run_until_bytes(b"never", 1_000_000)
        mega.run_seconds(0.001)
        assert mega.uart.take() == b""


def test_millis_advance_in_idle_sleep_without_host_time(emulate: Emulate, core: ArduinoCore) -> None:
    with emulate("idle.ino", core=core) as mega:
        mega.run_until_bytes(b"start\r\n", 16_000_000)
        slept, begun = mega.asleep, mega.cycle
        assert mega.run_seconds(30.0) is Stop.LIMIT
        assert mega.seconds == pytest.approx(30.0, abs=0.05)
        mega.run_to_end(40 * 16_000_000)
        executed = (mega.cycle - begun) - (mega.asleep - slept)
        assert executed < 0.02 * (mega.cycle - begun)  # the rest was counted, not waited for
        sent = mega.uart.take()
        assert mega.seconds == pytest.approx(60.0, abs=0.01)
        assert mega.run_cycles(1000) is Stop.ENDED
    assert int(sent) == pytest.approx(60_000, abs=2)


STRAYS = [
    ("opcode.cpp", '__asm__ __volatile__(".word 0x0001");'),
    (
        "jump.cpp",
        '__asm__ __volatile__("ldi r30, 0xff\\n ldi r31, 0xff\\n ldi r24, 1\\n out 0x3c, r24\\n eijmp");',
    ),
    ("write.cpp", "*reinterpret_cast<volatile unsigned char *>(0x2300) = 1;"),
]


@pytest.mark.parametrize(("name", "body"), STRAYS)
def test_crash_is_an_error_with_its_place(emulate: Emulate, name: str, body: str) -> None:
    text = f"int main() {{ {body} for (;;) {{ }} }}\n"
    with emulate(name, text=text) as mega:
        for _ in range(2):
            with pytest.raises(EmulationFailed, match=r"the firmware crashed: .*\(pc 0x.*cycle \d+\)"):
                mega.run_cycles(100_000)


@pytest.mark.parametrize(
    ("name", "body"),
    [*STRAYS, ("sleep.cpp", "cli(); SMCR = 5; sleep_cpu();")],
)
def test_a_firmware_that_may_go_astray_runs_on_until_the_watchdog_resets_it(
    emulate: Emulate, name: str, body: str
) -> None:
    """MCUSR then has its bit 3 alone. A jump behind the flash comes to its beginning: `main` begins anew without it."""
    head = "#include <avr/io.h>\n#include <avr/interrupt.h>\n#include <avr/sleep.h>\n#include <avr/wdt.h>\n"
    text = f"""{head}
    volatile unsigned char causes __attribute__((section(".noinit"))), begun __attribute__((section(".noinit")));
    int main() {{
        causes = MCUSR;
        MCUSR = 0;
        if (causes & _BV(WDRF)) {{ wdt_disable(); for (;;) {{ }} }}
        if (begun == 0x5A) {{ for (;;) {{ }} }}
        begun = 0x5A;
        wdt_enable(WDTO_250MS);
        {body}
        for (;;) {{ }}
    }}
    """
    with emulate(name, text=text) as mega:
        mega.let_go_astray()
        mega.run_seconds(0.2)
        assert mega.resets == 0
        mega.run_seconds(0.2)
        assert mega.resets == 1
        assert mega.memory.peek(mega.memory.address("causes"), 1)[0] == 1 << 3


ASTRAY = """
import sys
from pathlib import Path
from gen.avr.simulator import EmulatedChip, EmulationFailed
with EmulatedChip(Path(sys.argv[1]), Path(sys.argv[2])) as mega:
    try:
        mega.run_cycles(100_000)
    except EmulationFailed:
        print("crashed")
    else:
        print("went on")
"""


@pytest.mark.parametrize(
    ("body", "outcome"),
    [
        # 0x2200 bytes end at data address 0x21FF: these would hit the size of the next piece of the host's heap
        *(
            (f"*reinterpret_cast<volatile unsigned char *>({at:#x}) = 0x7f;", "crashed")
            for at in (0x2208, 0x2209, 0x220A)
        ),
        ("*reinterpret_cast<volatile unsigned char *>(0xffff) = 1;", "crashed"),
        # the last place that RAMPZ reaches, 16 MB on; the chip takes the address modulo its flash
        (
            '__asm__ __volatile__("ldi r30, 0xff\\n ldi r31, 0xff\\n ldi r24, 0xff\\n out 0x3b, r24\\n elpm r24, Z");',
            "went on",
        ),
    ],
)
def test_firmware_gone_astray_leaves_the_process_alone(
    emulate: Emulate, cache: Path, tmp_path: Path, body: str, outcome: str
) -> None:
    emulate("astray.cpp", text=f"int main() {{ {body} for (;;) {{ }} }}\n").close()
    command = [sys.executable, "-c", ASTRAY, str(tmp_path / "astray.cpp.elf"), str(cache)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, outcome, "")


def test_endless_firmware_meets_its_limit(emulate: Emulate) -> None:
    with emulate("endless.cpp", text="int main() { for (;;) { } }\n") as mega:
        assert mega.run_cycles(12_345) is Stop.LIMIT
        assert 12_345 <= mega.cycle < 12_345 + 10
        with pytest.raises(EmulationFailed, match=r"did not end within 1000 cycles \(pc 0x[0-9a-f]+ in main"):
            mega.run_to_end(1000)


def test_watchdog_reset_is_counted_and_the_limit_survives_it(emulate: Emulate) -> None:
    text = "#include <avr/wdt.h>\nint main() { wdt_enable(WDTO_15MS); for (;;) { } }\n"
    with emulate("watchdog.cpp", text=text) as mega:
        assert mega.run_seconds(0.1) is Stop.LIMIT
        assert mega.resets >= 2
        assert mega.seconds == pytest.approx(0.1, abs=1e-5)


def test_memory_can_be_read_and_written(emulate: Emulate) -> None:
    with emulate("accumulate.cpp") as mega:
        address = mega.memory.address("gen_input")
        mega.memory.poke(address, b"\x01\x02\x03")
        assert mega.memory.peek(address, 3) == b"\x01\x02\x03"
        assert mega.memory.peek(address, 0) == b""
        for place, size in ((0x21FF, 2), (-1, 1), (0, -1), (0xFFFFFF, 1)):
            with pytest.raises(ValueError, match="outside the data memory"):
                mega.memory.peek(place, size)
        with pytest.raises(ValueError, match="outside the data memory"):
            mega.memory.poke(0x21FF, b"\0\0")
        with pytest.raises(KeyError, match="no symbol absent"):
            mega.memory.address("absent")
        with pytest.raises(KeyError, match="does not lie in SRAM"):
            mega.memory.address("main")


def test_closed_emulator_refuses_work(emulate: Emulate) -> None:
    mega = emulate("accumulate.cpp")
    mega.close()
    mega.close()
    with pytest.raises(ValueError, match="closed"):
        mega.run_cycles(1)


def test_unreadable_firmware_is_an_error(cache: Path, tmp_path: Path) -> None:
    with pytest.raises(EmulationFailed, match="no such firmware"):
        EmulatedChip(tmp_path / "absent.elf", cache)


def test_sleep_and_the_longest_stretch_awake(emulate: Emulate, core: ArduinoCore) -> None:
    text = """
    void setup() { TCCR1B = TCCR2B = TCCR3B = TCCR4B = TCCR5B = 0; SMCR = _BV(SE); }
    void loop() {
        if ((millis() & 1023) == 0) { delayMicroseconds(5000); delay(1); }
        __asm__ __volatile__("sleep");
    }
    """
    mega = emulate("stretch.ino", text=text, core=core)
    mega.run_seconds(0.5)
    mega.longest_awake()
    mega.run_seconds(3.0)
    assert mega.longest_awake() == pytest.approx((0.005 + 0.001) * 16e6, rel=0.1)
    mega.run_seconds(0.1)
    assert mega.longest_awake() < 0.001 * 16e6
    assert 0.98 < mega.asleep / mega.cycle < 1.0
