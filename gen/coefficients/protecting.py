"""The table of causes and actions that a board has: what the file says, and defaults where it says nothing."""

from __future__ import annotations

from gen.coefficients.alarms import AlarmRule, OverTemperature
from gen.coefficients.base import COLDEST_degC
from gen.coefficients.document import Document
from gen.coefficients.protection import MOST_PROTECTIONS, Action, Protection
from gen.coefficients.wiring import Wiring
from gen.errors import InputError

COOLED_K = 10.0
"""So far below its limit a part must be before a motor that it stopped may run again, where the file says nothing."""
BLIND_S = 10.0
"""So long a motor may be driven without a thermocouple that a stopping rule needs, where the file says nothing."""
TURNING_S = 60.0
"""So long a motor may run on at PWM 0, where the file says nothing: a flywheel, a fan."""
OVERSPEED_S = 2.0
SUPPLY_S = 1.0
"""So long the board's supply may be low, where the file says nothing: a motor that starts pulls it down."""
PAUSE_S = 15.0
"""So long a rotor that locks again soon has to stand, twice as long each further time, where the file says nothing."""


def protections(document: Document) -> tuple[Protection, ...]:
    """Every cause that the board acts on, those of the file first.

    What the file names is as it says. Where a motor is driven, or a relay can part it from its supply, the causes that
    it does not name have defaults: a rule that stops the motor does, and so does the loss of a sensor that it needs,
    a stall, a silent line where it is watched, a damaged program.

    Parameters
    ----------
    document
        A checked coefficient file.

    Raises
    ------
    InputError
        If they are more than the board has bits for.
    """
    found = [*document.protection, *_of_rules(document)]
    named = {entry.cause for entry in document.protection}
    found += [entry for entry in (*_of_wiring(document), *_of_supply(document)) if entry.cause not in named]
    if len(found) > MOST_PROTECTIONS:
        raise InputError(
            f"with defaults there are {len(found)} causes, expected at most {MOST_PROTECTIONS}", place="$.protection"
        )
    return tuple(_apart(found))


def can_stop(wiring: Wiring | None) -> bool:
    """Whether anything on the board can make the motor stand."""
    return wiring is not None and (wiring.drive is not None or wiring.relay_pin is not None)


def limited_parts(document: Document) -> set[str]:
    """Parts of which an over-temperature rule stops the motor, by the rule or by the file's table."""
    stopping = {entry.rule for entry in (*document.protection, *_of_rules(document)) if entry.stops}
    return {rule.component for rule in document.alarms if isinstance(rule, OverTemperature) and rule.name in stopping}


def watched_channels(document: Document) -> list[str]:
    """Those of them that have a thermocouple, in the wiring's order."""
    wired = document.wiring.thermocouples if document.wiring is not None else ()
    limited = limited_parts(document)
    return [chip.channel for chip in wired if chip.channel in limited]


def cooling_part(document: Document, entry: Protection) -> str | None:
    """The part whose cooling an entry waits for, its own or that of its rule; None of one that does not wait."""
    if entry.until != "cool" or entry.component is not None:
        return entry.component
    return next(rule.component for rule in document.alarms if rule.name == entry.rule)


def _of_rules(document: Document) -> list[Protection]:
    """What rules do of which the file's table says nothing."""
    wiring = document.wiring
    if wiring is None or not can_stop(wiring):
        return []
    named = {entry.rule for entry in document.protection}
    found = []
    for rule in document.alarms:
        if rule.name in named or not _stops(rule):
            continue
        if isinstance(rule, OverTemperature):
            # A rule that never clears lets nothing run again.
            below = max(rule.limit_degC - max(COOLED_K, rule.hysteresis_K), COLDEST_degC)
            found.append(
                Protection(
                    cause="alarm",
                    rule=rule.name,
                    action=_strongest(wiring),
                    until="cool",
                    restart_below_degC=below,
                )
            )
        else:
            found.append(Protection(cause="alarm", rule=rule.name, action=_gentlest(wiring), until="command"))
    return found


def _of_wiring(document: Document) -> list[Protection]:
    """Causes beside the rules: only where something can be done about them."""
    wiring = document.wiring
    if wiring is None or not can_stop(wiring):
        return []
    hard, soft = _strongest(wiring), _gentlest(wiring)
    found = []
    if watched_channels(document):
        # A relay that closed by itself would start a motor that another controller drives.
        found.append(
            Protection(cause="sensor_lost", delay_s=BLIND_S, action=soft, until="itself" if wiring.drive else "command")
        )
        # Nobody drives blind from the start: whose file lets a motor run on without a sensor is taken at its word.
        lost = [entry for entry in document.protection if entry.cause == "sensor_lost"]
        if not lost or any(entry.stops for entry in lost):
            found.append(Protection(cause="sensor_unseen", action=soft, until="itself" if wiring.drive else "command"))
    if any(chip.channel == "ambient" for chip in wiring.thermocouples):
        found.append(Protection(cause="ambient_lost", delay_s=BLIND_S, action="led"))
    if wiring.encoder is not None:
        found.append(Protection(cause="stall", action=soft, until="command", pause_s=PAUSE_S))
        found.append(Protection(cause="overspeed", delay_s=OVERSPEED_S, action="led"))
        if wiring.drive is not None:
            action: Action = "open_relay" if wiring.relay_pin is not None else "led"
            found.append(Protection(cause="turning_without_command", delay_s=TURNING_S, action=action))
    if wiring.command_timeout_s is not None:
        found.append(Protection(cause="command_timeout", action="stop"))
    found.append(Protection(cause="flash_check", action=hard, until="command"))
    found.append(Protection(cause="ram_check", action=hard, until="command"))
    found.append(Protection(cause="cpu_check", action=hard, until="command"))
    if wiring.led_pin is not None:  # the data sheet promises no limits for the watchdog's oscillator
        found.append(Protection(cause="clock_check", action="led"))
    return found


def _of_supply(document: Document) -> list[Protection]:
    """Where the file has it measured it is told, also by a board that can stop nothing."""
    wiring = document.wiring
    if wiring is None or wiring.supply is None:
        return []
    action: Action = "log" if wiring.led_pin is None else "led"
    return [Protection(cause="supply_low", delay_s=SUPPLY_S, action=action)]


def _stops(rule: AlarmRule) -> bool:
    """Whether a rule stops a motor that can be stopped: as it says; where it says nothing, if it is a limit."""
    return isinstance(rule, OverTemperature) if rule.stop_motor is None else rule.stop_motor


def _strongest(wiring: Wiring) -> Action:
    """What a board does about a motor that must not run: its relay opens where there is one."""
    return "stop" if wiring.relay_pin is None else "open_relay"


def _gentlest(wiring: Wiring) -> Action:
    """What it does about one that has to stand: PWM 0 is enough where the board drives it."""
    return "open_relay" if wiring.drive is None else "stop"


def _apart(entries: list[Protection]) -> list[Protection]:
    """The entries under names of their own: a rule may be called as a cause is."""
    found: list[Protection] = []
    taken: set[str] = set()
    for entry in entries:
        label = entry.label
        while label.lower() in taken:
            label = f"{label}_too"
        taken.add(label.lower())
        found.append(entry if label == entry.label else entry.model_copy(update={"name": label}))
    return found
