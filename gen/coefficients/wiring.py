"""The board's wiring: which pin of the Mega carries what."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gen.coefficients.base import Part, fault

Pin = Annotated[int, Field(ge=0, le=69, description="Arduino pin number of the Mega 2560 (54..69 are A0..A15).")]

_PWM_PINS = frozenset([*range(2, 14), 44, 45, 46])
_INTERRUPT_PINS = frozenset([2, 3, 18, 19, 20, 21])
_SHARED = frozenset(["so", "sck"])
"""Roles that several thermocouple amplifiers may share: only the selected one drives or reads its line."""


class Thermocouple(Part):
    """One MAX6675 on bit-banged SPI."""

    channel: Annotated[str, Field(description='A component\'s name, or "ambient".')]
    cs: Pin
    so: Pin
    sck: Pin


class Encoder(Part):
    """Speed feedback."""

    pin: Pin
    pulses_per_revolution: Annotated[int, Field(ge=1, le=65535)]


class Drive(Part):
    """A motor driver with one PWM pin for each direction."""

    forward_pin: Pin
    reverse_pin: Pin


class Wiring(Part):
    """All pins; one pin has one role, except that clock and data lines may be shared."""

    serial_baud: Literal[9600, 19200, 38400, 57600, 76800, 115200, 250000, 500000, 1000000] = 115200
    led_pin: Pin | None = None
    button_pin: Pin | None = None
    thermocouples: tuple[Thermocouple, ...] = ()
    encoder: Encoder | None = None
    drive: Drive | None = None

    @model_validator(mode="after")
    def _check(self) -> Wiring:
        if self.encoder and self.encoder.pin not in _INTERRUPT_PINS:
            raise fault(
                f"pin {self.encoder.pin} has no external interrupt; expected one of 2, 3, 18, 19, 20, 21",
                "encoder",
                "pin",
            )
        for key in ("forward_pin", "reverse_pin"):
            if self.drive and getattr(self.drive, key) not in _PWM_PINS:
                raise fault(
                    f"pin {getattr(self.drive, key)} has no PWM; expected one of 2..13, 44, 45, 46",
                    "drive",
                    key,
                )
        taken: dict[int, tuple[str, str]] = {0: ("rx", "the serial port"), 1: ("tx", "the serial port")}
        for role, pin, at in self._roles():
            owner = taken.setdefault(pin, (role, _place(at)))
            if owner[1] != _place(at) and not (role == owner[0] and role in _SHARED):
                raise fault(f"pin {pin} is already taken by {owner[1]}; expected a free pin", *at)
        return self

    def _roles(self) -> list[tuple[str, int, tuple[str | int, ...]]]:
        roles: list[tuple[str, int, tuple[str | int, ...]]] = []
        for name in ("led_pin", "button_pin"):
            pin = getattr(self, name)
            if pin is not None:
                roles.append((name, pin, (name,)))
        if self.encoder:
            roles.append(("encoder", self.encoder.pin, ("encoder", "pin")))
        if self.drive:
            roles += [(key, getattr(self.drive, key), ("drive", key)) for key in ("forward_pin", "reverse_pin")]
        for i, thermocouple in enumerate(self.thermocouples):
            roles += [(key, getattr(thermocouple, key), ("thermocouples", i, key)) for key in ("cs", "so", "sck")]
        return roles


def _place(at: tuple[str | int, ...]) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in at).removeprefix(".")
