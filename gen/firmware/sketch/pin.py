"""A pin of the Mega as the templates print it."""

from __future__ import annotations

from typing import TypedDict

from gen.firmware.pins import label, port_bit


class Pin(TypedDict):
    """A pin: its Arduino number and label, its port's letter and bit, the JSON path of where it was given."""

    pin: int
    label: str
    letter: str
    bit: int
    path: str


def pin_context(pin: int, path: str) -> Pin:
    """Describe an Arduino pin, which stands at a path of the coefficient file."""
    letter, bit = port_bit(pin)
    return {"pin": pin, "label": label(pin), "letter": letter, "bit": bit, "path": path}
