"""The Mega's pins: what each of them can do, and that one pin has one role."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Annotated, NamedTuple

from pydantic import Field

from gen.coefficients.base import Part, fault

Pin = Annotated[int, Field(ge=0, le=69, description="Arduino pin number of the Mega 2560 (54..69 are A0..A15).")]

PWM_PINS = frozenset([*range(2, 14), 44, 45, 46])
INTERRUPT_PINS = frozenset([2, 3, 18, 19, 20, 21])
BOOT_LED_PIN = 13
"""The stock boot loader holds it high for a second or so after every reset."""
COUNTER_PIN = 47
"""The one header pin that clocks a timer which the Arduino core does not need (T5 of Timer 5)."""
COUNTER_TIMER_PINS = frozenset([44, 45, 46])

_SHARED = frozenset(["so", "sck", "sdi"])
"""Roles that several thermocouple amplifiers may share: only the selected one drives or reads its line."""
_SERIAL = {0: "rx", 1: "tx"}


class Role(NamedTuple):
    """What a pin is taken for, and where in the wiring this stands."""

    name: str
    pin: int
    at: tuple[str | int, ...]


def roles(part: Part | None, keys: Iterable[str], *at: str | int, name: str | None = None) -> Iterator[Role]:
    """Give the pins that a part of the wiring takes.

    Parameters
    ----------
    part
        None takes none.
    keys
        Its keys that hold a pin; one without a value takes none.
    at
        The part's path in the wiring.
    name
        The role's name, where it is not the key.
    """
    for key in keys:
        pin = getattr(part, key, None)
        if pin is not None:
            yield Role(name or key, pin, (*at, key))


def check_free(taken: Iterable[Role]) -> None:
    """Check that each pin has one role, except that thermocouples may share clock and data lines.

    Raises
    ------
    PydanticCustomError
        At the second role of a pin.
    """
    owners = {pin: (name, "the serial port") for pin, name in _SERIAL.items()}
    for role in taken:
        place = _text(role.at)
        owner, where = owners.setdefault(role.pin, (role.name, place))
        if where != place and not (role.name == owner and owner in _SHARED):
            raise fault(f"pin {role.pin} is already taken by {where}; expected a free pin", *role.at)


def _text(at: tuple[str | int, ...]) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in at).removeprefix(".")
