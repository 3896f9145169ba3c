"""All wiring of a board, and what must hold between its parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Annotated, Literal

from pydantic import Field, model_validator

from gen.coefficients.base import Note, Part, Positive, fault
from gen.coefficients.wiring.drive import DRIVE_PINS, Drive, Observe
from gen.coefficients.wiring.pins import (
    BOOT_LED_PIN,
    COUNTER_TIMER_PINS,
    PINS_OF,
    BoardName,
    BoardPins,
    Pin,
    Role,
    check_free,
    roles,
    spans,
)
from gen.coefficients.wiring.sensors import ChannelInput, Encoder, Thermocouple
from gen.coefficients.wiring.supply import Supply


class Memory(Part):
    """The copy of the model's states in EEPROM."""

    interval_s: Annotated[Positive, Field(ge=60, le=1e6, description="Time between two copies.")] = 600.0
    tolerance_K: Annotated[
        Positive,
        Field(
            le=100,
            description="After a reset a copy is used if no measured temperature has moved by more than this since.",
        ),
    ] = 2.0


class Zero(Part):
    """What each thermocouple reads too much, learnt at a cold start."""

    tolerance_K: Annotated[
        Positive,
        Field(
            le=10,
            description="No sensor is off by more; what is farther from the others' median is no sensor's offset, and "
            "nothing is learnt.",
        ),
    ] = 2.0
    automatic: Annotated[
        bool, Field(description="Also by itself, where the model says that a motor has long cooled down.")
    ] = True


class Wiring(Part):
    """All pins; one pin has one role, except that clock and data lines may be shared."""

    board: Annotated[BoardName, Field(description="The Arduino Mega 2560, or the Uno (ATmega328P).")] = "mega"
    serial_baud: Literal[9600, 19200, 38400, 57600, 76800, 115200, 250000, 500000, 1000000] = 115200
    row_every_s: Annotated[Positive, Field(le=3600, description="Time between two rows on the serial line.")] = 1.0
    led_pin: Pin | None = None
    button_pin: Annotated[Pin | None, Field(description="To ground; resets latched alarms.")] = None
    relay_pin: Annotated[
        Pin | None,
        Field(
            description="High while the motor may have its supply: a relay or contactor, with a pull-down at its input."
        ),
    ] = None
    command_timeout_s: Annotated[
        Positive | None,
        Field(le=3600, description="A PWM by command ends when no line that is obeyed came for this long."),
    ] = None
    thermocouples: Annotated[tuple[Thermocouple, ...], Field(max_length=17)] = ()
    encoder: Encoder | None = None
    channels: Annotated[
        tuple[ChannelInput, ...], Field(max_length=16, description="Inputs beside the thermocouples.")
    ] = ()
    drive: Drive | None = None
    observe: Observe | None = None
    memory: Annotated[Memory | None, Field(description="null: no copies.")] = Memory()
    zero: Annotated[Zero | None, Field(description="Sensors' offsets are learnt while the motor is cold.")] = None
    supply: Annotated[Supply | None, Field(description="Measure the board's own supply, for the cause supply_low.")] = (
        None
    )
    note: Note | None = None

    @property
    def own_supply(self) -> Supply:
        """How the supply is measured where it is; of a file that says nothing what holds for every chip."""
        return self.supply or Supply()

    @model_validator(mode="after")
    def _check(self) -> Wiring:
        pins = PINS_OF[self.board]
        _check_there(_all_roles(self), pins)
        if self.encoder:
            _check_encoder(self.encoder, pins)
        if self.drive:
            _check_pwm_pins(self.drive, self.encoder, pins)
        if self.drive and self.observe:
            raise fault('found both "drive" and "observe"; expected one of them: who drives the motor?', "observe")
        if self.command_timeout_s is not None and self.drive is None:
            raise fault('found it without "drive"; expected one: nothing else follows commands', "command_timeout_s")
        if self.relay_pin == BOOT_LED_PIN:
            raise fault(
                f"pin {BOOT_LED_PIN} is the boot loader's LED: the relay would close at every reset; expected another",
                "relay_pin",
            )
        _check_columns_differ(self.channels)
        check_free(_all_roles(self))
        return self

    def printed_columns(self, components: Sequence[str]) -> set[str]:
        """Columns of the board's rows whose names are not of the file's choice, for a model with these components."""
        measured = [f"{chip.channel}_degC" for chip in self.thermocouples if chip.channel in components]
        speed = ["speed_rpm"] if self.encoder else []
        models = [f"{name}_model_degC" for name in components]
        return {"time_s", "pwm", *measured, *speed, *models, "flags", "sensors", "alarms", "protection"}


def _check_there(taken: Iterable[Role], pins: BoardPins) -> None:
    """The board has each pin, and voltages lie where it converts them."""
    for role in taken:
        if role.pin >= pins.pins:
            raise fault(f"{pins.name} has no pin {role.pin}; expected 0..{pins.pins - 1}", *role.at)
        if role.at[-1] == "analog_pin" and role.pin < pins.first_analog:
            raise fault(
                f"pin {role.pin} of {pins.name} measures no voltage; expected {pins.first_analog}..{pins.pins - 1}",
                *role.at,
            )


def _check_encoder(encoder: Encoder, pins: BoardPins) -> None:
    """Something counts the pulses."""
    if encoder.counts_in_hardware:
        if pins.counter is None:
            raise fault(f'no timer of {pins.name} is free to count; expected "interrupt"', "encoder", "method")
        if encoder.pin != pins.counter:
            raise fault(f"pin {encoder.pin} is no counter's input; expected {pins.counter}", "encoder", "pin")
    elif encoder.pin not in pins.interrupts:
        counted = f" (or {pins.counter}, counted in hardware)" if pins.counter is not None else ""
        raise fault(
            f"pin {encoder.pin} has no external interrupt; expected one of {spans(pins.interrupts)}{counted}",
            "encoder",
            "pin",
        )


def _check_pwm_pins(drive: Drive, encoder: Encoder | None, pins: BoardPins) -> None:
    """The motor's pins have PWM, leave the motor alone at a reset, and leave the encoder its timer."""
    timer_5 = encoder is not None and encoder.counts_in_hardware
    for key, pin in drive.pwm_pins.items():
        if pin not in pins.pwm:
            raise fault(f"pin {pin} has no PWM; expected one of {spans(pins.pwm)}", "drive", key)
        if pin == BOOT_LED_PIN:
            raise fault(
                f"pin {BOOT_LED_PIN} is the boot loader's LED: the motor would run at every reset before the "
                "firmware does; expected another pin",
                "drive",
                key,
            )
        if pin in pins.clock_timer and drive.frequency_Hz != Drive.model_fields["frequency_Hz"].default:
            raise fault(
                f"the PWM of pin {pin} is Timer 0's, which keeps the time: it stays at 976 Hz; expected another pin, "
                'or no "frequency_Hz"',
                "drive",
                key,
            )
        if timer_5 and pin in COUNTER_TIMER_PINS:
            raise fault(
                f"the PWM of pin {pin} is Timer 5's, which counts the encoder's pulses; expected another pin",
                "drive",
                key,
            )


def _check_columns_differ(channels: Sequence[ChannelInput]) -> None:
    taken: set[str] = set()
    for i, channel in enumerate(channels):
        if channel.column.lower() in taken:
            raise fault(f'"{channel.column}" is taken already; expected one each', "channels", i, "column")
        taken.add(channel.column.lower())


def _all_roles(wiring: Wiring) -> Iterator[Role]:
    yield from roles(wiring, ("led_pin", "button_pin", "relay_pin"))
    yield from roles(wiring.encoder, ("pin",), "encoder", name="encoder")
    yield from roles(wiring.drive, DRIVE_PINS, "drive")
    yield from roles(wiring.observe, DRIVE_PINS, "observe")
    for i, channel in enumerate(wiring.channels):
        yield from roles(channel, ("analog_pin", "contact_pin"), "channels", i, name=f"channel {channel.column}")
    for i, thermocouple in enumerate(wiring.thermocouples):
        yield from roles(thermocouple, ("cs", "so", "sck", "sdi", "analog_pin"), "thermocouples", i)
