"""The pin map is the Arduino core's own."""

from __future__ import annotations

import pytest

from gen.emulate.pins import PINS, PortPin, compare_output, port_pin

from .conftest import OpenBoard


def test_ports_and_pwm_pins_agree_with_the_core(open_board: OpenBoard) -> None:
    mega = open_board("pins.cpp")
    rows = mega.run_until_bytes(b"end", 100_000_000).decode().split("\r\n")[:-1]
    assert len(rows) == PINS
    for row in rows:
        pin, port, bit, has_timer = row.split()
        assert port_pin(int(pin)) == PortPin(port, int(bit)), row
        assert (compare_output(int(pin)) is not None) == (has_timer == "1"), row


@pytest.mark.parametrize("pin", [-1, 70])
def test_other_pins_are_refused(pin: int) -> None:
    with pytest.raises(ValueError, match="no pin"):
        port_pin(pin)
