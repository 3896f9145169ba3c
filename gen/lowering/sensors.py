"""The limits of the sensor checks as the board holds them: counts of a quarter of a degree, and samples."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from gen.coefficients import Coefficients, Document
from gen.coefficients.wiring import Thermocouple
from gen.lowering.platinum import counts_at
from gen.lowering.thermistor import fine_at, sound_sums

COUNT_K = 0.25
"""What one count is, in K: a MAX6675's and a MAX31855's own; finer words are rounded to it."""
COUNT_mK = 250
LONGEST_SAMPLES = 9000
"""Samples after which every count of any chip is within reach of every other."""
CONVERSION_MS = {"MAX6675": 220, "MAX31855": 100, "MAX31856": 185, "MAX31865": 66, "NTC": 140}
"""Longest conversion by chip (data sheets, at 50 Hz); a MAX6675's starts anew with every reading. An NTC shares the
Mega's converter, whose round over all inputs that a board can have lasts so long."""
NOISE_COUNTS = 4
"""What two samples of a constant temperature may differ by: 1 K, twice the scatter that users of the chip report."""
CONFIRMATIONS = 4
"""Consistent samples in a row before a level is believed: at the start, after a fault and after a jump."""
PLAUSIBLE_SAMPLES = 3
"""Sound samples in a row that could be one part's before they are plausible. Random words, of which an eighth is sound,
make two such above a limit once in 6 000 pairs, three once in four million."""
FASTER = 4
"""By how much a part that fails may outrun its largest physical change."""
MOST_RISING_COUNTS = 262
"""More than this is no more told of a rise over two readings: 65.5 K, which 16 bits hold in thousandths."""
_JITTER_MS = 5
"""By what two samples may follow one another sooner than planned: steps of millis() and work between them."""
_LARGEST_STEP = 4095
_OTHER_WIRES, _THREE_WIRES = 0xC1, 0xD1
"""The first register of a MAX31865: bias on, converting again and again, 50 Hz filtered."""
STUCK_S = 30.0
"""A sound thermocouple, even one without noise, may give one count for minutes, but not while the model moves so far:
by 1.2 K at most in 160 h of motors of independent physics (benchmarks/frozen_counts.py)."""
STUCK_K = 3.0
_HOTTER_K = 100.0
_AMBIENT_MARGIN_K = 10.0


@dataclass(frozen=True)
class SensorLimits:
    """What one channel's checks compare with.

    Attributes
    ----------
    channel
        A component's name, "ambient", or an extra column.
    lowest, highest
        The believed range in counts of 0.25 degC, both inclusive.
    step
        Largest physical change between two readings, in counts, without noise.
    stuck_samples
        Readings of the same count that make a stuck sensor; 0: never.
    stuck_mK
        How far the model must have moved meanwhile, in mK; 0: time alone decides.
    chip
        Whose words they are.
    platinum
        Of a MAX31865: counts at ratios of its resistors, see :func:`gen.lowering.platinum.counts_at`.
    configuration
        Of a MAX31865: what its first register holds when it works.
    thermistor
        Of an NTC: 64ths of a degree at sums of conversions, see :func:`gen.lowering.thermistor.fine_at`.
    sums
        Of an NTC: the least and the largest sound sum.
    to_supply
        Of an NTC: whether a broken wire shows at ground.
    """

    channel: str
    lowest: int
    highest: int
    step: int
    stuck_samples: int
    stuck_mK: int
    chip: str = "MAX6675"
    platinum: tuple[int, ...] = ()
    configuration: int = 0
    thermistor: tuple[int, ...] = ()
    sums: tuple[int, int] = (0, 0)
    to_supply: bool = False


def conversion_ms(wired: Sequence[Thermocouple]) -> int:
    """Give the longest conversion of the chips that are wired, ms: all are read together."""
    return max((CONVERSION_MS[item.chip] for item in wired), default=CONVERSION_MS["MAX6675"])


def reading_samples(sample_time: float, longest_ms: int = CONVERSION_MS["MAX6675"]) -> int:
    """Samples from one reading of the thermocouples to the next, so that a conversion is finished.

    Parameters
    ----------
    sample_time
        The model's, in s.
    longest_ms
        What a conversion takes at most.
    """
    return math.ceil((longest_ms + _JITTER_MS) / round(sample_time * 1000.0))


def sensor_limits(coefficients: Coefficients) -> tuple[SensorLimits, ...]:
    """Limits of every thermocouple, in the order of the coefficient file."""
    document = coefficients.document
    wired = document.wiring.thermocouples if document.wiring else ()
    return tuple(_limits(document, thermocouple) for thermocouple in wired)


def _limits(document: Document, wired: Thermocouple) -> SensorLimits:
    ambient = wired.channel == "ambient"
    modelled = not ambient and wired.channel not in document.thermocouple_columns
    domain = document.domain.ambient_degC if ambient else document.domain.temperature_degC
    lowest = wired.min_degC if wired.min_degC is not None else domain[0] - (_AMBIENT_MARGIN_K if ambient else 0.0)
    above = _AMBIENT_MARGIN_K if ambient else _HOTTER_K
    highest = wired.max_degC if wired.max_degC is not None else domain[1] + above
    everything = document.wiring.thermocouples if document.wiring else ()
    interval_s = reading_samples(document.sample_time_s, conversion_ms(everything)) * document.sample_time_s
    ends = wired.range_degC
    thermistor = wired.thermistor if wired.chip == "NTC" else None
    stuck_s = wired.stuck_s if wired.stuck_s is not None else (STUCK_S if modelled else 0.0)
    stuck_K = wired.stuck_K if wired.stuck_K is not None else (STUCK_K if modelled else 0.0)
    return SensorLimits(
        channel=wired.channel,
        lowest=math.ceil(min(max(lowest, ends[0]), ends[1]) / COUNT_K),
        highest=math.floor(min(max(highest, ends[0]), ends[1]) / COUNT_K),
        step=max(1, min(_LARGEST_STEP, math.ceil(wired.max_rate_K_per_s * interval_s / COUNT_K))),
        stuck_samples=max(1, round(stuck_s / interval_s)) if stuck_s else 0,
        stuck_mK=round(stuck_K * 1000.0),
        chip=wired.chip,
        platinum=counts_at(*wired.resistor_ohm) if wired.chip == "MAX31865" else (),
        configuration=(_THREE_WIRES if wired.wires == 3 else _OTHER_WIRES) if wired.chip == "MAX31865" else 0,
        thermistor=fine_at(thermistor) if thermistor is not None else (),
        sums=sound_sums(thermistor) if thermistor is not None else (0, 0),
        to_supply=thermistor is not None and thermistor.to_supply,
    )
