"""Where the Arduino Mega 2560's numbered pins lie: ports, timers, external interrupts (pinout of the Mega 2560)."""

from __future__ import annotations

#: Port letter and bit of pins 0..69.
_LETTERS = "EEEEGEHHHHBBBBJJHHDDDDAAAAAAAACCCCCCCCDGGGLLLLLLLLBBBBFFFFFFFFKKKKKKKK"
_BITS = "0145533456456710103210012345677654321072107654321032100123456701234567"

#: External interrupt of a pin.
INTERRUPTS = {2: 4, 3: 5, 18: 3, 19: 2, 20: 1, 21: 0}

#: Timer that makes a pin's PWM. Timer 0 also keeps the core's time.
PWM_TIMERS = {2: 3, 3: 3, 4: 0, 5: 3, 6: 4, 7: 4, 8: 4, 9: 2, 10: 2, 11: 1, 12: 1, 13: 0, 44: 5, 45: 5, 46: 5}

#: TCCRnB with which a PWM timer makes 8-bit phase-correct PWM of about so many Hz: clock / 64 (as the Arduino core
#: lets it run), / 8 and / 1, over 510 counts.
TIMER_RUNS = {
    490: {
        1: "_BV(CS11) | _BV(CS10)",
        2: "_BV(CS22)",
        3: "_BV(CS31) | _BV(CS30)",
        4: "_BV(CS41) | _BV(CS40)",
        5: "_BV(CS51) | _BV(CS50)",
    },
    3922: {timer: f"_BV(CS{timer}1)" for timer in range(1, 6)},
    31373: {timer: f"_BV(CS{timer}0)" for timer in range(1, 6)},
}


def port_bit(pin: int) -> tuple[str, int]:
    """Port letter and bit of an Arduino pin, 0..69."""
    return _LETTERS[pin], int(_BITS[pin])


def label(pin: int) -> str:
    """The pin's name as printed on the board: 22 or A0."""
    return f"A{pin - 54}" if pin >= 54 else str(pin)
