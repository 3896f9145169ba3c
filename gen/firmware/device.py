"""What the templates of the sketch are told: pins as ports and bits, limits in the units of the board, JSON paths."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence

import numpy as np

from gen.coefficients import Coefficients
from gen.coefficients.alarms import MOST_SAMPLES
from gen.coefficients.wiring import (
    SUPPLY_V,
    ChannelInput,
    CHIP_RANGES_degC,
    Drive,
    Encoder,
    Observe,
    Thermocouple,
    Wiring,
)
from gen.firmware.alarm_text import alarm_texts
from gen.firmware.contexts.board import (
    DeviceContext,
    DriveContext,
    EncoderContext,
    InputContext,
    InputsContext,
    LatchContext,
    MemoryContext,
    ObserveContext,
    Pin,
    RowsContext,
    SensorsContext,
    ThermocoupleContext,
)
from gen.firmware.contexts.channels import channel_names
from gen.firmware.pins import INTERRUPTS, PWM_TIMERS, TIMER_RUNS, label, port_bit
from gen.lowering.alarms import COLD_mK
from gen.lowering.platinum import HIGHEST_COUNTS, LOWEST_COUNTS, SEGMENT_BITS
from gen.lowering.program import Program
from gen.lowering.protection import lower_protection
from gen.lowering.sensors import (
    CONFIRMATIONS,
    FASTER,
    LONGEST_SAMPLES,
    NOISE_COUNTS,
    PLAUSIBLE_SAMPLES,
    COUNT_mK,
    SensorLimits,
    conversion_ms,
    reading_samples,
    sensor_limits,
)
from gen.model.network_parts import PWM
from gen.reference.effects import effect_fields
from gen.reference.lanes import state_fields
from gen.reference.model import AMBIENT_FIELD
from gen.reference.network import state_fields as network_state_fields
from gen.version import __version__

#: Modules of the sketch that every project has.
_ALWAYS = ("board", "commands", "console", "crc32", "drive", "output", "selftest")
EEPROM_BYTES = 4096
EEPROM_CYCLES = 100_000
"""Erase and write cycles that the ATmega2560's data sheet promises for a byte of EEPROM."""
_FIRMWARE_BYTES = 8
"""End of the EEPROM: the firmware's CRC and its complement."""
_LATCH_SLOTS = 4
_LATCH_BYTES = 18
"""A record of what outlives a reset: identity 4, number 4, alarms 2, protection 4, CRC 4."""
_LATCH_AT = EEPROM_BYTES - _FIRMWARE_BYTES - _LATCH_SLOTS * _LATCH_BYTES
_RECORD_FIXED = 4 + 4 + 2 + 4
"""Bytes of a copy beside the measured temperatures and the states: identity, number, PWM, CRC."""
_START_MS = 5000
"""How long the model's start waits for thermocouples that are not believed yet."""
_LINE_BYTES = 110
"""Longest line that is not a row (output.h)."""
_MILLIS_STEP = 2
"""By how much millis() may run ahead within a difference: it counts every 1.024 ms, two at a time now and then."""
_LATE_SAMPLES = 3
"""Samples whose pulses at full speed the encoder's interrupt takes before it takes the line for noisy."""
_CONVERSION_CYCLES = 14 * 128
"""From one conversion to the next, which its interrupt begins: 13 cycles of the converter's clock, and another."""
_CONVERSIONS = (55, 18)
"""Conversions of a voltage that are added up for a value; the first number that fits into a sample. They last about 3
periods, or 1, of 490 Hz PWM (6 or 2 of 976 Hz): with other lengths, parts of a period would show in a current that the
motor's driver chops. The sum has 16 bits."""
_SETTLING = 8
"""Conversions that are thrown away after the converter was off."""
_SCALE_BITS = 15
"""Of the factor that such a sum is multiplied by."""
_MARGIN = 1.25
"""The encoder's fastest pulse train over the nominal one."""
_OVERSPEED, _TURNING = 1.2, 0.05
"""Shares of the nominal speed beyond which a motor is too fast, and beyond which it turns at all."""


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
        ("thermocouples", device["chips"]),
        ("encoder", device["encoder"]),
        ("observer", device["observe"]),
        ("relay", device["relay"]),
        ("guard", device["protects"]),
        ("memory", device["memory"]),
        ("latch", device["latch"]),
        ("indicator", device["led"] is not None or device["button"] is not None),
    ):
        if wanted:
            modules.append(module)
    names = ["config.h", "device.h", "main.cpp", *(f"{module}.{end}" for module in modules for end in ("h", "cpp"))]
    files = {f"src/{name}": f"src/{name}.j2" for name in names}
    if device["chips"]:
        files |= {f"lib/NAME/src/NAME_sensors.{end}": f"lib/model/src/sensors.{end}.j2" for end in ("h", "cpp")}
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
    sample_ms = round(program.model.sample_time * 1000.0)
    sensors = _sensors(coefficients, wiring.thermocouples, program, sample_ms)
    memory = _memory(wiring, sensors, program, coefficients.sha256, sample_ms)
    entries = lower_protection(coefficients)
    start_samples = max(2 * CONFIRMATIONS * sensors["read_samples"], math.ceil(_START_MS / sample_ms))
    return {
        **sensors,
        **_inputs(wiring.channels, program, sample_ms),
        **_rows(coefficients, wiring, sensors["chips"]),
        "cold_mK": COLD_mK,
        "baud": wiring.serial_baud,
        "late_ms": max(2, sample_ms // 25),
        "start_samples": start_samples,
        "start_s": f"{start_samples * sample_ms / 1000:g}",
        "led": wiring.led_pin,
        "button": wiring.button_pin,
        "encoder": _encoder(wiring.encoder, document.input.nominal_speed_rpm, sample_ms) if wiring.encoder else None,
        "drive": _drive(wiring.drive, document.input.full_scale, sample_ms) if wiring.drive else None,
        "observe": _observe(wiring.observe) if wiring.observe else None,
        "memory": memory,
        "latch": _latch() if memory and (document.alarms or any(entry.lasts for entry in entries)) else None,
        "relay": _pin(wiring.relay_pin, "$.wiring.relay_pin") if wiring.relay_pin is not None else None,
        "protects": bool(entries),
        "timeout_samples": _samples(wiring.command_timeout_s or 0.0, sample_ms),
        "idle_timers": _idle_timers(wiring),
        "alarms": [alarm.name for alarm in document.alarms],
        "alarm_texts": alarm_texts(coefficients),
    }


def _samples(seconds: float, sample_ms: int) -> int:
    """So many samples are as long or longer."""
    return min(MOST_SAMPLES, math.ceil(seconds * 1000.0 / sample_ms - 1e-9))


def _sensors(
    coefficients: Coefficients, wired: tuple[Thermocouple, ...], program: Program, sample_ms: int
) -> SensorsContext:
    chips = _chips(coefficients, wired, program)
    names = coefficients.document.component_names
    longest_ms = conversion_ms(wired)
    read_samples = reading_samples(program.model.sample_time, longest_ms)
    tables = _platinum_tables(coefficients)
    return {
        "chips": chips,
        "measured": [chip for chip in chips if chip["channel"] in names],
        "column_chips": [chip for chip in chips if chip["column"]],
        "ambient_chip": next((chip for chip in chips if chip["channel"] == "ambient"), None),
        "read_samples": read_samples,
        "reading_ms": read_samples * sample_ms,
        "conversion_ms": longest_ms,
        "conversion_millis": longest_ms + _MILLIS_STEP,
        "confirmations": CONFIRMATIONS,
        "plausible_samples": PLAUSIBLE_SAMPLES,
        "faster": FASTER,
        "noise_counts": NOISE_COUNTS,
        "longest_samples": LONGEST_SAMPLES,
        "kinds": [kind for kind in CHIP_RANGES_degC if kind in {chip["converter"] for chip in chips}],
        "platinum_tables": tables,
        "platinum_bits": SEGMENT_BITS,
        "platinum_range": (LOWEST_COUNTS, HIGHEST_COUNTS),
        "count_mK": COUNT_mK,
    }


def _inputs(wired: Sequence[ChannelInput], program: Program, sample_ms: int) -> InputsContext:
    channels = _channels(wired, program, sample_ms)
    analog = [channel for channel in channels if channel["analog"]]
    return {
        "channels": channels,
        "analog": analog,
        "contacts": [channel for channel in channels if not channel["analog"]],
        "told_pwm": _told(program).get(PWM) if program.model.network is not None else None,
        "conversions": _conversions(len(analog), sample_ms),
        "settling": _SETTLING,
        "didr": [sum(1 << (c["mux"] & 7) for c in analog if c["mux"] // 8 == half) for half in (0, 1)],
    }


def _rows(coefficients: Coefficients, wiring: Wiring, chips: list[ThermocoupleContext]) -> RowsContext:
    sample_time = coefficients.model.sample_time
    samples = max(1, round(wiring.row_every_s / sample_time))
    columns = _columns(coefficients, chips, wiring.encoder is not None, wiring.channels)
    longest = _row_bytes(columns)
    return {
        "row_samples": samples,
        "row_every": f"{samples * sample_time:g}",
        "columns": columns,
        "row_bytes": longest,
        "ring_bytes": 1 << math.ceil(math.log2(longest + max(longest, 2 * _LINE_BYTES))),
        "ambient_column": _ambient_column(coefficients),
    }


def _ambient_column(coefficients: Coefficients) -> str:
    return coefficients.model.ambient_channel or "ambient_degC"


def _columns(
    coefficients: Coefficients, chips: list[ThermocoupleContext], encoder: bool, inputs: Sequence[ChannelInput]
) -> list[str]:
    """The run file's columns, in the order in which the console prints a row."""
    wired = {chip["channel"] for chip in chips}
    names = coefficients.document.component_names
    columns = ["time_s", "pwm", *(f"{name}_degC" for name in names if name in wired)]
    columns += [_ambient_column(coefficients)] if "ambient" in wired else []
    columns += [channel.column for channel in inputs]
    columns += coefficients.document.thermocouple_columns
    columns += ["speed_rpm"] if encoder else []
    columns += [f"{name}_model_degC" for name in names]
    columns += ["flags"]
    columns += ["sensors"] if chips else []
    columns += ["alarms"] if coefficients.document.alarms else []
    columns += ["protection"] if lower_protection(coefficients) else []
    return columns


def _row_bytes(columns: list[str]) -> int:
    """Longest row: each field at its longest (thousandths of 32 bits, 16-bit numbers, 17 digits of sensors), commas."""
    longest = {"time_s": 14, "pwm": 4, "speed_rpm": 5, "flags": 5, "sensors": 17, "alarms": 5, "protection": 11}
    return sum(longest.get(column, 12) + 1 for column in columns) + 1


def _pin(pin: int, path: str) -> Pin:
    letter, bit = port_bit(pin)
    return {"pin": pin, "label": label(pin), "letter": letter, "bit": bit, "path": path}


def _chips(coefficients: Coefficients, wired: tuple[Thermocouple, ...], program: Program) -> list[ThermocoupleContext]:
    names = coefficients.document.component_names
    told = _told(program)
    tables = _platinum_tables(coefficients)
    read_samples = reading_samples(program.model.sample_time, conversion_ms(wired))
    chips: list[ThermocoupleContext] = []
    for number, (chip, limits) in enumerate(zip(wired, sensor_limits(coefficients), strict=True)):
        path = f"$.wiring.thermocouples[{number}]"
        chips.append(
            {
                "number": number,
                "channel": chip.channel,
                "component": names.index(chip.channel) if chip.channel in names else None,
                "column": chip.channel in coefficients.document.thermocouple_columns,
                "told": told.get(chip.channel),
                "lines": {
                    key: _pin(pin, f"{path}.{key}")
                    for key in ("cs", "so", "sck", "sdi")
                    if (pin := getattr(chip, key)) is not None
                },
                "converter": chip.chip,
                "platinum": tables.index(limits.platinum) if limits.platinum else 0,
                "configuration": f"0x{limits.configuration:02X}",
                "resistors": "PT{:g} and {:g} ohm".format(*chip.resistor_ohm) if limits.platinum else "",
                "lowest": limits.lowest,
                "highest": limits.highest,
                "lowest_degC": f"{limits.lowest * COUNT_mK / 1000:g}",
                "highest_degC": f"{limits.highest * COUNT_mK / 1000:g}",
                "step": limits.step,
                "max_rate": f"{chip.max_rate_K_per_s:g}",
                "stuck_samples": limits.stuck_samples,
                "stuck_mK": limits.stuck_mK,
                "stuck_text": _stuck_text(limits, coefficients.model.sample_time * read_samples),
            }
        )
    return chips


def _platinum_tables(coefficients: Coefficients) -> list[tuple[int, ...]]:
    """Each pair of resistors has one."""
    return list(dict.fromkeys(item.platinum for item in sensor_limits(coefficients) if item.platinum))


def _stuck_text(limits: SensorLimits, interval_s: float) -> str:
    if not limits.stuck_samples:
        return "not checked for being stuck"
    after = f"stuck after {limits.stuck_samples * interval_s:g} s"
    return after + (f" in which the model moved by {limits.stuck_mK / 1000:g} K" if limits.stuck_mK else "")


def _told(program: Program) -> dict[str, str]:
    """Names in the C++ of the columns that the model is told."""
    columns = [channel.column for channel in program.channels]
    return dict(zip(columns, channel_names(program.channels), strict=True))


def _conversions(voltages: int, sample_ms: int) -> int:
    """How many conversions of each voltage are done well within a sample."""
    for count in _CONVERSIONS:
        if (voltages * count + _SETTLING) * _CONVERSION_CYCLES / 16e3 < 0.8 * sample_ms:
            break
    return count


def _channels(wired: Sequence[ChannelInput], program: Program, sample_ms: int) -> list[InputContext]:
    """Inputs of the wiring; a voltage's value is zero + (sum of conversions times scale >> shift), in thousandths."""
    told = {channel.column: channel for channel in program.channels}
    names = _told(program)
    conversions = _conversions(sum(channel.analog_pin is not None for channel in wired), sample_ms)
    found: list[InputContext] = []
    for number, channel in enumerate(wired):
        path = f"$.wiring.channels[{number}]"
        low, high = (round(value * 1000.0) for value in channel.limits)
        own = told.get(channel.column)
        pin = channel.analog_pin if channel.analog_pin is not None else channel.contact_pin
        assert pin is not None
        for_each = channel.per_V * SUPPLY_V * 1000.0 / (1024.0 * conversions)
        shift = max(0, min(30, _SCALE_BITS - 1 - math.floor(math.log2(abs(for_each)))))
        found.append(
            {
                **_pin(pin, path),
                "number": number,
                "column": channel.column,
                "analog": channel.analog_pin is not None,
                "mux": pin - 54 if channel.analog_pin is not None else 0,
                "zero": round(-channel.zero_V * channel.per_V * 1000.0),
                "scale": round(for_each * 2**shift),
                "shift": shift,
                "low": low,
                "high": high,
                "neutral": own.neutral if own is not None else min(max(0, low), high),
                "told": names.get(channel.column),
            }
        )
    return found


def _encoder(encoder: Encoder, nominal_rpm: float, sample_ms: int) -> EncoderContext:
    fastest_rpm = nominal_rpm * _MARGIN
    fastest = fastest_rpm / 60.0 * encoder.pulses_per_revolution * sample_ms / 1000.0
    # pulses * factor must fit 32 bits; the clock of micros() has steps of 4 us
    shift = max(2, math.ceil(math.log2(fastest_rpm * _MARGIN * sample_ms * 1000.0)) - 32)
    factor = max(1, round(60e6 / 2**shift / encoder.pulses_per_revolution))
    return {
        **_pin(encoder.pin, "$.wiring.encoder.pin"),
        "counter": encoder.counts_in_hardware,
        "interrupt": INTERRUPTS.get(encoder.pin),
        "pulses_per_revolution": encoder.pulses_per_revolution,
        "shift": shift,
        "unit_us": 2**shift,
        "factor": factor,
        "most": (2**32 - 1) // factor,
        "wide": _LATE_SAMPLES * fastest >= 65535.0,
        "limit": math.ceil(_LATE_SAMPLES * fastest),
        "fastest_rpm": math.ceil(fastest_rpm),
        "shortest_us": sample_ms * 250,
        "overspeed_rpm": math.ceil(nominal_rpm * _OVERSPEED),
        "turning_rpm": math.ceil(nominal_rpm * _TURNING),
        "stall_pwm": encoder.stall_pwm,
        "stall_samples": max(1, math.ceil(encoder.stall_s * 1000.0 / sample_ms)),
        "stall_s": f"{encoder.stall_s:g}",
    }


def _drive(drive: Drive, full_scale: int, sample_ms: int) -> DriveContext:
    steps = drive.profile.steps if drive.profile else ()
    lines = {key: getattr(drive, f"{key}_pin") for key in ("forward", "reverse", "pwm", "direction")}
    pins = {key: None if pin is None else _pin(pin, f"$.wiring.drive.{key}_pin") for key, pin in lines.items()}
    of_timer = {key.removesuffix("_pin"): PWM_TIMERS[pin] for key, pin in drive.pwm_pins.items()}
    return {
        "forward": pins["forward"],
        "reverse": pins["reverse"],
        "pwm": pins["pwm"],
        "direction": pins["direction"],
        "forward_high": drive.forward_is_high,
        "timers": [
            {
                "number": timer,
                "runs": TIMER_RUNS[timer],
                "lines": [key for key, own in of_timer.items() if own == timer],
            }
            for timer in sorted({*of_timer.values()} - {0})
        ],
        "steps": [
            {
                "samples": max(1, round(step.duration_s * 1000.0 / sample_ms)),
                "pwm": step.pwm,
                "s": f"{step.duration_s:g}",
            }
            for step in steps
        ],
        "pause_samples": _samples(drive.reversal_pause_s, sample_ms),
        "ramp_step": _ramp_step(drive.ramp_s, full_scale, sample_ms),
        "repeat": bool(drive.profile and drive.profile.repeat),
        "autostart": bool(drive.profile and drive.profile.autostart),
    }


def _ramp_step(ramp_s: float, full_scale: int, sample_ms: int) -> int:
    """By how much |PWM| may rise in a sample, in 256ths of a count; 0: by anything."""
    step = 256.0 * full_scale * sample_ms / 1000.0 / ramp_s if ramp_s else 0.0
    return 0 if step >= 256.0 * full_scale else math.ceil(step)


def _observe(observe: Observe) -> ObserveContext:
    reverse = observe.reverse_pin
    return {
        "forward": _pin(observe.forward_pin, "$.wiring.observe.forward_pin"),
        "reverse": _pin(reverse, "$.wiring.observe.reverse_pin") if reverse is not None else None,
    }


def _memory(
    wiring: Wiring, sensors: SensorsContext, program: Program, sha256: str, sample_ms: int
) -> MemoryContext | None:
    """The copies in EEPROM; none without a measured component, because nothing could tell whether a copy is fresh."""
    if wiring.memory is None or not sensors["measured"]:
        return None
    record = _RECORD_FIXED + 2 * len(sensors["chips"]) + state_bytes(program)
    slots = _LATCH_AT // record
    # "normal" stands for a kind of step; it stays, because any other word would make boards drop their copies.
    identity = zlib.crc32(f"{__version__} {sha256} {program.arithmetic} {program.schedule} normal".encode())
    years = EEPROM_CYCLES * slots * wiring.memory.interval_s / (365.25 * 86400)
    return {
        "cycles": f"{EEPROM_CYCLES:,}".replace(",", " "),
        "identity": f"0x{identity:08X}UL",
        "record_bytes": record,
        "slots": slots,
        "firmware_at": EEPROM_BYTES - _FIRMWARE_BYTES,
        "interval_samples": max(record, math.ceil(wiring.memory.interval_s * 1000.0 / sample_ms)),
        "interval_s": f"{wiring.memory.interval_s:g}",
        "tolerance_counts": max(1, round(wiring.memory.tolerance_K * 1000.0 / COUNT_mK)),
        "tolerance_K": f"{wiring.memory.tolerance_K:g}",
        "years": f"{years:.0f}" if years >= 10 else f"{years:.1f}",
    }


def _latch() -> LatchContext:
    return {"at": _LATCH_AT, "slots": _LATCH_SLOTS, "bytes": _LATCH_BYTES}


def state_bytes(program: Program) -> int:
    """Bytes of the model's states on the board (checked there at compile time)."""
    if program.network is not None:
        return int(np.dtype(network_state_fields(program.network)).itemsize)
    effects = effect_fields(program.effects, program.components) if program.effects is not None else []
    own = [AMBIENT_FIELD] if program.ambient is not None else []
    every = (*map(state_fields, program.components), own, effects)
    return sum(np.dtype(fields).itemsize for fields in every if fields)


def _idle_timers(wiring: Wiring) -> list[int]:
    """Timers that this wiring never uses."""
    used = {PWM_TIMERS[pin] for pin in wiring.drive.pwm_pins.values()} if wiring.drive else set()
    if wiring.encoder and wiring.encoder.counts_in_hardware:
        used.add(5)
    return [timer for timer in range(1, 6) if timer not in used]
