"""What a board's LED and its relay do, in words: as its pins show it, or as its rows tell it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gen.live.known import Known

UNKNOWN = "unknown"
_WORDS = {
    "dark": "dark",
    "lit": "lit all the time",
    "healthy": "a short flash every 2 s: healthy",
    "sensor": "flicker: a thermocouple is not believed",
    "acts": "a second on, a second off: the board acts on something",
}


@dataclass(frozen=True)
class Signals:
    """What LED and relay do.

    Attributes
    ----------
    led, relay
        In words; empty where the board has none, `UNKNOWN` where nobody can tell.
    told
        How it is known, or why not.
    """

    led: str
    relay: str
    told: str


def from_pins(patterns: Sequence[str] | None, closed: bool | None, rules: Sequence[str]) -> Signals:
    """Tell what was seen at an emulated board's pins.

    Parameters
    ----------
    patterns
        The LED's, as `gen.emulate.wiring.led.shown_now` has them; None without one.
    closed
        Whether the relay is closed; None without one.
    rules
        Names of the alarm rules.
    """
    relay = "" if closed is None else "closed" if closed else "open"
    return Signals("" if patterns is None else _led(patterns, rules), relay, "seen at the board's pins")


def from_rows(last: Mapping[str, float | None], sensors: str, known: Known) -> Signals:
    """Tell what a board does that has printed a row: LED and relay follow from what stands there.

    Parameters
    ----------
    last
        The row by its columns.
    sensors
        Its sensors' codes, a digit each.
    known
        What the board's coefficient file says; without it some cannot be told.
    """
    if "flags" not in last:
        return Signals(UNKNOWN, UNKNOWN, "these rows say nothing of it" if last else "there is no row yet")
    told = "as the last row has it"
    told += ", where the board has them; what it acts on, and how, --model tells" if known.led is None else ""
    led, relay = _led_of(last, sensors, known), _relay_of(last, known)
    return Signals("" if known.led is False else led, "" if known.relay is False else relay, told)


def _led_of(last: Mapping[str, float | None], sensors: str, known: Known) -> str:
    """As the emitted sketch has it: numbers of alarms before what it acts on, that before a flicker."""
    alarms, acting = _bits(last, "alarms"), _bits(last, "protection")
    numbers = [f"alarm {bit + 1}" for bit in range(alarms.bit_length()) if alarms >> bit & 1]
    disbelieved = ["sensor"] if sensors.strip("0") else []
    if numbers:
        return _led([*numbers, *disbelieved], known.rules)
    if acting and (known.led is None or acting >> len(known.causes)):
        return UNKNOWN
    return _led(["acts"] if acting & known.shows else disbelieved or ["healthy"], known.rules)


def _relay_of(last: Mapping[str, float | None], known: Known) -> str:
    acting = _bits(last, "protection")
    if acting and (known.relay is None or acting >> len(known.causes)):
        return UNKNOWN
    return "open" if acting & known.opens else "closed"


def _led(patterns: Sequence[str], rules: Sequence[str]) -> str:
    """Numbers first, in their order: which of them was the latest changes all the time."""
    return "; ".join(
        _said(pattern, rules) for pattern in sorted(patterns, key=lambda one: (one in _WORDS, _number(one)))
    )


def _number(pattern: str) -> int:
    return 0 if pattern in _WORDS else int(pattern.removeprefix("alarm "))


def _said(pattern: str, rules: Sequence[str]) -> str:
    if pattern in _WORDS:
        return _WORDS[pattern]
    number = _number(pattern)
    name = rules[number - 1] if number <= len(rules) else f"rule {number}"
    return f"{number} blink{'s' if number > 1 else ''}, a pause: alarm {name}"


def _bits(last: Mapping[str, float | None], column: str) -> int:
    return int(last.get(column) or 0) & 0xFFFFFFFF
