"""What the whole sketch costs on the board: memory, the longest tick, the share of time awake, and the current.

    python benchmarks/sketch_cost.py [COEFFS] [--only fixed/table float/table] [--horizon SECONDS] [--json FILE]

Each form of the firmware runs for two minutes on the emulated Mega with the simulated motor at full speed (each of the
encoder's 22 083 pulses a second at its own time, by its interrupt), with a row every second, PWM that changes,
commands, a thermocouple that opens, copies to EEPROM every minute and the self test. Then a minute of nothing but
samples and rows gives the share of time awake.

longest tick: from the beginning of a sample's work to its end as the firmware measures it (micros(), steps of 64
cycles), the encoder's interrupts included. longest awake: the longest stretch without sleep that the emulator saw in
the quiet minute, with all text (the self test goes on in slices between the samples, without sleep).
stack: the deepest place that was written, interrupts included.

Current of the ATmega2560 alone at 5 V and 16 MHz, from its data sheet (2549): supply current at 8 MHz and 5 V, with all
power reduction bits set, active 10 mA typical and 14 mA at most, idle 2.7 mA and 4 mA (DC characteristics), taken as
proportional to the clock; plus the modules that this sketch leaves on, in per cent of active and idle ("Supply Current
of IO modules"). Not in it: voltage regulator, USB converter, LEDs, thermocouple converters, encoder and driver, nor
what the pins drive.
"""

from __future__ import annotations

import argparse
import json
import re
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import cast

from rich.box import MARKDOWN
from rich.console import Console
from rich.table import Table

from gen.avr.compile import sizes
from gen.avr.simulator import FREQUENCY_HZ
from gen.coefficients import Coefficients, load
from gen.coefficients.wiring import Wiring
from gen.emulate.board import Board
from gen.emulate.firmware import build_firmware, cache_folder
from gen.emulate.plants.rig import RigPlant
from gen.emulate.results import deepest_stack
from gen.emulate.session import Event, run_session
from gen.firmware.boards import MEGA
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.rig import SensorFault

ROOT = Path(__file__).parent.parent
FORMS = ("fixed/table", "fixed/onboard", "float/table", "float/onboard")
BUSY_S, QUIET_S = 120.0, 60.0
TICK_CYCLES = FREQUENCY_HZ // 4
FLASH_BYTES, RAM_BYTES = 256 * 1024, 8192
MEASURED_HZ = 8e6
ACTIVE_MA, IDLE_MA = (10.0, 14.0), (2.7, 4.0)
"""Typical and largest supply current at 5 V and `MEASURED_HZ`, mA."""
MODULES = {"usart0": (0.030, 0.17), "timer0": (0.015, 0.08), "timer2": (0.043, 0.23), "timer": (0.018, 0.10)}
"""Additional current of a module that is on, as shares of active and idle; `timer` is each of the 16-bit ones."""


@dataclass(frozen=True)
class Cost:
    """One form of the firmware."""

    form: str
    flash_bytes: int
    ram_bytes: int
    stack_bytes: int
    longest_tick_cycles: int
    longest_awake_cycles: int
    awake_share: float
    typical_mA: float
    most_mA: float


def modules_on(wiring: Wiring) -> list[str]:
    """The I/O modules that the sketch for a wiring leaves on, by their names in `MODULES`."""
    pins = wiring.drive.pwm_pins.values() if wiring.drive else ()
    timers = {MEGA.pwm_timers[pin] for pin in pins} | {0}
    if wiring.encoder and wiring.encoder.counts_in_hardware:
        timers.add(5)
    return ["usart0", *(f"timer{timer}" if timer in (0, 2) else "timer" for timer in sorted(timers))]


def current_mA(wiring: Wiring, awake: float) -> tuple[float, float]:
    """Typical and largest average current of the microcontroller alone, mA.

    Parameters
    ----------
    wiring
        Says which modules are on.
    awake
        Share of time awake, 0..1; the rest is idle sleep.
    """
    on = [MODULES[name] for name in modules_on(wiring)]
    active, idle = 1.0 + sum(share for share, _ in on), 1.0 + sum(share for _, share in on)
    clock = FREQUENCY_HZ / MEASURED_HZ
    typical, most = (
        clock * (awake * active * run + (1.0 - awake) * idle * sleep)
        for run, sleep in zip(ACTIVE_MA, IDLE_MA, strict=True)
    )
    return typical, most


def measure(coefficients: Coefficients, form: str) -> Cost:
    """Run one form of the firmware."""
    arithmetic, schedule = form.split("/")
    wiring = coefficients.document.wiring
    assert wiring is not None
    firmware = build_firmware(
        coefficients,
        cast(Arithmetic, arithmetic),
        cast(ScheduleKind, schedule),
        "coeffs.json",
        cache_folder(),
    )
    plant = RigPlant(
        [chip.channel for chip in wiring.thermocouples],
        sensor_faults={wiring.thermocouples[0].channel: (SensorFault("open", 40.0, 50.0),)},
        pulses_per_revolution=wiring.encoder.pulses_per_revolution if wiring.encoder else 0,
    )
    board = Board(firmware.elf, firmware.cache, wiring, plant, encoder="true")
    events = [Event(20.0 + 7.0 * k, "command", pwm=255 - 3 * k) for k in range(6)]
    events += [Event(70.0, "command", pwm=255), Event(60.0, "send", data=b"?\n"), Event(80.0, "send", data=b"test\n")]
    events += [Event(100.0, "send", data=b"reset\n"), Event(BUSY_S - 10.0, "send", data=b"?\n")]
    sent = bytes(run_session(board, BUSY_S, profile=((0.0, 255),), events=events).sent)
    ticks = re.findall(rb"longest_tick_us (\d+)", sent)
    stack = deepest_stack(board.mega)
    asleep, began = board.mega.asleep, board.mega.cycle
    board.mega.longest_awake()  # until now
    run_session(board, BUSY_S + QUIET_S)
    longest_awake = board.mega.longest_awake()
    awake = 1.0 - (board.mega.asleep - asleep) / (board.mega.cycle - began)
    board.close()
    size = sizes(firmware.elf)
    return Cost(
        form,
        size.flash,
        size.ram,
        stack,
        int(ticks[-1]) * FREQUENCY_HZ // 1_000_000,
        longest_awake,
        awake,
        *current_mA(wiring, awake),
    )


def busy(path: Path, horizon_s: float | None) -> Coefficients:
    """Load a coefficient file with a copy to EEPROM every minute, and with a look ahead if one is asked for."""
    document = json.loads(path.read_text())
    document["wiring"]["memory"] = {"interval_s": 60.0}
    if horizon_s is not None:
        document |= {"version": 2, "forecast": {"horizon_s": horizon_s, "near_s": 60.0}}
    with tempfile.TemporaryDirectory() as folder:
        often = Path(folder) / path.name
        often.write_text(json.dumps(document))
        return load(often)


def main() -> None:
    """Measure each form and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("coefficients", type=Path, nargs="?", default=ROOT / "examples" / "my1016" / "coeffs.json")
    parser.add_argument("--only", nargs="+", choices=FORMS, default=FORMS)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--horizon", type=float, help="s; the board looks so far ahead, at the limits of its rules")
    options = parser.parse_args()
    coefficients = busy(options.coefficients, options.horizon)
    costs = []
    with Console(stderr=True).status("") as status:
        for form in options.only:
            status.update(form)
            costs.append(measure(coefficients, form))
    table = Table(
        "form", "flash, B", "RAM, B", "stack, B", "longest tick, cycles", "of a tick", "longest awake, cycles", "awake",
        "current, mA", box=MARKDOWN,
    )  # fmt: skip
    for cost in costs:
        table.add_row(
            cost.form,
            f"{cost.flash_bytes} ({cost.flash_bytes / FLASH_BYTES:.0%})",
            f"{cost.ram_bytes} ({cost.ram_bytes / RAM_BYTES:.0%})",
            str(cost.stack_bytes),
            str(cost.longest_tick_cycles),
            f"{cost.longest_tick_cycles / TICK_CYCLES:.1%}",
            str(cost.longest_awake_cycles),
            f"{cost.awake_share:.1%}",
            f"{cost.typical_mA:.1f} typical, {cost.most_mA:.1f} at most",
        )
    Console(width=300).print(table)
    print(f"A tick has {TICK_CYCLES} cycles. Modules that are on: {', '.join(modules_on_text(coefficients))}.")
    if options.json is not None:
        options.json.write_text(json.dumps([asdict(cost) for cost in costs], indent=1) + "\n")


def modules_on_text(coefficients: Coefficients) -> list[str]:
    """The modules that are on, for people."""
    wiring = coefficients.document.wiring
    assert wiring is not None
    return [name if name != "timer" else "a 16-bit timer" for name in modules_on(wiring)]


if __name__ == "__main__":
    main()
