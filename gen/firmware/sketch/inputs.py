"""Voltages and contacts beside the thermocouples."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypedDict

from gen.coefficients.wiring import SUPPLY_V, ChannelInput
from gen.firmware.boards import Board
from gen.firmware.contexts.channels import told_channels
from gen.firmware.sketch.converter import STEPS, ConvertedInput, converted, round_ms
from gen.firmware.sketch.pin import Pin, pin_context
from gen.lowering.program import Program
from gen.model.network_parts import PWM

_CONVERSIONS = (55, 18)
"""Conversions of a voltage that are added up for a value; the first number that fits into a sample. They last about 3
periods, or 1, of 490 Hz PWM (6 or 2 of 976 Hz): with other lengths, parts of a period would show in a current that the
motor's driver chops. The sum has 16 bits."""
_SCALE_BITS = 15
"""Of the factor that such a sum is multiplied by."""


class InputContext(Pin):
    """A voltage or a contact: zero + (sum of conversions times scale >> shift), in thousandths."""

    number: int
    column: str
    analog: bool
    zero: int
    scale: int
    shift: int
    low: int
    high: int
    neutral: int
    told: str | None


class InputsContext(TypedDict):
    """Voltages and contacts; `conversions` make a voltage.

    `told_pwm` is the channel's name in the C++ where a network reads PWM with its sign.
    """

    channels: list[InputContext]
    analog: list[InputContext]
    contacts: list[InputContext]
    told_pwm: str | None
    conversions: int


def inputs_context(
    board: Board, wired: Sequence[ChannelInput], program: Program, sample_ms: int, others: Sequence[ConvertedInput]
) -> InputsContext:
    """Describe the inputs of a board's wiring, in its order; a sample has so many ms, of which `others` take some."""
    conversions = _conversions(sum(channel.analog_pin is not None for channel in wired), sample_ms, others)
    channels = _channels(board, wired, program, conversions)
    return {
        "channels": channels,
        "analog": [channel for channel in channels if channel["analog"]],
        "contacts": [channel for channel in channels if not channel["analog"]],
        "told_pwm": told_channels(program).get(PWM) if program.model.network is not None else None,
        "conversions": conversions,
    }


def converted_inputs(board: Board, inputs: InputsContext) -> list[ConvertedInput]:
    """What the converter does for them, in the order of the voltages."""
    return [
        converted(f"{c['path']}: pin {c['label']}", board.mux(c["pin"]), inputs["conversions"])
        for c in inputs["analog"]
    ]


def _conversions(voltages: int, sample_ms: int, others: Sequence[ConvertedInput]) -> int:
    """How many conversions of each voltage are done well within a sample."""
    for count in _CONVERSIONS:
        if round_ms([*others, *(converted("", 0, count) for _ in range(voltages))]) < 0.8 * sample_ms:
            break
    return count


def _channels(board: Board, wired: Sequence[ChannelInput], program: Program, conversions: int) -> list[InputContext]:
    """Inputs of the wiring; a voltage's value is zero + (sum of conversions times scale >> shift), in thousandths."""
    told = {channel.column: channel for channel in program.channels}
    names = told_channels(program)
    found: list[InputContext] = []
    for number, channel in enumerate(wired):
        path = f"$.wiring.channels[{number}]"
        low, high = (round(value * 1000.0) for value in channel.limits)
        own = told.get(channel.column)
        pin = channel.analog_pin if channel.analog_pin is not None else channel.contact_pin
        assert pin is not None
        for_each = channel.per_V * SUPPLY_V * 1000.0 / (STEPS * conversions)
        shift = max(0, min(30, _SCALE_BITS - 1 - math.floor(math.log2(abs(for_each)))))
        found.append(
            {
                **pin_context(board, pin, path),
                "number": number,
                "column": channel.column,
                "analog": channel.analog_pin is not None,
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
