"""Coefficient files for the sketch's tests: the MY1016 with another wiring."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Mapping
from typing import Any

from gen.coefficients import Coefficients, parse
from tests.examples import ROOT

Tree = dict[str, Any]
BASE: Tree = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
#: As in the study the encoder interrupts, which asks more of the sketch: a count in hardware is `_counted`'s.
BASE["wiring"]["encoder"]["pin"], BASE["wiring"]["thermocouples"][4]["so"] = 2, 47
#: A change of sign acts at once: its microseconds are watched.
BASE["wiring"]["drive"]["reversal_pause_s"] = 0
CHIPS = [(chip["cs"], chip["so"], chip["sck"]) for chip in BASE["wiring"]["thermocouples"]]
CHANNELS = [chip["channel"] for chip in BASE["wiring"]["thermocouples"]]


def _as_it_is(tree: Tree) -> None:
    del tree


def _no_wiring(tree: Tree) -> None:
    del tree["wiring"]
    tree["alarms"] = []


def _protected(tree: Tree) -> None:
    """What protects by itself, with a relay, a time-out and a ramp."""
    tree["wiring"] |= {"relay_pin": 12, "command_timeout_s": 20}
    tree["wiring"]["drive"] |= {"ramp_s": 2.0, "reversal_pause_s": 1.0}


def _often_copied(tree: Tree) -> None:
    tree["wiring"]["memory"] = {"interval_s": 60}


def _soon_stuck(tree: Tree) -> None:
    for chip in tree["wiring"]["thermocouples"]:
        chip |= {"stuck_s": 20, "stuck_K": 0.1}


#: By channel, in the file's order.
KINDS = {"brush": "MAX31855", "bearing": "MAX31856", "magnet": "MAX31865", "casing": "MAX31865", "ambient": "MAX6675"}


def _every_chip(tree: Tree) -> None:
    """One of each kind, and a PT1000 on three wires; all share their lines."""
    for chip in tree["wiring"]["thermocouples"]:
        chip |= {"so": 50, "sck": 52, "chip": KINDS[chip["channel"]]}
        if chip["chip"] != "MAX6675":
            chip["min_degC"] = -40.0
        if chip["chip"] in ("MAX31856", "MAX31865"):
            chip["sdi"] = 51
    tree["wiring"]["thermocouples"][3] |= {"rtd_ohm": 1000, "reference_ohm": 4000, "wires": 3}
    del tree["wiring"]["encoder"]


def _other_chips(tree: Tree) -> None:
    """Each on lines of its own kind alone: without a MAX6675."""
    for chip in tree["wiring"]["thermocouples"]:
        chip["chip"] = "MAX31855"


def _profile(tree: Tree) -> None:
    steps = [{"duration_s": 1, "pwm": 100}, {"duration_s": 2, "pwm": -50}]
    tree["wiring"]["drive"]["profile"] = {"steps": steps}


def _directed(tree: Tree) -> None:
    """One PWM pin, of a timer that stops at PWM 0, and a direction pin."""
    tree["wiring"]["drive"] = {"pwm_pin": 9, "direction_pin": 7, "reversal_pause_s": 0}


def _directed_low(tree: Tree) -> None:
    """Forward is low, on the boot loader's LED; the PWM is Timer 0's, which runs on; a profile."""
    del tree["wiring"]["led_pin"]
    steps = [{"duration_s": 1, "pwm": 100}, {"duration_s": 2, "pwm": -50}]
    drive = {"pwm_pin": 4, "direction_pin": 13, "forward_level": "low", "profile": {"steps": steps}}
    tree["wiring"]["drive"] = drive | {"reversal_pause_s": 0}


def _fast_pwm(tree: Tree) -> None:
    tree["wiring"]["drive"] = {"forward_pin": 6, "reverse_pin": 7, "frequency_Hz": 31373}


def _observed(tree: Tree) -> None:
    del tree["wiring"]["drive"]
    del tree["wiring"]["led_pin"]
    tree["wiring"]["observe"] = {"forward_pin": 4, "reverse_pin": 5}
    tree["wiring"]["memory"] = None


def _counted(tree: Tree) -> None:
    """Another sample time, which is shorter than a conversion; the encoder in hardware; no button."""
    wiring = tree["wiring"]
    tree["sample_time_s"], tree["accuracy"] = 0.1, {"fixed_limit_K": 1e-3}
    wiring["encoder"]["pin"] = 47
    wiring["thermocouples"][4]["so"] = 46
    wiring["drive"] = {"forward_pin": 6, "reverse_pin": 7}
    del wiring["button_pin"]


def _ambient_only(tree: Tree) -> None:
    tree["wiring"]["thermocouples"] = tree["wiring"]["thermocouples"][4:]
    del tree["wiring"]["encoder"]


def _slow(tree: Tree) -> None:
    """A sample time longer than the watchdog's."""
    tree["sample_time_s"], tree["accuracy"] = 2.5, {"fixed_limit_K": 1e-3}
    tree["wiring"] = {"button_pin": 22}


def _one_pulse(tree: Tree) -> None:
    tree["wiring"]["encoder"]["pulses_per_revolution"] = 1


def _voltages(tree: Tree) -> None:
    """Two voltages. (The emulator has no A8..A15: the core's own analogRead() gives 0 there.)"""
    inputs = [{"column": "a_V", "analog_pin": 54}, {"column": "b_V", "analog_pin": 55}]
    tree["wiring"]["channels"] = inputs


def _supplied(tree: Tree) -> None:
    """A chip whose reference was measured, and two voltages beside it."""
    _voltages(tree)
    tree["wiring"]["supply"] = {"bandgap_mV": 1150}


def _unmeasured_reference(tree: Tree) -> None:
    """What a file says that knows nothing of its chip; nothing else is converted."""
    tree["wiring"]["supply"] = {}


#: What a data sheet says of a usual 10 kOhm bead.
BEAD = {"chip": "NTC", "r25_ohm": 10000, "beta_K": 3950, "series_ohm": 2200, "min_degC": -20, "max_degC": 140}
#: Its neighbour's three numbers, at the supply.
OTHER_BEAD = {
    "chip": "NTC",
    "steinhart_hart": [1.129148e-3, 2.34125e-4, 8.76741e-8],
    "series_ohm": 1000,
    "thermistor_to": "supply",
}


def _thermistors(tree: Tree) -> None:
    """Two NTCs beside MAX6675s and a voltage; their limits are within what they tell."""
    wired = tree["wiring"]["thermocouples"]
    wired[0] = {"channel": "brush", "analog_pin": 55, **BEAD}
    wired[3] = {"channel": "casing", "analog_pin": 57, **OTHER_BEAD}
    tree["wiring"]["channels"] = [{"column": "a_V", "analog_pin": 56}]
    tree["wiring"]["supply"] = {"bandgap_mV": 1100}


def _thermistors_alone(tree: Tree) -> None:
    """No chip, and so no line of one; the second of the same kind needs no table of its own."""
    channels = CHANNELS[:2] + CHANNELS[4:]
    tree["wiring"]["thermocouples"] = [
        {"channel": channel, "analog_pin": 54 + number, **BEAD} for number, channel in enumerate(channels)
    ]
    tree["alarms"] = []


def _autostart(tree: Tree) -> None:
    _profile(tree)
    tree["wiring"]["drive"]["profile"] |= {"repeat": True, "autostart": True}


def _watched_brush(tree: Tree) -> None:
    """One rule, at a part whose slopes a start from its temperature alone does not know."""
    _often_copied(tree)
    rule = {"name": "hot", "kind": "above_model", "component": "brush", "threshold_K": 3.0, "persistence_s": 1}
    tree["alarms"] = [rule]


def _prompt(tree: Tree) -> None:
    """One rule that speaks at the first sample at which the casing is too cold for its model."""
    rule = {"name": "cold", "kind": "below_model", "component": "casing", "threshold_K": 0.2, "persistence_s": 0}
    tree["alarms"] = [rule]


def _limited(tree: Tree) -> None:
    """One rule that protects: the brush's limit, at once."""
    rule = {"name": "limit", "kind": "over_temperature", "component": "brush", "limit_degC": 120, "hysteresis_K": 5}
    tree["alarms"] = [{**rule, "persistence_s": 0, "stop_motor": True, "look_ahead": False}]


def _foresighted(tree: Tree) -> None:
    """The brush's limit with a second of persistence, which looks ahead; the casing's, which does not."""
    rule = {"kind": "over_temperature", "limit_degC": 120, "hysteresis_K": 5, "persistence_s": 1}
    tree["alarms"] = [
        {"name": "limit", "component": "brush", **rule},
        {"name": "patient", "component": "casing", "look_ahead": False, **rule},
    ]


def _locked(tree: Tree) -> None:
    """Nothing but the commissioning drives before it was passed; a line that falls silent soon, and a slow driver."""
    tree["wiring"] |= {"relay_pin": 12, "command_timeout_s": 2}
    tree["wiring"]["drive"] |= {"ramp_s": 2.0, "reversal_pause_s": 1.0}
    tree["protection"] = [{"cause": "not_commissioned", "action": "open_relay"}]


def _watched(tree: Tree) -> None:
    """Another controller's motor, with copies in EEPROM."""
    memory = tree["wiring"].get("memory")
    _observed(tree)
    tree["wiring"] |= {"memory": memory or {}}


def _zeroed_by_command(tree: Tree) -> None:
    """Offsets are learnt when somebody says so."""
    tree["wiring"]["zero"] = {"automatic": False, "tolerance_K": 1.5}


def _zeroed(tree: Tree) -> None:
    """Offsets are learnt, by a model that cools down within a minute; a rule that hears of the casing's."""
    tree["wiring"] |= {"zero": {}, "memory": {"interval_s": 60}}
    for chip in tree["wiring"]["thermocouples"]:
        chip["stuck_s"] = 10_000  # the tests' rooms are without noise
    for component in tree["components"]:
        component |= {"order": 1, "gain": {"poly": [0.005]}, "poles": [{"real": {"poly": [-0.05]}}]}
    tree["accuracy"] = {"fixed_limit_K": 1e-3}
    rule = {"name": "off", "kind": "above_model", "component": "casing", "threshold_K": 0.8, "persistence_s": 0}
    tree["alarms"] = [rule]


def _quiet(tree: Tree) -> None:
    """Most tests are not about protection: no motor turns in them, and thermocouples come and go."""
    wiring = tree.get("wiring", {})
    measured = {chip["channel"] for chip in wiring.get("thermocouples", ())}
    limited = {rule["component"] for rule in tree["alarms"] if rule["kind"] == "over_temperature"}
    tree["protection"] = [{"cause": "stall", "action": "log"}] if "encoder" in wiring else []
    if measured & limited:
        tree["protection"].append({"cause": "sensor_lost", "delay_s": 1000, "action": "log"})


VARIANTS: Mapping[str, Callable[[Tree], None]] = {
    "my1016": _as_it_is,
    "no_wiring": _no_wiring,
    "often_copied": _often_copied,
    "soon_stuck": _soon_stuck,
    "profile": _profile,
    "directed": _directed,
    "directed_low": _directed_low,
    "observed": _observed,
    "counted": _counted,
    "ambient_only": _ambient_only,
    "slow": _slow,
    "one_pulse": _one_pulse,
    "voltages": _voltages,
    "protected": _protected,
    "fast_pwm": _fast_pwm,
    "every_chip": _every_chip,
    "other_chips": _other_chips,
}

FURTHER: Mapping[str, Callable[[Tree], None]] = {
    "autostart": _autostart,
    "watched_brush": _watched_brush,
    "prompt": _prompt,
    "limited": _limited,
    "foresighted": _foresighted,
    "locked": _locked,
    "watched": _watched,
    "zeroed": _zeroed,
    "zeroed_by_command": _zeroed_by_command,
    "supplied": _supplied,
    "thermistors": _thermistors,
    "thermistors_alone": _thermistors_alone,
    "unmeasured_reference": _unmeasured_reference,
}
"""For a test or two of their own; wired as one of the others."""


def variant(name: str) -> Coefficients:
    tree = copy.deepcopy(BASE)
    {**VARIANTS, **FURTHER}[name](tree)
    if name not in ("protected", "locked"):
        _quiet(tree)
    return parse(json.dumps(tree).encode())
