"""What a coefficient file says of the rows that its board prints."""

from __future__ import annotations

from dataclasses import dataclass, field

from gen.coefficients import Coefficients
from gen.lowering.protection import lower_protection


@dataclass(frozen=True)
class Known:
    """What a coefficient file says of a board's rows; empty where there is none.

    Attributes
    ----------
    rules, causes
        Names of the alarm rules and of what the board acts on, in the order of the bits of the columns ``alarms`` and
        ``protection``.
    channels
        Thermocouples, in the order of the digits of the column ``sensors``.
    bands
        By part: ranges of |PWM| with the lowest and the highest difference, model minus measured, K.
    input
        What the PWM stands for, where it is no motor's.
    shows, opens
        Bits of the column ``protection`` of which the LED tells, and with which the relay opens.
    led, relay
        Whether the board has one; None where nobody knows.
    """

    rules: tuple[str, ...] = ()
    channels: tuple[str, ...] = ()
    bands: dict[str, tuple[tuple[int, int, float, float], ...]] = field(default_factory=dict)
    input: str = ""
    causes: tuple[str, ...] = ()
    shows: int = 0
    opens: int = 0
    led: bool | None = None
    relay: bool | None = None


def known_of(coefficients: Coefficients) -> Known:
    """Gather what a coefficient file says."""
    document, entries = coefficients.document, lower_protection(coefficients)
    bands: dict[str, tuple[tuple[int, int, float, float], ...]] = {}
    for band in document.provenance.error if document.provenance is not None else ():
        bands[band.component] = (*bands.get(band.component, ()), (*band.pwm, *band.model_minus_measured_K))
    wiring = document.wiring
    return Known(
        rules=tuple(rule.name for rule in document.alarms),
        channels=tuple(chip.channel for chip in wiring.thermocouples) if wiring is not None else (),
        bands=bands,
        input=document.input.meaning,
        causes=tuple(entry.label for entry in entries),
        shows=sum(1 << place for place, entry in enumerate(entries) if entry.shows),
        opens=sum(1 << place for place, entry in enumerate(entries) if entry.opens_relay),
        led=None if wiring is None else wiring.led_pin is not None,
        relay=None if wiring is None else wiring.relay_pin is not None,
    )
