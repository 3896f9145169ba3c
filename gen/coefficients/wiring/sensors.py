"""What the board measures: thermocouples, the encoder, and channels beside them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gen.coefficients.base import Celsius, Note, NotNegative, Part, Positive, fault
from gen.coefficients.wiring.pins import COUNTER_PIN, INTERRUPT_PINS, Pin
from gen.model.dynamics import MAX_PWM

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
    note: Note | None = None

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
    stall_pwm: Annotated[int, Field(ge=1, le=MAX_PWM, description="|PWM| from which on the motor must turn.")] = 51
    stall_s: Annotated[Positive, Field(le=3600, description="No pulse for this long at such a PWM is a stall.")] = 2.0
    note: Note | None = None

    @property
    def counts_in_hardware(self) -> bool:
        """Whether Timer 5 counts the pulses."""
        return self.method == "counter" or (self.method is None and self.pin == COUNTER_PIN)

    @model_validator(mode="after")
    def _check(self) -> Encoder:
        if self.counts_in_hardware and self.pin != COUNTER_PIN:
            raise fault(f"pin {self.pin} is no counter's input; expected {COUNTER_PIN}", "pin")
        if not self.counts_in_hardware and self.pin not in INTERRUPT_PINS:
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
    note: Note | None = None

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
