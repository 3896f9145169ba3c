"""What the templates are told about causes and actions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

from gen.coefficients.document import Document
from gen.coefficients.protection import Until
from gen.firmware.protection_text import action_text, cause_text, end_text, protection_text
from gen.lowering.protection import DEVICE, MOST_TIMES, LoweredProtection

_WORDS = {"alarms": "ALARMS", "lost": "LOST", "device": "DEVICE"}
_ENDS: dict[Until, str] = {"itself": "BY_ITSELF", "command": "BY_COMMAND", "cool": "BY_COMMAND_ONCE_COOL"}


class ProtectionEntry(TypedDict):
    """One cause; `text` is all of it in words, `cause`, `action` and `end` its thirds."""

    label: str
    word: str
    mask: int
    least: int
    delay: int
    until: str
    pwm: int
    component: int
    restart_mC: int
    pause: int
    text: str
    cause: str
    action: str
    end: str
    note: str


class ProtectionContext(TypedDict):
    """The table; masks of the entries that only a command ends, that open the relay, of which the LED tells, and that
    derate to what the forecast says can be held. `protection_refuses` and `protection_refuses_relay`: whether a wrong
    program stops the motor and opens the relay, which the sketch sees to beside the table.

    `protection_pauses` is how many entries have a pause, `protection_forgotten` and `protection_times` what ends it
    and how far it grows. `protection_device` are the causes that the sketch finds, in the order of their bits.
    """

    protection: list[ProtectionEntry]
    protections: int
    protection_device: Sequence[str]
    protection_pauses: int
    protection_forgotten: int
    protection_times: int
    protection_lasting: int
    protection_opening: int
    protection_showing: int
    protection_held: int
    protection_refuses: bool
    protection_refuses_relay: bool


def protection_context(document: Document, entries: Sequence[LoweredProtection]) -> ProtectionContext:
    """The table as the templates print it.

    Parameters
    ----------
    document
        The coefficient file.
    entries
        Its lowered table.
    """
    return {
        "protection": [
            {
                "label": entry.label,
                "word": _WORDS[entry.word],
                "mask": entry.mask,
                "least": entry.least,
                "delay": entry.delay,
                "until": _ENDS[entry.until],
                "pwm": entry.pwm,
                "component": entry.component,
                "restart_mC": entry.restart_mC,
                "pause": entry.pause,
                "text": protection_text(document, entry.source),
                "cause": cause_text(document, entry.source),
                "action": action_text(entry.source),
                "end": end_text(document, entry.source),
                "note": entry.source.note or "",
            }
            for entry in entries
        ],
        "protections": len(entries),
        "protection_device": DEVICE,
        "protection_pauses": sum(entry.pause > 0 for entry in entries),
        "protection_forgotten": max((entry.forgotten for entry in entries), default=0),
        "protection_times": MOST_TIMES,
        "protection_lasting": _mask([entry.lasts for entry in entries]),
        "protection_opening": _mask([entry.opens_relay for entry in entries]),
        "protection_showing": _mask([entry.shows for entry in entries]),
        "protection_held": _mask([entry.holds for entry in entries]),
        "protection_refuses": any(entry.source.stops for entry in entries if entry.source.cause == "flash_check"),
        "protection_refuses_relay": any(entry.opens_relay for entry in entries if entry.source.cause == "flash_check"),
    }


def _mask(chosen: Sequence[bool]) -> int:
    return sum(1 << number for number, choice in enumerate(chosen) if choice)
