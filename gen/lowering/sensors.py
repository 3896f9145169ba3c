"""The limits of the sensor checks as the board holds them: counts of the MAX6675 and samples."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gen.coefficients import Coefficients, Document
from gen.coefficients.wiring import Thermocouple

COUNT_K = 0.25
"""What one count of a MAX6675 is, in K."""
COUNT_mK = 250
HIGHEST_COUNT = 4095
CONVERSION_MS = 220
"""Longest conversion of a MAX6675 (data sheet); it starts anew with every reading."""
NOISE_COUNTS = 4
"""What two samples of a constant temperature may differ by: 1 K, twice the scatter that users of the chip report."""
CONFIRMATIONS = 4
"""Consistent samples in a row before a level is believed: at the start, after a fault and after a jump."""
PLAUSIBLE_SAMPLES = 3
"""Sound samples in a row that could be one part's before they are plausible. Random words, of which an eighth is sound,
make two such above a limit once in 6 000 pairs, three once in four million."""
FASTER = 4
"""By how much a part that fails may outrun its largest physical change."""
_JITTER_MS = 5
"""By what two samples may follow one another sooner than planned: steps of millis() and work between them."""
_STUCK_S = 300.0
_STUCK_K = 3.0
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
        The physical range in counts of 0.25 degC, both inclusive.
    step
        Largest physical change between two readings, in counts, without noise.
    stuck_samples
        Readings of the same count that make a stuck sensor; 0: never.
    stuck_mK
        How far the model must have moved meanwhile, in mK; 0: time alone decides.
    """

    channel: str
    lowest: int
    highest: int
    step: int
    stuck_samples: int
    stuck_mK: int


def reading_samples(sample_time: float) -> int:
    """Samples from one reading of the thermocouples to the next, so that a conversion is finished.

    Parameters
    ----------
    sample_time
        The model's, in s.
    """
    return math.ceil((CONVERSION_MS + _JITTER_MS) / round(sample_time * 1000.0))


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
    interval_s = reading_samples(document.sample_time_s) * document.sample_time_s
    stuck_s = wired.stuck_s if wired.stuck_s is not None else (_STUCK_S if modelled else 0.0)
    stuck_K = wired.stuck_K if wired.stuck_K is not None else (_STUCK_K if modelled else 0.0)
    return SensorLimits(
        channel=wired.channel,
        lowest=_counts(math.ceil(lowest / COUNT_K)),
        highest=_counts(math.floor(highest / COUNT_K)),
        step=max(1, min(HIGHEST_COUNT, math.ceil(wired.max_rate_K_per_s * interval_s / COUNT_K))),
        stuck_samples=max(1, round(stuck_s / interval_s)) if stuck_s else 0,
        stuck_mK=round(stuck_K * 1000.0),
    )


def _counts(value: int) -> int:
    return min(max(value, 0), HIGHEST_COUNT)
