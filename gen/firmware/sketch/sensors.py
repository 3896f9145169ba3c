"""The converter chips, and the checks of their samples."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import TypedDict

from gen.coefficients import Coefficients
from gen.coefficients.wiring import CHIP_RANGES_degC, Thermocouple
from gen.firmware.boards import Board
from gen.firmware.contexts.channels import told_channels
from gen.firmware.sketch.converter import ConvertedInput, converted
from gen.firmware.sketch.pin import Pin, pin_context
from gen.lowering.platinum import HIGHEST_COUNTS, LOWEST_COUNTS, SEGMENT_BITS
from gen.lowering.program import Program
from gen.lowering.sensors import (
    CONFIRMATIONS,
    FASTER,
    LONGEST_SAMPLES,
    MOST_RISING_COUNTS,
    NOISE_COUNTS,
    PLAUSIBLE_SAMPLES,
    COUNT_mK,
    SensorLimits,
    conversion_ms,
    reading_samples,
    sensor_limits,
)
from gen.lowering.thermistor import CONVERSIONS, FINE_BITS, MOST_SUM
from gen.lowering.thermistor import SEGMENT_BITS as SUM_BITS

MILLIS_STEP = 2
"""By how much millis() may run ahead within a difference: it counts every 1.024 ms, two at a time now and then."""


class ThermocoupleContext(TypedDict):
    """A sensor with its chip; limits are in counts of 0.25 degC, `component` is None where none has the channel.

    `platinum` is the number of its table, `configuration` what its first register holds (a MAX31865's).
    An NTC has no lines but `analog`, `input` is its number at the converter, `thermistor` that of its table.
    """

    number: int
    channel: str
    component: int | None
    column: bool
    told: str | None
    lines: dict[str, Pin]
    analog: Pin | None
    input: int
    converter: str
    platinum: int
    configuration: str
    thermistor: int
    sums: tuple[int, int]
    to_supply: bool
    series: str
    resistors: str
    lowest: int
    highest: int
    lowest_degC: str
    highest_degC: str
    step: int
    max_rate: str
    stuck_samples: int
    stuck_mK: int
    stuck_text: str


class SensorsContext(TypedDict):
    """The thermocouples, and the checks of their samples.

    `measured` are those at a component, `column_chips` those whose temperature is a column of its own, `ambient_chip`
    the one of the surroundings. `kinds` are the chips that there are, `platinum_tables` counts at every 1024th code of
    a MAX31865, `platinum_range` where they end; `thermistor_tables` 64ths of a degree at every 32nd sum of an NTC's
    conversions, which is `thermistor_most` at most.
    """

    chips: list[ThermocoupleContext]
    measured: list[ThermocoupleContext]
    column_chips: list[ThermocoupleContext]
    ambient_chip: ThermocoupleContext | None
    read_samples: int
    reading_ms: int
    conversion_ms: int
    conversion_millis: int
    confirmations: int
    plausible_samples: int
    most_rising_counts: int
    faster: int
    noise_counts: int
    longest_samples: int
    kinds: list[str]
    platinum_tables: list[tuple[int, ...]]
    platinum_bits: int
    platinum_range: tuple[int, int]
    thermistor_tables: list[tuple[int, ...]]
    thermistor_bits: int
    thermistor_fine_bits: int
    thermistor_most: int
    thermistor_conversions: int
    count_mK: int


def sensors_context(
    board: Board,
    coefficients: Coefficients,
    wired: tuple[Thermocouple, ...],
    program: Program,
    sample_ms: int,
    first_input: int,
) -> SensorsContext:
    """Describe the chips of a wiring, in its order; a sample has so many ms, the first NTC that converter's input."""
    chips = _chips(board, coefficients, wired, program, first_input)
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
        "conversion_millis": longest_ms + MILLIS_STEP,
        "confirmations": CONFIRMATIONS,
        "plausible_samples": PLAUSIBLE_SAMPLES,
        "most_rising_counts": MOST_RISING_COUNTS,
        "faster": FASTER,
        "noise_counts": NOISE_COUNTS,
        "longest_samples": LONGEST_SAMPLES,
        "kinds": [kind for kind in CHIP_RANGES_degC if kind in {chip["converter"] for chip in chips}],
        "platinum_tables": tables,
        "platinum_bits": SEGMENT_BITS,
        "platinum_range": (LOWEST_COUNTS, HIGHEST_COUNTS),
        "thermistor_tables": _thermistor_tables(coefficients),
        "thermistor_bits": SUM_BITS,
        "thermistor_fine_bits": FINE_BITS,
        "thermistor_most": MOST_SUM,
        "thermistor_conversions": CONVERSIONS,
        "count_mK": COUNT_mK,
    }


def thermistor_inputs(board: Board, wired: Sequence[Thermocouple]) -> list[ConvertedInput]:
    """What the converter does for NTCs, in the wiring's order; the first conversion after another pin's is left out."""
    return [
        converted(f"$.wiring.thermocouples[{number}]: pin {board.label(pin)}", board.mux(pin), CONVERSIONS, 1)
        for number, chip in enumerate(wired)
        if (pin := chip.analog_pin) is not None
    ]


def _chips(
    board: Board, coefficients: Coefficients, wired: tuple[Thermocouple, ...], program: Program, first_input: int
) -> list[ThermocoupleContext]:
    names = coefficients.document.component_names
    told = told_channels(program)
    tables, thermistors = _platinum_tables(coefficients), _thermistor_tables(coefficients)
    read_samples = reading_samples(program.model.sample_time, conversion_ms(wired))
    following = count(first_input)
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
                    key: pin_context(board, pin, f"{path}.{key}")
                    for key in ("cs", "so", "sck", "sdi")
                    if (pin := getattr(chip, key)) is not None
                },
                "analog": pin_context(board, chip.analog_pin, f"{path}.analog_pin")
                if chip.analog_pin is not None
                else None,
                "input": next(following) if chip.analog_pin is not None else 0,
                "converter": chip.chip,
                "platinum": tables.index(limits.platinum) if limits.platinum else 0,
                "configuration": f"0x{limits.configuration:02X}",
                "thermistor": thermistors.index(limits.thermistor) if limits.thermistor else 0,
                "sums": limits.sums,
                "to_supply": limits.to_supply,
                "series": f"{chip.series_ohm:g}" if chip.series_ohm is not None else "",
                "resistors": _resistors_text(chip),
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


def _thermistor_tables(coefficients: Coefficients) -> list[tuple[int, ...]]:
    """Each kind of divider has one."""
    return list(dict.fromkeys(item.thermistor for item in sensor_limits(coefficients) if item.thermistor))


def _resistors_text(chip: Thermocouple) -> str:
    if chip.chip == "MAX31865":
        return "PT{:g} and {:g} ohm".format(*chip.resistor_ohm)
    if chip.chip != "NTC":
        return ""
    if chip.steinhart_hart is not None:
        curve = "1/T = {:g} + {:g} ln R + {:g} (ln R)^3".format(*chip.steinhart_hart)
    else:
        curve = f"{chip.r25_ohm:g} ohm at 25 degC and B {chip.beta_K:g} K"
    return f"{curve}, to {chip.thermistor_to or 'ground'}, with {chip.series_ohm:g} ohm"


def _stuck_text(limits: SensorLimits, interval_s: float) -> str:
    if not limits.stuck_samples:
        return "not checked for being stuck"
    after = f"stuck after {limits.stuck_samples * interval_s:g} s"
    return after + (f" in which the model moved by {limits.stuck_mK / 1000:g} K" if limits.stuck_mK else "")
