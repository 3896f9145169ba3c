"""A pin as the templates print it."""

from __future__ import annotations

from typing import TypedDict

from gen.firmware.boards import Board


class Pin(TypedDict):
    """A pin: its Arduino number and label, its port's letter and bit, the JSON path of where it was given."""

    pin: int
    label: str
    letter: str
    bit: int
    path: str


def pin_context(board: Board, pin: int, path: str) -> Pin:
    """Describe a board's pin, which stands at a path of the coefficient file."""
    letter, bit = board.port_bit(pin)
    return {"pin": pin, "label": board.label(pin), "letter": letter, "bit": bit, "path": path}
