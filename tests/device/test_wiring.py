"""The wiring in the coefficient file: what is refused, the pins' places, the drawing."""

from __future__ import annotations

import copy
import json
import re
import xml.etree.ElementTree as ET
from typing import Any

import jsonschema
import pytest

from gen import toolchain
from gen.coefficients import parse
from gen.coefficients.schema import json_schema
from gen.coefficients.versions import VERSION
from gen.errors import InputError
from gen.firmware.boards import MEGA
from gen.firmware.project import project_files
from gen.firmware.sketch.device import device_context
from gen.firmware.wiring_svg import parts, wiring_svg
from gen.lowering.lower import lower
from tests.device.variants import BASE, VARIANTS, variant

CORE_TIMERS = {"0A": 0, "0B": 0, "1A": 1, "1B": 1, "2A": 2, "2B": 2, "3A": 3, "3B": 3, "3C": 3, "4A": 4, "4B": 4}
CORE_TIMERS |= {"4C": 4, "5A": 5, "5B": 5, "5C": 5}

FAULTS: list[tuple[dict[str, Any], str, str]] = [
    ({"encoder": {"pin": 7, "pulses_per_revolution": 500}}, "$.wiring.encoder.pin", "no external interrupt"),
    (
        {"encoder": {"pin": 3, "pulses_per_revolution": 500, "method": "counter"}},
        "$.wiring.encoder.pin",
        "expected 47",
    ),
    (
        {"encoder": {"pin": 47, "pulses_per_revolution": 5, "method": "interrupt"}},
        "$.wiring.encoder.pin",
        "no external interrupt",
    ),
    (
        {"encoder": {"pin": 47, "pulses_per_revolution": 5}, "drive": {"forward_pin": 4, "reverse_pin": 45}},
        "$.wiring.drive.reverse_pin",
        "Timer 5",
    ),
    (
        {"encoder": {"pin": 47, "pulses_per_revolution": 5}, "drive": {"pwm_pin": 46, "direction_pin": 45}},
        "$.wiring.drive.pwm_pin",
        "Timer 5",
    ),
    (
        {"drive": {"pwm_pin": 4, "direction_pin": 5}, "observe": {"forward_pin": 6}},
        "$.wiring.observe",
        "expected one of them",
    ),
    (
        {"drive": {"forward_pin": 4, "reverse_pin": 5}, "observe": {"forward_pin": 6}},
        "$.wiring.observe",
        "expected one of them",
    ),
    ({"observe": {"forward_pin": 6, "reverse_pin": 6}}, "$.wiring.observe.reverse_pin", "already taken"),
    (
        {"thermocouples": [{"channel": "brush", "cs": 30, "so": 31, "sck": 32, "min_degC": 90, "max_degC": 20}]},
        "$.wiring.thermocouples[0].max_degC",
        "expected more than min_degC, which is 90",
    ),
    (
        {"thermocouples": [{"channel": "brush", "cs": 30, "so": 31, "sck": 32, "max_degC": 2000}]},
        "$.wiring.thermocouples[0].max_degC",
        "at most 1023.75",
    ),
    ({"memory": {"interval_s": 1}}, "$.wiring.memory.interval_s", "at least 60"),
    ({"row_every_s": 0}, "$.wiring.row_every_s", "over 0"),
    (
        {"drive": {"forward_pin": 4, "reverse_pin": 5, "profile": {"steps": [{"duration_s": 1, "pwm": 256}]}}},
        "$.wiring.drive.profile.steps[0].pwm",
        "at most 255",
    ),
    (
        {"drive": {"forward_pin": 4, "reverse_pin": 5, "profile": {"steps": []}}},
        "$.wiring.drive.profile.steps",
        "at least 1",
    ),
]


@pytest.mark.parametrize(("wiring", "place", "message"), FAULTS)
def test_a_fault_in_the_wiring_gets_its_place(wiring: dict[str, Any], place: str, message: str) -> None:
    tree = copy.deepcopy(BASE)
    tree["wiring"] = wiring
    with pytest.raises(InputError) as caught:
        parse(json.dumps(tree).encode())
    assert caught.value.place == place
    assert message in caught.value.message


@pytest.mark.parametrize("direction", [13, 30, 45, 54, 69])
def test_a_direction_may_be_on_any_free_pin(direction: int) -> None:
    """Beside an encoder that Timer 5 counts, and on the boot loader's LED: only PWM is bound to a timer."""
    tree = copy.deepcopy(BASE)
    tree["wiring"] = {
        "encoder": {"pin": 47, "pulses_per_revolution": 5},
        "drive": {"pwm_pin": 4, "direction_pin": direction},
    }
    jsonschema.validate(tree | {"version": VERSION}, json_schema())
    assert parse(json.dumps(tree).encode())


@pytest.mark.parametrize(("level", "forward"), [(None, "high"), ("low", "low")])
def test_the_table_of_the_wiring_names_pwm_and_direction(level: str | None, forward: str) -> None:
    tree = copy.deepcopy(BASE)
    tree["wiring"]["drive"] = {"pwm_pin": 9, "direction_pin": 62, "forward_level": level}
    coefficients = parse(json.dumps(tree).encode())
    program = lower(coefficients, "fixed", "table")
    text = project_files(coefficients, program, "coeffs.json", None)["README.md"]
    assert "| Motor driver | PWM | 9 |\n|  | DIR | A8 |\n" in text
    assert f"DIR is {forward} for PWM > 0" in text
    assert "Pull the PWM input of the motor's driver down" in text
    driver = next(part for part in parts(device_context(coefficients, program)) if part.title == "Motor driver")
    assert [(end.name, end.to) for end in driver.terminals] == [("PWM", "9"), ("DIR", "A8"), ("GND", "GND")]


def test_a_profile_keeps_to_the_full_scale() -> None:
    tree = copy.deepcopy(BASE)
    tree["input"]["full_scale"] = tree["domain"]["pwm"][1] = tree["validity"]["pwm"][1] = 200
    tree["provenance"]["error"] = []
    tree["wiring"]["drive"]["profile"] = {"steps": [{"duration_s": 1, "pwm": 200}, {"duration_s": 1, "pwm": -201}]}
    with pytest.raises(InputError) as caught:
        parse(json.dumps(tree).encode())
    assert caught.value.place == "$.wiring.drive.profile.steps[1].pwm"


@pytest.mark.parametrize("name", ["drive", "config", "Board", "output"])
def test_a_model_may_not_have_the_name_of_a_file_of_the_sketch(name: str) -> None:
    tree = copy.deepcopy(BASE)
    tree["name"] = name
    with pytest.raises(InputError, match="file of the sketch"):
        parse(json.dumps(tree).encode())


def test_the_schema_knows_every_variants_wiring() -> None:
    for name, change in VARIANTS.items():
        tree = copy.deepcopy(BASE)
        change(tree)
        jsonschema.validate(tree | {"version": VERSION}, json_schema())
        assert variant(name)


def test_pins_lie_where_the_arduino_core_has_them() -> None:
    text = (toolchain.arduino_core() / "variants/mega/pins_arduino.h").read_text()
    ports = re.findall(r"^\s*P([A-L])\s*,\s*// P\w (\d) \*\* (\d+) \*\*", text, re.M)
    assert len(ports) == 70
    for letter, bit, pin in ports:
        assert MEGA.port_bit(int(pin)) == (letter, int(bit))
    timers = re.findall(r"^\s*(NOT_ON_TIMER|TIMER\w+)\s*,\s*// P\w \d \*\* (\d+) \*\*", text, re.M)
    on_timer = {int(pin): CORE_TIMERS[name.removeprefix("TIMER")] for name, pin in timers if name != "NOT_ON_TIMER"}
    assert on_timer == MEGA.pwm_timers
    assert {pin: f"{MEGA.port_bit(pin)[0]}{MEGA.port_bit(pin)[1]}" for pin in MEGA.interrupts} == {
        2: "E4", 3: "E5", 18: "D3", 19: "D2", 20: "D1", 21: "D0",
    }  # fmt: skip
    assert (MEGA.label(53), MEGA.label(54), MEGA.label(69)) == ("53", "A0", "A15")


@pytest.mark.parametrize("name", VARIANTS)
def test_the_drawing_has_a_wire_from_every_pin_to_its_terminal(name: str) -> None:
    coefficients = variant(name)
    device = device_context(coefficients, lower(coefficients, "fixed", "table"))
    drawn = ET.fromstring(wiring_svg("Wiring", device))
    space = "{http://www.w3.org/2000/svg}"
    texts = [(float(t.attrib["x"]), float(t.attrib["y"]), t.text) for t in drawn.iter(f"{space}text")]
    wires = [path.attrib["d"] for path in drawn.iter(f"{space}path")]
    for part in parts(device):
        for terminal in part.terminals:
            pin_y = min(y for x, y, text in texts if text == terminal.to and x < 200) - 4
            note = f"to {terminal.to}" if terminal.to in ("5 V", "GND") else f"to pin {terminal.to}"
            ends = [y - 4 for x, y, text in texts if text == note]
            (wire,) = (d for d in wires if re.match(rf"M\d+ {pin_y:g}H", d))
            for y in ends:
                assert re.search(rf"M\d+ {y:g}H", wire)
    horizontal = [y for d in wires for y in set(re.findall(r"M\d+ (\d+)H", d))]
    assert len(horizontal) == len(set(horizontal))  # no two wires on one line
