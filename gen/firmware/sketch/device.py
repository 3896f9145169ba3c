"""The whole sketch: which sources a wiring needs, and what they are told."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gen.coefficients import Coefficients
from gen.coefficients.document import Document
from gen.coefficients.protecting import protections, watched_channels
from gen.coefficients.protection import Protection
from gen.coefficients.sample_time import milliseconds
from gen.coefficients.wiring import Wiring
from gen.firmware.alarm_text import AlarmText, alarm_texts
from gen.firmware.boards import BOARDS, Board
from gen.firmware.sketch.commissioning import CommissioningContext, commissioning_context
from gen.firmware.sketch.converter import ConverterContext, converter_context
from gen.firmware.sketch.drive import (
    DriveContext,
    ObserveContext,
    drive_context,
    idle_timers,
    observe_context,
    switched_off,
)
from gen.firmware.sketch.encoder import EncoderContext, encoder_context
from gen.firmware.sketch.inputs import InputsContext, converted_inputs, inputs_context
from gen.firmware.sketch.memory import LatchContext, MemoryContext, latch_context, memory_context
from gen.firmware.sketch.pin import Pin, pin_context
from gen.firmware.sketch.rows import RowsContext, rows_context
from gen.firmware.sketch.sensors import SensorsContext, sensors_context, thermistor_inputs
from gen.firmware.sketch.supply import SupplyContext, supply_context, supply_input
from gen.firmware.sketch.zero import ZeroContext, zero_context
from gen.lowering.alarms import COLD_mK
from gen.lowering.program import Program
from gen.lowering.samples import samples
from gen.lowering.sensors import CONFIRMATIONS

_ALWAYS = ("board", "commands", "console", "cpu", "crc32", "drive", "oscillator", "output", "selftest")
_START_MS = 5000
"""How long the model's start waits for thermocouples that are not believed yet."""


class DeviceContext(SensorsContext, InputsContext, ConverterContext, RowsContext):
    """The whole sketch; a part that is not wired is empty or None."""

    cold_mK: int
    baud: int
    late_ms: int
    start_samples: int
    start_s: str
    led: int | None
    button: int | None
    encoder: EncoderContext | None
    drive: DriveContext | None
    observe: ObserveContext | None
    memory: MemoryContext | None
    latch: LatchContext | None
    commissioning: CommissioningContext | None
    zero: ZeroContext | None
    relay: Pin | None
    supply: SupplyContext | None
    protects: bool
    unseen: int
    timeout_samples: int
    idle_timers: list[int]
    switched_off: dict[str, list[str]]
    board: Board
    alarms: list[str]
    alarm_texts: tuple[AlarmText, ...]


def sketch_files(device: DeviceContext) -> dict[str, str]:
    """Emitted path -> template for the sources that this wiring needs.

    Parameters
    ----------
    device
        What `device_context` made.
    """
    modules = [*_ALWAYS]
    for module, wanted in (
        ("channels", device["channels"]),
        ("converter", device["converted"]),
        ("thermocouples", device["chips"]),
        ("encoder", device["encoder"]),
        ("observer", device["observe"]),
        ("relay", device["relay"]),
        ("guard", device["protects"]),
        ("supply", device["supply"]),
        ("memory", device["memory"]),
        ("writing", device["memory"]),
        ("snapshot", device["memory"]),
        ("warm", device["memory"]),
        ("latch", device["latch"]),
        ("commissioned", device["commissioning"]),
        ("commissioning", device["commissioning"]),
        ("commissioning_words", device["commissioning"]),
        ("zero", device["zero"]),
        ("indicator", device["led"] is not None or device["button"] is not None),
    ):
        if wanted:
            modules.append(module)
    names = ["config.h", "device.h", "main.cpp", *(f"{module}.{end}" for module in modules for end in ("h", "cpp"))]
    files = {f"src/{name}": f"src/{name}.j2" for name in names}
    if device["chips"]:
        endings = (".h", "_state.h", ".cpp")
        files |= {f"lib/NAME/src/NAME_sensors{end}": f"lib/model/src/sensors{end}.j2" for end in endings}
    return files


def device_context(coefficients: Coefficients, program: Program) -> DeviceContext:
    """Everything about the board that the templates of the sketch need.

    Parameters
    ----------
    coefficients, program
        What is emitted.
    """
    document = coefficients.document
    wiring = document.wiring or Wiring()
    board = BOARDS[document.board]
    drive, encoder, observe = wiring.drive, wiring.encoder, wiring.observe
    sample_time, full_scale = program.model.sample_time, document.input.full_scale
    sample_ms = milliseconds(sample_time)
    first_input = sum(channel.analog_pin is not None for channel in wiring.channels)
    sensors = sensors_context(board, coefficients, wiring.thermocouples, program, sample_ms, first_input)
    memory = memory_context(board, wiring, sensors, program, coefficients.sha256, sample_ms)
    entries = protections(document)
    thermistors, reference = thermistor_inputs(board, wiring.thermocouples), supply_input(board, entries)
    inputs = inputs_context(board, wiring.channels, program, sample_ms, [*thermistors, *reference])
    converted = [*converted_inputs(board, inputs), *thermistors, *reference]
    driver = drive_context(board, drive, full_scale, sample_time) if drive else None
    lasting = any(entry.until != "itself" for entry in entries)
    idle = idle_timers(board, wiring)
    start_samples = max(2 * CONFIRMATIONS * sensors["read_samples"], math.ceil(_START_MS / sample_ms))
    return {
        **sensors,
        **inputs,
        **converter_context(board, converted),
        **rows_context(coefficients, wiring, sensors["chips"], protects=bool(entries)),
        "cold_mK": COLD_mK,
        "baud": wiring.serial_baud,
        "late_ms": max(2, sample_ms // 25),
        "start_samples": start_samples,
        "start_s": f"{start_samples * sample_ms / 1000:g}",
        "led": wiring.led_pin,
        "button": wiring.button_pin,
        "encoder": encoder_context(board, encoder, document.input.nominal_speed_rpm, sample_ms) if encoder else None,
        "drive": driver,
        "observe": observe_context(board, observe) if observe else None,
        "memory": memory,
        "latch": latch_context(board) if memory and (document.alarms or lasting) else None,
        "commissioning": commissioning_context(board, wiring, driver, program) if memory else None,
        "zero": zero_context(board, wiring, program, sensors["reading_ms"]) if memory else None,
        "relay": pin_context(board, wiring.relay_pin, "$.wiring.relay_pin") if wiring.relay_pin is not None else None,
        "supply": supply_context(wiring, len(converted) - 1) if reference else None,
        "protects": bool(entries),
        "unseen": _unseen(document, entries),
        "timeout_samples": samples(wiring.command_timeout_s or 0.0, sample_time),
        "idle_timers": idle,
        "switched_off": switched_off(board, idle, converts=bool(converted)),
        "board": board,
        "alarms": [alarm.name for alarm in document.alarms],
        "alarm_texts": alarm_texts(coefficients),
    }


def _unseen(document: Document, entries: Sequence[Protection]) -> int:
    """A bit for each thermocouple that has to be believed once after a start; 0 where no entry asks for it."""
    if document.wiring is None or all(entry.cause != "sensor_unseen" for entry in entries):
        return 0
    watched = watched_channels(document)
    return sum(1 << number for number, chip in enumerate(document.wiring.thermocouples) if chip.channel in watched)
