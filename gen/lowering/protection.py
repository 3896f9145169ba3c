"""Causes and actions as the board has them: masks, samples and thousandths of a degree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from gen.coefficients import Coefficients
from gen.coefficients.document import Document
from gen.coefficients.protecting import cooling_part, protections, watched_channels
from gen.coefficients.protection import Protection, Until
from gen.lowering.samples import samples

FORGOTTEN_S: Final = 600.0
"""Of an entry with a pause: after each such time without it one of its times is forgotten."""
MOST_TIMES: Final = 6
"""More are not counted: the longest pause is the first one doubled five times."""

Word = Literal["alarms", "lost", "device"]
"""The word of a sample that says whether a cause is there: latched rules, sensors not believed, the sketch's own."""

DEVICE: Final = (
    "stall",
    "overspeed",
    "turning_without_command",
    "late_loop",
    "command_timeout",
    "flash_check",
    "ram_check",
    "eeprom_check",
    "limit_near",
    "not_commissioned",
    "sensor_unseen",
    "cpu_check",
    "clock_check",
    "supply_low",
)
"""Causes that the sketch finds by itself; bit b of the word `device` is the b-th."""


@dataclass(frozen=True)
class LoweredProtection:
    """One cause and its action.

    Attributes
    ----------
    label
        What the serial line calls it.
    word, mask, least
        The cause is there while at least `least` of the bits of `mask` are set in that word of the sample.
    delay
        Samples that it must have held before the action begins.
    pwm
        The largest |PWM| while it acts, in counts: the full scale where it limits nothing, or where the forecast says
        to what; 0 of one that stops.
    component, restart_mC
        Of one that waits for cooling: the part's index and the temperature below which it has cooled down, in
        thousandths of a degree Celsius; else 0.
    pause, forgotten
        In samples: how long it has to act, at its second time, before a command may end it, twice as long each
        further time; and after how long without it one time is forgotten. 0 of one without a pause.
    source
        The entry itself.
    """

    label: str
    word: Word
    mask: int
    least: int
    delay: int
    pwm: int
    component: int
    restart_mC: int
    pause: int
    forgotten: int
    source: Protection

    @property
    def until(self) -> Until:
        """How it ends."""
        return self.source.until

    @property
    def opens_relay(self) -> bool:
        """Whether the relay opens while it acts."""
        return self.source.action == "open_relay"

    @property
    def holds(self) -> bool:
        """Whether the forecast says to what PWM it derates."""
        return self.source.holds

    @property
    def shows(self) -> bool:
        """Whether the LED tells of it."""
        return self.source.action != "log"

    @property
    def lasts(self) -> bool:
        """Whether it outlives a reset of the board, since only a command ends it."""
        return self.until != "itself"


def lower_protection(coefficients: Coefficients) -> tuple[LoweredProtection, ...]:
    """Lower the table of a coefficient file, defaults included, in its order.

    Parameters
    ----------
    coefficients
        A checked coefficient file.
    """
    document = coefficients.document
    return tuple(_lowered(document, entry) for entry in protections(document))


def _lowered(document: Document, entry: Protection) -> LoweredProtection:
    word, mask, least = _condition(document, entry)
    part = cooling_part(document, entry)
    pwm = entry.derate_pwm if isinstance(entry.derate_pwm, int) else document.input.full_scale
    return LoweredProtection(
        label=entry.label,
        word=word,
        mask=mask,
        least=least,
        delay=samples(entry.delay_s, document.sample_time_s),
        pwm=0 if entry.stops else pwm,
        component=0 if part is None else document.component_names.index(part),
        restart_mC=round(entry.restart_below_degC * 1000.0) if entry.restart_below_degC is not None else 0,
        pause=samples(entry.pause_s, document.sample_time_s),
        forgotten=samples(FORGOTTEN_S, document.sample_time_s) if entry.pause_s else 0,
        source=entry,
    )


def _condition(document: Document, entry: Protection) -> tuple[Word, int, int]:
    """The word, the bits in it, and how many of them make the cause."""
    channels = [chip.channel for chip in document.wiring.thermocouples] if document.wiring is not None else []
    if entry.cause == "alarm":
        return "alarms", 1 << [rule.name for rule in document.alarms].index(str(entry.rule)), 1
    if entry.cause == "sensor_lost":
        lost = [entry.channel] if entry.channel is not None else watched_channels(document)
        return "lost", sum(1 << channels.index(name) for name in lost), 1
    if entry.cause == "ambient_lost":
        return "lost", 1 << channels.index("ambient"), 1
    if entry.cause == "too_few_sensors":
        parts = [number for number, name in enumerate(channels) if name != "ambient"]
        assert entry.least is not None
        return "lost", sum(1 << number for number in parts), len(parts) - entry.least + 1
    return "device", 1 << DEVICE.index(entry.cause), 1
