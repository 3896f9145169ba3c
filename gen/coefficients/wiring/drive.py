"""What turns the motor: the board's own driver, or another controller that it observes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator
from pydantic.config import JsonDict

from gen.coefficients.base import Note, Part, Positive, fault, listed
from gen.coefficients.wiring.pins import Pin
from gen.model.dynamics import MAX_PWM

Duty = Annotated[int, Field(ge=-MAX_PWM, le=MAX_PWM)]

_PAIR = ("forward_pin", "reverse_pin")
_SIGNED = ("pwm_pin", "direction_pin")
DRIVE_PINS = (*_PAIR, *_SIGNED)
"""Keys of all pins that a driver may have."""


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
    ramp_s: Annotated[
        float,
        Field(ge=0, le=600, allow_inf_nan=False, description="Time from 0 to full scale; 0: at once. Down is at once."),
    ] = 0.0
    reversal_pause_s: Annotated[
        float, Field(ge=0, le=600, allow_inf_nan=False, description="PWM 0 for so long before the direction changes.")
    ] = 0.5
    frequency_Hz: Annotated[
        Literal[490, 3922, 31373],
        Field(
            description="Of the PWM, by its timer's prescaler. Pin 4 of the Mega, 5 and 6 of the Uno have 976 Hz "
            "whatever is said: the core's clock."
        ),
    ] = 490
    profile: Profile | None = None
    note: Note | None = None

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
