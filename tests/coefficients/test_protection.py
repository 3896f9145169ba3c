"""The table of causes and actions: what protects by itself, what the file can say, and what is refused."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest

from gen.coefficients import parse
from gen.coefficients.protecting import protections
from gen.coefficients.protection import Protection
from gen.errors import InputError
from tests.examples import ROOT

BASE: dict[str, Any] = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
LIMITS = ("brush_limit", "bearing_limit", "magnet_limit", "casing_limit")


Changes = dict[str, Any]


def table(**changes: object) -> dict[str, Protection]:
    return {entry.label: entry for entry in protections(parse(text(changes)).document)}


def text(changes: Changes) -> bytes:
    """The example with other keys, and other keys of its wiring; None takes one away."""
    wiring = changes.get("wiring")
    others = {key: value for key, value in changes.items() if key != "wiring"}
    tree = copy.deepcopy(BASE) | {"version": 2} | others
    for key, value in (wiring or {}).items():
        if value is None:
            del tree["wiring"][key]
        else:
            tree["wiring"][key] = value
    return json.dumps(tree).encode()


def test_a_driven_motor_is_protected_by_a_file_that_says_nothing_of_it() -> None:
    found = table()
    for name in LIMITS:
        assert found[name].action == "stop"
        assert found[name].until == "cool", "a reset while it is hot must not let it run"
    assert found["brush_limit"].restart_below_degC == 110.0
    assert found["sensor_lost"].action == found["stall"].action == found["flash_check"].action == "stop"
    assert 0 < found["sensor_lost"].delay_s <= 10


def test_a_rule_that_never_clears_lets_nothing_run_again() -> None:
    rules = copy.deepcopy(BASE["alarms"])
    rule = next(rule for rule in rules if rule["name"] == "brush_limit")
    rule["hysteresis_K"] = 500.0
    assert table(alarms=rules)["brush_limit"].restart_below_degC == -273.15


def test_a_rotor_that_locks_again_has_to_stand() -> None:
    assert table()["stall"].pause_s > 0


def test_nobody_drives_blind_from_the_start_unless_the_file_lets_a_motor_run_on_without_a_sensor() -> None:
    assert (table()["sensor_unseen"].action, table()["sensor_unseen"].until) == ("stop", "itself")
    assert "sensor_unseen" in table(protection=[{"cause": "sensor_lost", "action": "stop", "delay_s": 4}])
    assert "sensor_unseen" not in table(protection=[{"cause": "sensor_lost", "action": "log"}])
    assert table(protection=[{"cause": "sensor_unseen", "action": "led"}])["sensor_unseen"].action == "led"


def test_a_relay_opens_where_there_is_one() -> None:
    found = table(wiring={"relay_pin": 12})
    for name in (*LIMITS, "flash_check", "ram_check", "turning_without_command"):
        assert found[name].action == "open_relay", name


def test_a_silent_line_stops_the_motor_where_it_is_watched() -> None:
    assert "command_timeout" not in table()
    assert table(wiring={"command_timeout_s": 5})["command_timeout"].action == "stop"


def test_nothing_protects_where_nothing_is_driven() -> None:
    assert table(wiring={"drive": None}) == {}


def test_an_observed_motor_does_not_start_again_by_itself() -> None:
    """Its relay's closing would: another controller's PWM may still be there."""
    found = table(wiring={"drive": None, "observe": {"forward_pin": 4}, "relay_pin": 12})
    assert {entry.until for entry in found.values() if entry.action == "open_relay"} <= {"command", "cool"}
    assert "sensor_lost" in found


def test_a_rule_may_say_that_it_stops_nothing_and_another_that_it_does() -> None:
    alarms = copy.deepcopy(BASE["alarms"])
    for rule in alarms:
        if rule["name"] == "brush_limit":
            rule["stop_motor"] = False
        if rule["name"] == "fault":
            rule["stop_motor"] = True
    found = table(alarms=alarms)
    assert "brush_limit" not in found
    assert (found["fault"].action, found["fault"].until) == ("stop", "command")


def test_what_the_file_names_goes_before_the_default() -> None:
    entries = [
        {"cause": "stall", "action": "log"},
        {"cause": "alarm", "rule": "casing_limit", "action": "derate", "derate_pwm": 80},
    ]
    found = table(protection=entries)
    assert found["stall"].action == "log"
    assert found["casing_limit"].action == "derate"
    assert found["brush_limit"].action == "stop"


def test_a_rule_called_as_a_cause_is_gets_a_name_of_its_own() -> None:
    alarms = copy.deepcopy(BASE["alarms"])
    alarms[-1]["name"] = "stall"
    found = table(alarms=alarms)
    assert {"stall", "stall_too"} <= set(found)
    assert {found["stall"].cause, found["stall_too"].cause} == {"alarm", "stall"}


def test_a_driven_motor_that_nothing_would_stop_is_warned_of() -> None:
    alarms = [rule for rule in BASE["alarms"] if rule["kind"] != "over_temperature"]
    assert any("nothing stops this motor" in warning for warning in parse(text({"alarms": alarms})).warnings)
    assert not any("nothing stops" in warning for warning in parse(text({})).warnings)


def test_a_stop_that_can_never_act_is_warned_of() -> None:
    alarms = copy.deepcopy(BASE["alarms"])
    alarms[0]["stop_motor"] = True
    observed = parse(text({"alarms": alarms, "wiring": {"drive": None, "observe": {"forward_pin": 4}}}))
    assert any('"fault" stops nothing' in warning for warning in observed.warnings)


REFUSED = {
    "a pause of what ends by itself": ({}, {"cause": "stall", "action": "stop", "pause_s": 5}, "pause_s"),
    "a pause that is too long": (
        {},
        {"cause": "stall", "action": "stop", "until": "command", "pause_s": 2e4},
        "at most 16383.5",
    ),
    "unseen by no limit": ({"alarms": []}, {"cause": "sensor_unseen", "action": "stop"}, "no limit watches a part"),
    "no drive": ({"wiring": {"drive": None}}, {"cause": "late_loop", "action": "stop"}, 'no "drive"'),
    "no relay": ({}, {"cause": "late_loop", "action": "open_relay"}, 'no "relay_pin"'),
    "no LED": ({"wiring": {"led_pin": None}}, {"cause": "late_loop", "action": "led"}, 'no "led_pin"'),
    "no encoder": ({"wiring": {"encoder": None}}, {"cause": "stall", "action": "stop"}, "an encoder"),
    "no time-out": ({}, {"cause": "command_timeout", "action": "stop"}, "command_timeout_s"),
    "no such rule": ({}, {"cause": "alarm", "rule": "nobody", "action": "stop"}, "the name of a rule"),
    "no rule": ({}, {"cause": "alarm", "action": "stop"}, 'missing key "rule"'),
    "no such channel": ({}, {"cause": "sensor_lost", "channel": "tail", "action": "stop"}, "a thermocouple's channel"),
    "other's key": ({}, {"cause": "stall", "rule": "fault", "action": "stop"}, 'only "alarm" has it'),
    "derate to what nobody knows": (
        {},
        {"cause": "stall", "action": "derate", "derate_pwm": "holdable"},
        '"holdable" can never be known: the file lacks "forecast"',
    ),
    "derate to another word": (
        {},
        {"cause": "stall", "action": "derate", "derate_pwm": "hold"},
        'found the text "hold", expected "holdable"',
    ),
    "derate to more than full": (
        {},
        {"cause": "stall", "action": "derate", "derate_pwm": 256},
        "found 256, expected at most 255",
    ),
    "derate to what": ({}, {"cause": "stall", "action": "derate"}, "derate_pwm"),
    "too many sensors": ({}, {"cause": "too_few_sensors", "least": 5, "action": "stop"}, "at most 4"),
    "cool when": (
        {},
        {"cause": "stall", "action": "stop", "until": "cool", "component": "brush"},
        "restart_below_degC",
    ),
    "cool what": ({}, {"cause": "stall", "action": "stop", "until": "cool", "restart_below_degC": 50}, "which part"),
    "not a part": (
        {},
        {"cause": "stall", "action": "stop", "until": "cool", "restart_below_degC": 50, "component": "tail"},
        "a part with a thermocouple",
    ),
    "never commissioned": (
        {"wiring": {"thermocouples": BASE["wiring"]["thermocouples"][4:]}},
        {"cause": "not_commissioned", "action": "stop"},
        "can never end",
    ),
    "commissioned by reset": (
        {},
        {"cause": "not_commissioned", "action": "stop", "until": "command"},
        'expected "itself"',
    ),
    "unknown cause": ({}, {"cause": "boredom", "action": "stop"}, "cause"),
    "too long": ({}, {"cause": "stall", "action": "stop", "delay_s": 90000}, "expected at most"),
}


def test_a_board_that_nobody_has_commissioned_is_stopped_only_where_the_file_says_so() -> None:
    assert "not_commissioned" not in table(wiring={"relay_pin": 12})
    found = table(wiring={"relay_pin": 12}, protection=[{"cause": "not_commissioned", "action": "open_relay"}])
    assert found["not_commissioned"].stops
    assert "sensor_lost" in found


@pytest.mark.parametrize(("changes", "entry", "message"), REFUSED.values(), ids=REFUSED)
def test_an_entry_that_can_never_be_or_never_act_is_refused(
    changes: dict[str, Any], entry: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        parse(text({**changes, "protection": [entry]}))
    assert str(caught.value).startswith("$.protection[0]")


def test_two_entries_of_one_cause_need_names() -> None:
    entries: list[dict[str, Any]] = [
        {"cause": "stall", "action": "led"},
        {"cause": "stall", "action": "stop", "delay_s": 5},
    ]
    with pytest.raises(InputError, match='expected a "name" of its own'):
        parse(text({"protection": entries}))
    entries[1]["name"] = "long_stall"
    assert table(protection=entries)["long_stall"].delay_s == 5.0


def test_a_relay_on_the_boot_loaders_pin_is_refused() -> None:
    with pytest.raises(InputError, match="relay would close at every reset"):
        parse(text({"wiring": {"led_pin": None, "relay_pin": 13}}))


def test_a_time_out_without_anything_that_is_commanded_is_refused() -> None:
    with pytest.raises(InputError, match="command_timeout_s"):
        parse(text({"wiring": {"drive": None, "command_timeout_s": 5}}))


def test_a_pin_of_the_clocks_timer_keeps_its_frequency() -> None:
    with pytest.raises(InputError, match="stays at 976 Hz"):
        parse(text({"wiring": {"drive": {"forward_pin": 4, "reverse_pin": 5, "frequency_Hz": 3922}}}))
