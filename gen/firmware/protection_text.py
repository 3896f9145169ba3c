"""Causes and actions in words, for the header, the README and the report of an emitted project."""

from __future__ import annotations

from gen.coefficients.document import Document
from gen.coefficients.protecting import cooling_part, watched_channels
from gen.coefficients.protection import Action, Cause, Protection
from gen.coefficients.wiring import Supply
from gen.lowering.protection import FORGOTTEN_S

_CAUSES: dict[Cause, str] = {
    "ambient_lost": "the ambient's thermocouple is not believed",
    "stall": "PWM, and the motor does not turn",
    "overspeed": "more than 120 % of the nominal speed",
    "turning_without_command": "the motor turns at PWM 0",
    "limit_near": "a part will reach its limit within the time in $.forecast.near_s",
    "late_loop": "samples are taken late",
    "command_timeout": "no command for the time in $.wiring.command_timeout_s",
    "flash_check": "the program in flash is not what was built",
    "ram_check": "a cell of the RAM does not hold what is written to it",
    "cpu_check": "a register of the CPU does not hold what is written to it",
    "clock_check": "the clock and the watchdog's oscillator disagree",
    "eeprom_check": "a copy in EEPROM could not be written",
    "not_commissioned": "nobody has commissioned this wiring",
}
_ACTIONS: dict[Action, str] = {
    "log": "an event",
    "led": "an event and the LED",
    "derate": "PWM limited",
    "stop": "the motor stops",
    "open_relay": "the motor stops and the relay opens",
}


def cause_text(document: Document, entry: Protection) -> str:
    """What an entry waits for, its delay included."""
    for_long = f" for {entry.delay_s:g} s" if entry.delay_s else ""
    return f"{_cause(document, entry)}{for_long}"


def action_text(entry: Protection) -> str:
    """What the board does meanwhile."""
    if entry.holds:
        return f"{_ACTIONS[entry.action]} to what can be held, $.forecast"
    limited = f" to {entry.derate_pwm}" if entry.derate_pwm is not None else ""
    return f"{_ACTIONS[entry.action]}{limited}"


def end_text(document: Document, entry: Protection) -> str:
    """How it ends."""
    if entry.until == "itself":
        return "by itself"
    end = "by command"
    if entry.until == "cool":
        end += f", once {cooling_part(document, entry)} is below {entry.restart_below_degC:g} degC"
    if entry.pause_s:
        end += (
            f", when it came again within {FORGOTTEN_S:g} s not before {entry.pause_s:g} s, then twice that, and so on"
        )
    return end


def protection_text(document: Document, entry: Protection) -> str:
    """All of it on one line."""
    return f"{cause_text(document, entry)}: {action_text(entry)}; ends {end_text(document, entry)}"


def _cause(document: Document, entry: Protection) -> str:
    if entry.cause == "alarm":
        return f"alarm {entry.rule}"
    if entry.cause == "sensor_lost":
        channels = [entry.channel] if entry.channel is not None else watched_channels(document)
        return f"no believed sample of {' or '.join(map(str, channels))}"
    if entry.cause == "sensor_unseen":
        return f"no believed sample of {' or '.join(watched_channels(document))} since the start"
    if entry.cause == "too_few_sensors":
        return f"fewer than {entry.least} parts with a believed sample"
    if entry.cause == "supply_low":
        supply = document.wiring.own_supply if document.wiring is not None else Supply()
        return f"less than {supply.limit_mV:g} mV at the board's own supply, against {supply.reference_mV:g} mV"
    return _CAUSES[entry.cause]
