"""The boards' pins: what each of them can do, and that one pin has one role."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from gen.coefficients.base import Part, fault

BoardName = Literal["mega", "uno"]
Pin = Annotated[
    int, Field(ge=0, le=69, description="Arduino pin number; A0 is 54 of the Mega 2560's 0..69, 14 of the Uno's 0..19.")
]

BOOT_LED_PIN = 13
"""The stock boot loaders hold it high for a second or so after every reset."""
COUNTER_PIN = 47
"""The one header pin that clocks a timer which the Arduino core does not need (T5 of the Mega's Timer 5)."""
COUNTER_TIMER_PINS = frozenset([44, 45, 46])


@dataclass(frozen=True)
class BoardPins:
    """What the pins of a board can do.

    Attributes
    ----------
    name
        Of the board, for people.
    pins
        Digital and analog ones together, numbered from 0.
    first_analog
        A0; it and all behind it are analog inputs, too.
    pwm, interrupts
        Those that have them.
    clock_timer
        Their PWM is Timer 0's, with which the Arduino core keeps the time.
    counter
        The one that clocks a timer; None where the core needs all timers that a pin clocks, or PWM does.
    """

    name: str
    pins: int
    first_analog: int
    pwm: frozenset[int]
    interrupts: frozenset[int]
    clock_timer: frozenset[int]
    counter: int | None


PINS_OF: dict[BoardName, BoardPins] = {
    "mega": BoardPins(
        "the Mega 2560",
        70,
        54,
        frozenset([*range(2, 14), 44, 45, 46]),
        frozenset([2, 3, 18, 19, 20, 21]),
        frozenset([4, 13]),
        COUNTER_PIN,
    ),
    "uno": BoardPins("the Uno", 20, 14, frozenset([3, 5, 6, 9, 10, 11]), frozenset([2, 3]), frozenset([5, 6]), None),
}

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


def spans(pins: Collection[int]) -> str:
    """Name pins for people: ``2..13, 44, 45, 46``; two or three that follow one another each by their number."""
    found: list[list[int]] = []
    for pin in sorted(pins):
        if found and pin == found[-1][-1] + 1:
            found[-1].append(pin)
        else:
            found.append([pin])
    return ", ".join(f"{run[0]}..{run[-1]}" if len(run) > 4 else ", ".join(map(str, run)) for run in found)


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
