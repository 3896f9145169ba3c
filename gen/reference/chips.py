"""What the words of the sensor chips mean, operation for operation as the board takes them (``<name>_sensors.cpp``)."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum

from gen.lowering.platinum import HIGHEST_COUNTS, LOWEST_COUNTS, SEGMENT_BITS
from gen.lowering.sensors import SensorLimits
from gen.lowering.thermistor import FINE_BITS, MOST_SUM
from gen.lowering.thermistor import SEGMENT_BITS as SUM_BITS


class SensorCode(IntEnum):
    """What the checks say of a sample; one decimal digit on the serial line."""

    OK = 0
    OPEN = 1
    ZEROS = 2
    ONES = 3
    RANGE = 4
    JUMP = 5
    STUCK = 6
    EARLY = 7
    UNCONFIRMED = 8
    UNREAD = 9


Decoded = tuple[SensorCode, int]


def decoded(limits: SensorLimits, word: int) -> Decoded:
    """Give what is wrong with a chip's word, and its temperature in counts of 0.25 degC where nothing is.

    Parameters
    ----------
    limits
        Of the channel.
    word
        32 bits. MAX6675: its 16 bits below, and above them the 16 that come when it is clocked on. MAX31855: its 32.
        MAX31856: temperature (24) and fault register (8); all ones if it does not hold its configuration. MAX31865:
        configuration (8) and resistance (16). NTC: a sum of 16 conversions; all ones if there was none.
    """
    return _CHIPS[limits.chip](limits, word)


def _max6675(limits: SensorLimits, word: int) -> Decoded:
    del limits
    if word & 0x8002 or _is_max31855(word & 0xFFFF, word >> 16):
        return SensorCode.ONES, 0
    if word & 0xFFFE == 0:
        return SensorCode.ZEROS, 0
    return (SensorCode.OPEN if word & 0x0004 else SensorCode.OK), word >> 3 & 0xFFF


def _is_max31855(upper: int, lower: int) -> bool:
    """Whether behind a MAX6675's word comes what a MAX31855 sends there: the chip's own temperature, and its faults.

    Behind its word a MAX6675 lets its line float, or holds it: all bits are the same, or those of the word again.
    """
    if lower in (0x0000, 0xFFFF, upper) or lower & 0x0008:
        return False
    own = _signed(lower >> 4, 12)
    return -55 * 16 <= own <= 125 * 16 and bool(upper & 1) == bool(lower & 7)


def _max31855(limits: SensorLimits, word: int) -> Decoded:
    del limits
    if word == 0:
        return SensorCode.ZEROS, 0
    # Reserved bits; where a MAX31855 tells its own temperature nothing comes from a MAX6675.
    if word & 0x0002_0008 or word & 0xFFFF == 0 or bool(word & 0x1_0000) != bool(word & 7):
        return SensorCode.ONES, 0
    return (SensorCode.OPEN if word & 7 else SensorCode.OK), _signed(word >> 18, 14)


def _max31856(limits: SensorLimits, word: int) -> Decoded:
    del limits
    if word == 0:
        return SensorCode.ZEROS, 0
    if word == 0xFFFF_FFFF:
        return SensorCode.ONES, 0
    # Out of range, over- or undervoltage, open; 1/4096 degC in 24 bits, rounded to a count.
    return (SensorCode.OPEN if word & 0xC3 else SensorCode.OK), _signed((word >> 18) + (word >> 17 & 1) & 0x3FFF, 14)


def _max31865(limits: SensorLimits, word: int) -> Decoded:
    if word == 0:
        return SensorCode.ZEROS, 0
    if word >> 16 != limits.configuration:
        return SensorCode.ONES, 0
    code = (word & 0xFFFF) >> 1
    at, within = code >> SEGMENT_BITS, code & (1 << SEGMENT_BITS) - 1
    low, high = limits.platinum[at], limits.platinum[at + 1]
    counts = low + ((high - low) * within >> SEGMENT_BITS)
    outside = not LOWEST_COUNTS <= counts <= HIGHEST_COUNTS
    return (SensorCode.OPEN if word & 1 or outside else SensorCode.OK), counts


def _ntc(limits: SensorLimits, word: int) -> Decoded:
    least, largest = limits.sums
    if word > MOST_SUM:
        return SensorCode.ONES, 0
    if word < least:
        return (SensorCode.OPEN if limits.to_supply else SensorCode.ZEROS), 0
    if word > largest:
        return (SensorCode.ONES if limits.to_supply else SensorCode.OPEN), 0
    at, within = word >> SUM_BITS, word & (1 << SUM_BITS) - 1
    low, high = limits.thermistor[at], limits.thermistor[at + 1]
    fine = low + ((high - low) * within >> SUM_BITS)
    return SensorCode.OK, fine + (1 << FINE_BITS - 1) >> FINE_BITS


def _signed(value: int, bits: int) -> int:
    return value - (1 << bits) if value >> bits - 1 else value


_CHIPS: dict[str, Callable[[SensorLimits, int], Decoded]] = {
    "MAX6675": _max6675,
    "MAX31855": _max31855,
    "MAX31856": _max31856,
    "MAX31865": _max31865,
    "NTC": _ntc,
}
