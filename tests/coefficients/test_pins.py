"""What the wiring may ask of a pin, against the Arduino core's own table of the Mega 2560."""

from __future__ import annotations

import re

from gen import toolchain
from gen.coefficients.wiring.pins import COUNTER_PIN, COUNTER_TIMER_PINS, PINS_OF

MEGA = PINS_OF["mega"]


def test_a_pin_can_what_the_core_and_the_chip_let_it() -> None:
    text = (toolchain.arduino_core() / "variants/mega/pins_arduino.h").read_text()
    rows = re.findall(r"^\s*(NOT_ON_TIMER|TIMER\w+)\s*,\s*// P\w \d \*\* (\d+) \*\*", text, re.M)
    timers = {int(pin): name for name, pin in rows}
    assert len(timers) == 70
    assert {pin for pin, name in timers.items() if name != "NOT_ON_TIMER"} == MEGA.pwm
    assert {pin for pin, name in timers.items() if name.startswith("TIMER5")} == COUNTER_TIMER_PINS
    numbered = re.search(r"#define digitalPinToInterrupt\(p\)(.*)", text)
    assert numbered is not None
    known = {int(pin) for pin in re.findall(r"\(p\) == (\d+)", numbered.group(1))}
    first, last = (int(end) for end in re.findall(r"\(p\) >= (\d+) && \(p\) <= (\d+)", numbered.group(1))[0])
    assert known | set(range(first, last + 1)) == MEGA.interrupts
    assert (
        MEGA.counter == COUNTER_PIN == 47
    )  # port L bit 2, which is T5 (data sheet of the ATmega2560, alternate functions of port L)
