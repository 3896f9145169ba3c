"""Places at the Mega for everything that is measured or driven."""

from __future__ import annotations

import re
from functools import partial

from gen.coefficients.messages import building
from gen.coefficients.wiring import SUPPLY_V, ChannelInput, Drive, Encoder, Thermocouple, Wiring
from gen.errors import InputError
from gen.proposal.motor import Motor, Range

_FIRST_SELECT = 22
_DATA, _CLOCK = 50, 52
_LED, _BUTTON = 13, 48
_FORWARD, _REVERSE = 6, 7
_ENCODER = 47
_FIRST_ANALOG, _ANALOG_PINS = 54, 16
_MOST_CHIPS = 17
_COLUMN = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")
_HALL = (20.0, 10.0, "an ACS712 of 20 A (0.1 V/A, 2.5 V at 0 A)"), (30.0, 1.0 / 0.066, "an ACS712 of 30 A (66 mV/A)")
"""Current that it stands, A; A for each volt; what it is."""
_DIVIDED_V = 30.0


def wiring_for(motor: Motor, source: str) -> Wiring:
    """Give every sensor of a motor its pins.

    Parameters
    ----------
    motor
        What is known of it.
    source
        What that is known from, for the note.

    Raises
    ------
    InputError
        When there is more than a Mega has pins for, or a column's name cannot be one of the board's rows.
    """
    chips = _thermocouples(motor)
    if len(chips) > _MOST_CHIPS or len(motor.channels) > _ANALOG_PINS:
        raise InputError(
            f"{len(chips)} thermocouples and {len(motor.channels)} channels; the sketch takes at most {_MOST_CHIPS} "
            f"and {_ANALOG_PINS}"
        )
    with building():
        channels = tuple(_channel(i, *item) for i, item in enumerate(motor.channels.items()))
        made = partial(
            Wiring,
            led_pin=_LED,
            button_pin=_BUTTON,
            thermocouples=tuple(chips),
            drive=Drive(
                forward_pin=_FORWARD,
                reverse_pin=_REVERSE,
                note="A driver with a PWM input for each direction. Both pins are Timer 4's, so both directions have "
                "one frequency. For a driver with a direction input: pwm_pin and direction_pin instead; if another "
                "controller drives: observe.",
            ),
            encoder=None if motor.speed is None else _encoder(motor.speed),
            note=f"Started by gen init from {source}: pins that are free and can do it. Change them to those of your "
            f"board. LED on {_LED}: the Mega's own; button on {_BUTTON}, to ground, resets alarms.",
        )
        return made(channels=channels) if channels else made()


def _thermocouples(motor: Motor) -> list[Thermocouple]:
    named = [(part, "a part that is watched: sensor checks, alarm rules") for part in motor.parts]
    named += [("ambient", motor.ambient)] if motor.ambient is not None else []
    named += [(column, f"{why}: logged, and told to what reads it") for column, why in motor.beside.items()]
    shared = f"MAX6675. SO {_DATA} and SCK {_CLOCK} are shared by all; CS is the next free pin from {_FIRST_SELECT} on"
    return [
        Thermocouple(channel=name, cs=_FIRST_SELECT + i, so=_DATA, sck=_CLOCK, note=f"{why}. {shared}.")
        for i, (name, why) in enumerate(named)
    ]


def _encoder(why: str) -> Encoder:
    return Encoder(
        pin=_ENCODER,
        pulses_per_revolution=1,
        note=f"{why}. TO BE SET: pulses_per_revolution, which no log tells; 1 stands for it. Pin {_ENCODER} counts in "
        "hardware, whatever the pulses' rate.",
    )


def _channel(number: int, column: str, known: tuple[Range | None, str]) -> ChannelInput:
    """An analog input for a column: of a usual sensor for currents and voltages, else 0..5 V for its range."""
    spread, why = known
    if not _COLUMN.fullmatch(column):
        raise InputError(f'the column "{column}" cannot be one of the board\'s: a letter, then letters, digits or _')
    pin = _FIRST_ANALOG + number
    unit = column.rpartition("_")[2]
    if unit == "A":
        most = max(abs(spread[0]), abs(spread[1])) if spread is not None else 0.0
        fits = [sensor for sensor in _HALL if sensor[0] >= most]
        if fits:
            _, per_V, sensor = fits[0]
            return ChannelInput(
                column=column,
                analog_pin=pin,
                zero_V=SUPPLY_V / 2.0,
                per_V=float(f"{per_V:.6g}"),
                note=f"{why}. TO BE SET: as {sensor}; put in your sensor's.",
            )
    if unit == "V" and (spread is None or (spread[0] >= 0.0 and spread[1] <= _DIVIDED_V)):
        return ChannelInput(
            column=column,
            analog_pin=pin,
            per_V=_DIVIDED_V / SUPPLY_V,
            note=f"{why}. TO BE SET: as a divider by {_DIVIDED_V / SUPPLY_V:g} (0..{_DIVIDED_V:g} V); put in yours.",
        )
    return _over_range(column, pin, spread, why)


def _over_range(column: str, pin: int, spread: Range | None, why: str) -> ChannelInput:
    low, high = spread if spread is not None and spread[0] < spread[1] else (0.0, 100.0)
    bottom, top = min(low, 0.0), max(high, 0.0)
    per_V = max((top - bottom) / SUPPLY_V, 1e-3)
    told = "its range" if spread is not None else "0..100, as nothing tells its range"
    return ChannelInput(
        column=column,
        analog_pin=pin,
        zero_V=float(f"{-bottom / per_V:.6g}") + 0.0,
        per_V=float(f"{per_V:.6g}"),
        min=low,
        max=high,
        note=f"{why}. TO BE SET: as a sensor of 0..5 V for {told}; put in yours.",
    )
