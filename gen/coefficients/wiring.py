"""The board's wiring: which pin of the Mega carries what, and what is plausible on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator
from pydantic.config import JsonDict

from gen.coefficients.base import Celsius, NotNegative, Part, Positive, fault, listed

Pin = Annotated[int, Field(ge=0, le=69, description="Arduino pin number of the Mega 2560 (54..69 are A0..A15).")]
Duty = Annotated[int, Field(ge=-255, le=255)]

_PWM_PINS = frozenset([*range(2, 14), 44, 45, 46])
_INTERRUPT_PINS = frozenset([2, 3, 18, 19, 20, 21])
_BOOT_LED_PIN = 13
"""The stock boot loader holds it high for a second or so after every reset."""
COUNTER_PIN = 47
"""The one header pin that clocks a timer which the Arduino core does not need (T5 of Timer 5)."""
_COUNTER_TIMER_PINS = frozenset([44, 45, 46])
_PAIR = ("forward_pin", "reverse_pin")
_SIGNED = ("pwm_pin", "direction_pin")
_SHARED = frozenset(["so", "sck"])
"""Roles that several thermocouple amplifiers may share: only the selected one drives or reads its line."""

MAX6675_HIGHEST = 1023.75
"""What the largest count of a MAX6675 means, in degC."""


SUPPLY_V = 5.0
"""What the converter compares voltages with."""
MOST_VALUE = 1e5
"""No channel's value is larger, in its unit."""

LEAST_PER_V = 1e-3
"""The board holds thousandths of the unit."""


class Thermocouple(Part):
    """One MAX6675 on bit-banged SPI, and what is plausible from it; a sample beyond that is not used."""

    channel: Annotated[
        str,
        Field(
            description='A component\'s name, "ambient", or a column that is neither, such as gearbox_degC: it is '
            "logged, and told to effects."
        ),
    ]
    cs: Pin
    so: Pin
    sck: Pin
    min_degC: Annotated[
        Celsius | None,
        Field(description="Lowest plausible temperature; without it the domain's lowest (ambient: 10 K less)."),
    ] = None
    max_degC: Annotated[
        Celsius | None,
        Field(
            le=MAX6675_HIGHEST,
            description="Highest plausible temperature; without it 100 K over the domain's highest, so that an "
            "over-temperature is still seen (ambient: 10 K over).",
        ),
    ] = None
    max_rate_K_per_s: Annotated[
        Positive, Field(le=1000, description="A change faster than this, beyond 1 K of noise, is a jump.")
    ] = 5.0
    stuck_s: Annotated[
        Positive | None,
        Field(
            le=1e6,
            description="The same count for this long is a stuck sensor, provided that the model moved by stuck_K "
            "meanwhile. Without it 300 s; where there is no model (ambient, columns) there is no check.",
        ),
    ] = None
    stuck_K: Annotated[
        NotNegative | None,
        Field(
            le=1000,
            description="See stuck_s; 0: time alone decides. Without it 3 K; ambient and columns 0.",
        ),
    ] = None

    @model_validator(mode="after")
    def _check(self) -> Thermocouple:
        if self.min_degC is not None and self.max_degC is not None and self.min_degC >= self.max_degC:
            raise fault(f"found {self.max_degC:g}, expected more than min_degC, which is {self.min_degC:g}", "max_degC")
        return self


class Encoder(Part):
    """Speed feedback."""

    pin: Pin
    pulses_per_revolution: Annotated[int, Field(ge=1, le=65535)]
    method: Annotated[
        Literal["interrupt", "counter"] | None,
        Field(description="counter: Timer 5 counts, on pin 47 only. Without it: counter on pin 47, else interrupt."),
    ] = None
    stall_pwm: Annotated[int, Field(ge=1, le=255, description="|PWM| from which on the motor must turn.")] = 51
    stall_s: Annotated[Positive, Field(le=3600, description="No pulse for this long at such a PWM is a stall.")] = 2.0

    @property
    def counts_in_hardware(self) -> bool:
        """Whether Timer 5 counts the pulses."""
        return self.method == "counter" or (self.method is None and self.pin == COUNTER_PIN)

    @model_validator(mode="after")
    def _check(self) -> Encoder:
        if self.counts_in_hardware and self.pin != COUNTER_PIN:
            raise fault(f"pin {self.pin} is no counter's input; expected {COUNTER_PIN}", "pin")
        if not self.counts_in_hardware and self.pin not in _INTERRUPT_PINS:
            raise fault(
                f"pin {self.pin} has no external interrupt; expected one of 2, 3, 18, 19, 20, 21 "
                f"(or {COUNTER_PIN}, counted in hardware)",
                "pin",
            )
        return self


class ChannelInput(Part):
    """What effects are told beside the PWM, and run files hold: a voltage, or a contact to ground."""

    column: Annotated[
        str,
        Field(
            pattern=r"^[A-Za-z][A-Za-z0-9_]{0,30}$",
            description="Its column in run files, the unit at the end: current_A.",
        ),
    ]
    analog_pin: Annotated[Pin | None, Field(ge=54, description="A0..A15: a voltage of 0..5 V.")] = None
    contact_pin: Annotated[Pin | None, Field(description="1 while it is closed to ground, else 0.")] = None
    zero_V: Annotated[float, Field(ge=-5, le=10, description="Voltage at which the value is 0.")] = 0.0
    per_V: Annotated[float, Field(description="Change of the value for each volt, in its unit.")] = 1.0
    min: Annotated[float | None, Field(description="Lowest plausible value; without it the one at 0 V.")] = None
    max: Annotated[float | None, Field(description="Highest plausible value; without it the one at 5 V.")] = None

    @property
    def limits(self) -> tuple[float, float]:
        """The plausible range, in the unit."""
        if self.contact_pin is not None:
            return 0.0, 1.0
        ends = sorted(self.per_V * (volts - self.zero_V) for volts in (0.0, SUPPLY_V))
        return ends[0] if self.min is None else self.min, ends[1] if self.max is None else self.max

    @model_validator(mode="after")
    def _check(self) -> ChannelInput:
        if (self.analog_pin is None) == (self.contact_pin is None):
            raise fault('expected either "analog_pin" or "contact_pin"')
        if not LEAST_PER_V <= abs(self.per_V) <= MOST_VALUE:
            raise fault(
                f"found {self.per_V:g}, expected {LEAST_PER_V:g}..{MOST_VALUE:g}, or the same below zero", "per_V"
            )
        low, high = self.limits
        if not -MOST_VALUE <= low < high <= MOST_VALUE:
            raise fault(
                f"found a range of {low:g}..{high:g}, expected one within -{MOST_VALUE:g}..{MOST_VALUE:g}", "max"
            )
        return self


class ProfileStep(Part):
    """One step of a profile."""

    duration_s: Annotated[Positive, Field(le=1e6)]
    pwm: Duty


class Profile(Part):
    """What the board commands by itself when told `profile on`."""

    steps: Annotated[tuple[ProfileStep, ...], Field(min_length=1, max_length=200)]
    repeat: Annotated[bool, Field(description="Start again after the last step; otherwise PWM 0 follows.")] = False
    autostart: Annotated[bool, Field(description="Run it from power-up on: after every reset the motor starts.")] = (
        False
    )


def _only(given: Sequence[str], absent: Sequence[str]) -> JsonDict:
    """Schema of an object with these pins and not with those keys."""
    properties: JsonDict = {key: {"type": "integer"} for key in given}
    properties |= {key: {"type": "null"} for key in absent}
    return {"required": list(given), "properties": properties}


class Drive(Part):
    """A motor driver: a PWM pin for each direction, or a PWM pin and one whose level is the direction."""

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [_only(_PAIR, [*_SIGNED, "forward_level"]), _only(_SIGNED, _PAIR)]}
    )

    forward_pin: Pin | None = None
    reverse_pin: Pin | None = None
    pwm_pin: Pin | None = None
    direction_pin: Pin | None = None
    forward_level: Annotated[
        Literal["high", "low"] | None,
        Field(description="Level of the direction pin for PWM > 0, beside pwm_pin only. Without it high."),
    ] = None
    profile: Profile | None = None

    @property
    def pwm_pins(self) -> dict[str, int]:
        """The pins that have PWM, by their keys."""
        pins = {key: getattr(self, key) for key in (*_PAIR, "pwm_pin")}
        return {key: pin for key, pin in pins.items() if pin is not None}

    @property
    def forward_is_high(self) -> bool:
        """Whether the direction pin is high for PWM > 0."""
        return self.forward_level != "low"

    @model_validator(mode="after")
    def _check(self) -> Drive:
        pair, signed = ([key for key in form if getattr(self, key) is not None] for form in (_PAIR, _SIGNED))
        level = ["forward_level"] if self.forward_level is not None else []
        expected = f"expected either {listed([*_PAIR], 'and')}, or {listed([*_SIGNED], 'and')}"
        if pair and (signed or level):
            raise fault(f"found {listed([*pair, *signed, *level], 'and')}; {expected}")
        if not pair and not signed:
            raise fault(f"found no pin; {expected}")
        for key in _PAIR if pair else _SIGNED:
            if getattr(self, key) is None:
                raise fault(f'missing key "{key}"; {expected}')
        return self


class Observe(Part):
    """Another controller's PWM, only measured: its pins, one for each direction (400 Hz..25 kHz)."""

    forward_pin: Pin
    reverse_pin: Pin | None = None


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


class Wiring(Part):
    """All pins; one pin has one role, except that clock and data lines may be shared."""

    serial_baud: Literal[9600, 19200, 38400, 57600, 76800, 115200, 250000, 500000, 1000000] = 115200
    row_every_s: Annotated[Positive, Field(le=3600, description="Time between two rows on the serial line.")] = 1.0
    led_pin: Pin | None = None
    button_pin: Annotated[Pin | None, Field(description="To ground; resets latched alarms.")] = None
    thermocouples: Annotated[tuple[Thermocouple, ...], Field(max_length=17)] = ()
    encoder: Encoder | None = None
    channels: Annotated[
        tuple[ChannelInput, ...], Field(max_length=16, description="Inputs beside the thermocouples.")
    ] = ()
    drive: Drive | None = None
    observe: Observe | None = None
    memory: Annotated[Memory | None, Field(description="null: no copies.")] = Memory()

    @model_validator(mode="after")
    def _check(self) -> Wiring:
        timer_5 = self.encoder is not None and self.encoder.counts_in_hardware
        for key, pin in self.drive.pwm_pins.items() if self.drive else ():
            if pin not in _PWM_PINS:
                raise fault(f"pin {pin} has no PWM; expected one of 2..13, 44, 45, 46", "drive", key)
            if pin == _BOOT_LED_PIN:
                raise fault(
                    f"pin {_BOOT_LED_PIN} is the boot loader's LED: the motor would run at every reset before the "
                    "firmware does; expected another pin",
                    "drive",
                    key,
                )
            if timer_5 and pin in _COUNTER_TIMER_PINS:
                raise fault(
                    f"the PWM of pin {pin} is Timer 5's, which counts the encoder's pulses; expected another pin",
                    "drive",
                    key,
                )
        if self.drive and self.observe:
            raise fault('found both "drive" and "observe"; expected one of them: who drives the motor?', "observe")
        columns: set[str] = set()
        for i, channel in enumerate(self.channels):
            if channel.column.lower() in columns:
                raise fault(f'"{channel.column}" is taken already; expected one each', "channels", i, "column")
            columns.add(channel.column.lower())
        taken: dict[int, tuple[str, str]] = {0: ("rx", "the serial port"), 1: ("tx", "the serial port")}
        for role, pin, at in self._roles():
            owner = taken.setdefault(pin, (role, _place(at)))
            if owner[1] != _place(at) and not (role == owner[0] and role in _SHARED):
                raise fault(f"pin {pin} is already taken by {owner[1]}; expected a free pin", *at)
        return self

    def printed_columns(self, components: Sequence[str]) -> set[str]:
        """Columns of the board's rows whose names are not of the file's choice, for a model with these components."""
        measured = [f"{chip.channel}_degC" for chip in self.thermocouples if chip.channel in components]
        speed = ["speed_rpm"] if self.encoder else []
        models = [f"{name}_model_degC" for name in components]
        return {"time_s", "pwm", *measured, *speed, *models, "flags", "sensors", "alarms"}

    def _roles(self) -> list[tuple[str, int, tuple[str | int, ...]]]:
        roles: list[tuple[str, int, tuple[str | int, ...]]] = []
        for name in ("led_pin", "button_pin"):
            pin = getattr(self, name)
            if pin is not None:
                roles.append((name, pin, (name,)))
        if self.encoder:
            roles.append(("encoder", self.encoder.pin, ("encoder", "pin")))
        for name in ("drive", "observe"):
            for key in (*_PAIR, *_SIGNED):
                pin = getattr(getattr(self, name), key, None)
                if pin is not None:
                    roles.append((key, pin, (name, key)))
        for i, channel in enumerate(self.channels):
            for key in ("analog_pin", "contact_pin"):
                pin = getattr(channel, key)
                if pin is not None:
                    roles.append((f"channel {channel.column}", pin, ("channels", i, key)))
        for i, thermocouple in enumerate(self.thermocouples):
            roles += [(key, getattr(thermocouple, key), ("thermocouples", i, key)) for key in ("cs", "so", "sck")]
        return roles


def _place(at: tuple[str | int, ...]) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in at).removeprefix(".")
