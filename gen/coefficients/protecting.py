"""The table of causes and actions that a board has: what the file says, and defaults where it says nothing."""

from __future__ import annotations

from collections.abc import Sequence

from gen.coefficients.alarms import AlarmRule, OverTemperature
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
    written = document.protection
    named = {(entry.cause, entry.rule) for entry in written}
    causes = {entry.cause for entry in written}
    wiring = document.wiring or Wiring()
    found = list(written)
    labels = {entry.label.lower() for entry in written}
    for entry in (*_of_rules(document, wiring), *_of_wiring(document, wiring)):
        if (entry.cause, entry.rule) in named or (entry.cause != "alarm" and entry.cause in causes):
            continue
        label = entry.label
        while label.lower() in labels:  # a rule may be called as a cause is
            label = f"{label}_too"
        labels.add(label.lower())
        found.append(entry if label == entry.label else entry.model_copy(update={"name": label}))
    if len(found) > MOST_PROTECTIONS:
        raise InputError(
            f"with defaults there are {len(found)} causes, expected at most {MOST_PROTECTIONS}", place="$.protection"
        )
    return tuple(found)


def can_stop(wiring: Wiring | None) -> bool:
    """Whether anything on the board can make the motor stand."""
    return wiring is not None and (wiring.drive is not None or wiring.relay_pin is not None)


def rule_stops(document: Document, rule: AlarmRule) -> bool:
    """Whether a rule stops the motor: as it says; where it says nothing, if it is a limit and anything can stop it."""
    if rule.stop_motor is None:
        return isinstance(rule, OverTemperature) and can_stop(document.wiring)
    return rule.stop_motor


def strongest(wiring: Wiring) -> Action:
    """What a board does about a motor that must not run: its relay opens where there is one."""
    if wiring.relay_pin is not None:
        return "open_relay"
    return "stop" if wiring.drive is not None else "led"


def _of_rules(document: Document, wiring: Wiring) -> list[Protection]:
    found = []
    for rule in document.alarms:
        if not rule_stops(document, rule) or not can_stop(wiring):
            continue
        if isinstance(rule, OverTemperature):
            below = rule.limit_degC - max(COOLED_K, rule.hysteresis_K)
            found.append(
                Protection(
                    cause="alarm",
                    rule=rule.name,
                    action=strongest(wiring),
                    until="cool",
                    restart_below_degC=below,
                )
            )
        else:
            action: Action = "stop" if wiring.drive is not None else "open_relay"
            found.append(Protection(cause="alarm", rule=rule.name, action=action, until="command"))
    return found


def _of_wiring(document: Document, wiring: Wiring) -> list[Protection]:
    """Causes beside the rules: only where something can be done about them."""
    if not can_stop(wiring):
        return []
    hard = strongest(wiring)
    soft: Action = "stop" if wiring.drive is not None else hard
    found = []
    if watched_channels(document):
        # A relay that closed by itself would start a motor that another controller drives.
        found.append(
            Protection(cause="sensor_lost", delay_s=BLIND_S, action=soft, until="itself" if wiring.drive else "command")
        )
    if any(chip.channel == "ambient" for chip in wiring.thermocouples):
        found.append(Protection(cause="ambient_lost", delay_s=BLIND_S, action="led"))
    if wiring.encoder is not None:
        found.append(Protection(cause="stall", action=soft, until="command"))
        found.append(Protection(cause="overspeed", delay_s=OVERSPEED_S, action="led"))
        if wiring.drive is not None:
            action: Action = "open_relay" if wiring.relay_pin is not None else "led"
            found.append(Protection(cause="turning_without_command", delay_s=TURNING_S, action=action))
    if wiring.command_timeout_s is not None:
        found.append(Protection(cause="command_timeout", action="stop"))
    found.append(Protection(cause="flash_check", action=hard, until="command"))
    found.append(Protection(cause="ram_check", action=hard, until="command"))
    return found


def watched_channels(document: Document) -> list[str]:
    """Parts with a thermocouple that an over-temperature rule which stops the motor watches, in the wiring's order."""
    wired = document.wiring.thermocouples if document.wiring is not None else ()
    limited = limited_parts(document)
    return [chip.channel for chip in wired if chip.channel in limited]


def limited_parts(document: Document) -> set[str]:
    """Parts of which an over-temperature rule stops the motor, by the rule or by the file's table."""
    entries: Sequence[Protection] = document.protection
    stopping = {entry.rule for entry in entries if entry.stops}
    spared = {entry.rule for entry in entries if not entry.stops} - stopping
    return {
        rule.component
        for rule in document.alarms
        if isinstance(rule, OverTemperature)
        and rule.name not in spared
        and (rule.name in stopping or rule_stops(document, rule))
    }
