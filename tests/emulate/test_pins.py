"""The pin maps are the Arduino core's own."""

from __future__ import annotations

import pytest

from gen.coefficients.wiring import BoardName
from gen.emulate.wiring.pins import PIN_MAPS, PortPin

from .conftest import OpenBoard


@pytest.mark.parametrize("board", PIN_MAPS)
def test_ports_and_pwm_pins_agree_with_the_core(board: BoardName, open_board: OpenBoard) -> None:
    mega = open_board("pins.cpp", board=board)
    rows = mega.run_until_bytes(b"end", 100_000_000).decode().split("\r\n")[:-1]
    pins = PIN_MAPS[board]
    assert len(rows) == len(pins.ports)
    for row in rows:
        pin, port, bit, has_timer = row.split()
        assert pins.port_pin(int(pin)) == PortPin(port, int(bit)), row
        assert (pins.compare_output(int(pin)) is not None) == (has_timer == "1"), row


@pytest.mark.parametrize(("board", "pin"), [("mega", -1), ("mega", 70), ("uno", 20)])
def test_other_pins_are_refused(board: str, pin: int) -> None:
    with pytest.raises(ValueError, match="no pin"):
        PIN_MAPS[board].port_pin(pin)
