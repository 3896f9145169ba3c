"""The table of causes and actions against what the file has of rules, sensors and pins: no entry that can never act."""

from __future__ import annotations

from collections.abc import Sequence

from gen.coefficients.alarms import MOST_SAMPLES, AlarmRule, OverTemperature
from gen.coefficients.base import fault, listed
from gen.coefficients.forecast import LEAST_STEPS_TO_HOLD, Forecast
from gen.coefficients.protection import Protection
from gen.coefficients.wiring import Wiring

_AT = "protection"


def check_protection(
    entries: Sequence[Protection],
    alarms: Sequence[AlarmRule],
    wiring: Wiring | None,
    full_scale: int,
    sample_time_s: float,
    *,
    forecast: Forecast | None,
    commissions: bool,
) -> None:
    """Check the file's own entries.

    Parameters
    ----------
    entries, alarms, wiring
        The file's.
    full_scale
        The count that is 100 %.
    sample_time_s
        In s.
    forecast
        How the board looks ahead; None: it does not.
    commissions
        The board can be commissioned.

    Raises
    ------
    PydanticCustomError
        At the first entry that names what is not there, or that could never come about or never act.
    """
    board = wiring if wiring is not None else Wiring()
    labels: set[str] = set()
    for i, entry in enumerate(entries):
        if entry.label.lower() in labels:
            raise fault(f'"{entry.label}" is another entry\'s name already; expected a "name" of its own', _AT, i)
        labels.add(entry.label.lower())
        _check_rule(entry, i, alarms)
        foresees = forecast is not None and forecast.near_s is not None
        _check_cause(entry, i, alarms, board, foresees=foresees)
        if entry.cause == "not_commissioned" and not commissions:
            raise fault(
                '"not_commissioned" can never end: $.wiring lacks "memory", or a part with a thermocouple',
                _AT,
                i,
                "cause",
            )
        _check_action(entry, i, board, full_scale)
        if entry.holds:
            _check_held(i, forecast)
        for key, value in (("delay_s", entry.delay_s), ("pause_s", entry.pause_s)):
            if value > MOST_SAMPLES * sample_time_s:
                raise fault(f"found {value:g}, expected at most {MOST_SAMPLES * sample_time_s:g}", _AT, i, key)
        part = entry.component
        if part is not None and part not in _channels(board):
            raise fault(
                f'found "{part}", expected a part with a thermocouple: {listed(_channels(board))}', _AT, i, "component"
            )


def _check_rule(entry: Protection, i: int, alarms: Sequence[AlarmRule]) -> None:
    names = [rule.name for rule in alarms]
    if entry.rule is not None and entry.rule not in names:
        expected = f"the name of a rule: {listed(names)}" if names else "none, as there are no rules"
        raise fault(f'found "{entry.rule}", expected {expected}', _AT, i, "rule")


def _check_cause(entry: Protection, i: int, alarms: Sequence[AlarmRule], wiring: Wiring, *, foresees: bool) -> None:
    """The cause can come about."""
    channels = _channels(wiring)
    lacking = {
        "ambient_lost": None if "ambient" in channels else "a thermocouple of the ambient",
        "too_few_sensors": None if channels else "thermocouples",
        "sensor_lost": None if channels else "thermocouples",
        "sensor_unseen": None if channels else "thermocouples",
        "stall": None if wiring.encoder else "an encoder",
        "overspeed": None if wiring.encoder else "an encoder",
        "turning_without_command": None if wiring.encoder and wiring.drive else "an encoder and a drive",
        "command_timeout": None if wiring.command_timeout_s is not None else '"command_timeout_s"',
        "eeprom_check": None
        if wiring.memory is not None and channels
        else "copies in EEPROM, which need thermocouples",
    }.get(entry.cause)
    if lacking is not None:
        raise fault(f'"{entry.cause}" can never be: $.wiring lacks {lacking}', _AT, i, "cause")
    if entry.cause == "limit_near" and not foresees:
        raise fault('"limit_near" can never be: $.forecast lacks "near_s"', _AT, i, "cause")
    if entry.channel is not None and entry.channel not in channels:
        raise fault(
            f'found "{entry.channel}", expected a thermocouple\'s channel: {listed(channels)}', _AT, i, "channel"
        )
    if entry.cause == "sensor_unseen" or (entry.cause == "sensor_lost" and entry.channel is None):
        limited = {rule.component for rule in alarms if isinstance(rule, OverTemperature)}
        if not limited.intersection(channels):
            expected = '; expected a "channel"' if entry.cause == "sensor_lost" else ""
            raise fault(f"no limit watches a part with a thermocouple{expected}", _AT, i)
    parts = [channel for channel in channels if channel != "ambient"]
    if entry.least is not None and entry.least > len(parts):
        raise fault(f"found {entry.least}, expected at most {len(parts)}, as many parts are measured", _AT, i, "least")


def _check_action(entry: Protection, i: int, wiring: Wiring, full_scale: int) -> None:
    """The action can act."""
    if entry.action in ("stop", "derate") and wiring.drive is None:
        raise fault(f'"{entry.action}" can never act: $.wiring has no "drive"', _AT, i, "action")
    if entry.action == "open_relay" and wiring.relay_pin is None:
        raise fault('"open_relay" can never act: $.wiring has no "relay_pin"', _AT, i, "action")
    if entry.action == "led" and wiring.led_pin is None:
        raise fault('"led" can never act: $.wiring has no "led_pin"', _AT, i, "action")
    if isinstance(entry.derate_pwm, int) and entry.derate_pwm > full_scale:
        raise fault(f"found {entry.derate_pwm}, expected at most {full_scale}, the full scale", _AT, i, "derate_pwm")


def _check_held(i: int, forecast: Forecast | None) -> None:
    """What can be held is known, and is known before it is too old."""
    if forecast is None:
        raise fault('"holdable" can never be known: the file lacks "forecast"', _AT, i, "derate_pwm")
    if forecast.steps_per_sample < LEAST_STEPS_TO_HOLD:
        raise fault(
            f"found {forecast.steps_per_sample}, expected at least {LEAST_STEPS_TO_HOLD}, "
            'since a "derate_pwm" is "holdable"',
            "forecast",
            "steps_per_sample",
        )


def _channels(wiring: Wiring) -> list[str]:
    return [chip.channel for chip in wiring.thermocouples]
