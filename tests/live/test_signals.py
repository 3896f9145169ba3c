"""LED and relay in words, from an emulated board's pins and from rows, which have to say the same."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from gen.coefficients import load, parse
from gen.live.emulated import EmulatedSource
from gen.live.known import Known, known_of
from gen.live.signals import UNKNOWN, from_pins, from_rows
from tests.examples import ROOT
from tests.live.serving import FedSource, wait_until
from tests.live.test_sources import EXAMPLE, FAULT, emulated, quick_tree

KNOWN = Known(
    rules=("warm", "hot"),
    channels=("coil",),
    causes=("hot", "lost", "slow"),
    shows=0b011,
    opens=0b001,
    led=True,
    relay=True,
)


def row(**columns: float) -> dict[str, float | None]:
    return {"time_s": 1.0, "pwm": 5.0, "flags": 0.0, "alarms": 0.0, "protection": 0.0, **columns}


@pytest.mark.parametrize(
    ("last", "sensors", "led", "relay"),
    [
        (row(), "0", "a short flash every 2 s: healthy", "closed"),
        (row(), "3", "flicker: a thermocouple is not believed", "closed"),
        (row(alarms=2), "0", "2 blinks, a pause: alarm hot", "closed"),
        (row(alarms=1), "1", "1 blink, a pause: alarm warm; flicker: a thermocouple is not believed", "closed"),
        (row(alarms=3, protection=1), "0", "1 blink, a pause: alarm warm; 2 blinks, a pause: alarm hot", "open"),
        (row(protection=2), "4", "a second on, a second off: the board acts on something", "closed"),
        (row(protection=4), "4", "flicker: a thermocouple is not believed", "closed"),
        (row(protection=8), "0", UNKNOWN, UNKNOWN),  # the file is not this board's
        (row(alarms=4), "0", "3 blinks, a pause: alarm rule 3", "closed"),
    ],
)
def test_what_a_row_says_of_them(last: dict[str, float | None], sensors: str, led: str, relay: str) -> None:
    found = from_rows(last, sensors, KNOWN)
    assert (found.led, found.relay) == (led, relay)


def test_without_the_board_s_file_what_only_it_tells_is_unknown() -> None:
    found = from_rows(row(), "0", Known())
    assert (found.led, found.relay) == ("a short flash every 2 s: healthy", "closed")
    assert "--model" in found.told
    found = from_rows(row(protection=1), "0", Known())
    assert (found.led, found.relay) == (UNKNOWN, UNKNOWN)


def test_rows_that_no_board_printed_say_nothing() -> None:
    for last in ({}, {"time_s": 0.0, "pwm": 5.0, "coil_degC": 30.0}):
        assert (from_rows(last, "", KNOWN).led, from_rows(last, "", KNOWN).relay) == (UNKNOWN, UNKNOWN)


def test_a_board_has_what_its_file_wires() -> None:
    rig = known_of(load(EXAMPLE))
    assert (rig.led, rig.relay) == (True, False)
    assert from_rows(row(), "00000", rig).relay == ""
    two = known_of(load(ROOT / "examples" / "two_mass" / "coeffs.json"))
    assert (two.led, two.relay) == (True, True)
    opening = {name for place, name in enumerate(two.causes) if two.opens >> place & 1}
    assert "flash_check" in opening
    assert "stall" not in opening
    assert from_pins(None, None, ()).led == ""


def test_alarms_that_take_turns_stand_in_their_order() -> None:
    words = "1 blink, a pause: alarm warm; 2 blinks, a pause: alarm hot; flicker: a thermocouple is not believed"
    for patterns in (("alarm 1", "sensor", "alarm 2"), ("sensor", "alarm 2", "alarm 1")):
        assert from_pins(patterns, False, KNOWN.rules).led == words
    assert from_pins(("lit",), True, ()).relay == "closed"


def test_a_line_that_is_not_open_says_nothing_of_now() -> None:
    source = FedSource(KNOWN)
    source.view.feed(b"time_s,pwm,coil_degC,flags,sensors,alarms,protection\n0,5,30,0,0,2,1\n", 0.0)
    assert source.signals().led == "2 blinks, a pause: alarm hot"
    assert source.signals().relay == "open"
    source.connected, source.link = False, "waiting for the port"
    assert (source.signals().led, source.signals().told) == (UNKNOWN, "waiting for the port")


@pytest.fixture
def source(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmulatedSource]:
    """The board of that rule, which opens a relay at its alarm."""
    tree = quick_tree()
    tree["wiring"]["relay_pin"] = 12
    tree["protection"] = [{"cause": "alarm", "rule": "bearing_warm", "action": "open_relay", "until": "command"}]
    made = emulated(parse(json.dumps(tree).encode()), tmp_path_factory.getbasetemp())
    made.start()
    try:
        yield made
    finally:
        made.stop()


def test_pins_and_rows_of_an_emulated_board_say_the_same(source: EmulatedSource) -> None:
    """The pins are read with a clock, which knows nothing of the rows."""

    def agree(led: str, relay: str) -> bool:
        pins, rows = source.signals(), from_rows(*source.view.last(), source.view.known)
        return (pins.led, pins.relay) == (rows.led, rows.relay) == (led, relay)

    wait_until(lambda: agree("a short flash every 2 s: healthy", "closed"))
    source.change("sensor casing", "open")
    wait_until(lambda: agree("flicker: a thermocouple is not believed", "closed"))
    source.change("sensor casing", "none")
    wait_until(lambda: agree("a short flash every 2 s: healthy", "closed"))
    source.send(b"arm\n200\n")
    source.change("fault", FAULT)
    wait_until(lambda: agree("1 blink, a pause: alarm bearing_warm", "open"))
    assert source.signals().told == "seen at the board's pins"
    source.stop()
    assert source.signals().led == UNKNOWN
