"""How often random bytes are a command: from the rules of the line, not from the firmware."""

from __future__ import annotations

BYTES_PER_S = 11_520.0
"""At 115 200 baud."""
_END = 2 / 256
"""Newline and carriage return end a line."""


def accepted_per_line() -> float:
    """Chance that a line of random bytes is a PWM, -255..255, or a question, in any of their spellings.

    A number has 1 to 5 digits; those below 256 with leading zeros count, too.
    """
    numbers = 0.0
    for digits in range(1, 6):
        spelt = sum(1 for value in range(256) if len(str(value)) <= digits)
        numbers += spelt / 256.0**digits * (1.0 + 1.0 / 256.0)  # a sign before it
    return (numbers + 1.0 / 256.0) * _END


def lines_per_hour() -> float:
    """Lines, the empty ones included."""
    return BYTES_PER_S * 3600.0 * _END


def obeyed_per_hour() -> float:
    """PWMs and questions that come about by chance: what they move is nothing, while the board is not armed."""
    return lines_per_hour() * accepted_per_line()


def moved_per_hour() -> float:
    """How often noise arms the board and commands a PWM: `arm`, and then at once, but for empty lines, a number."""
    arm = _END / 256.0**3
    return lines_per_hour() * arm * accepted_per_line() / (1.0 - _END)
