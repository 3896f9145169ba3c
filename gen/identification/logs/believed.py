"""Which readings a part can have shown: the board's check of jumps, off-line, with what comes after known as well.

A thermocouple beside a motor that runs may be wild for minutes: readings missing, many of the others tens of kelvin
off. A part's temperature changes by no more than so much a second; so of all readings the longest sequence is believed
in which each is within reach of the one before. Wild readings scatter and agree with few others; sound ones agree with
all. (The board, which does not know what follows, asks for four readings that agree before it believes a level.)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from scipy.ndimage import uniform_filter1d

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.identification.logs.alone import standing_alone
from gen.runs import Run

RATE_K_PER_S = 5.0
"""As on the board, where the file does not say otherwise (a test holds both together)."""
NOISE_K = 1.0
"""What two readings of one temperature may differ by, at least; as on the board."""
SCATTER = 9.0
"""Or as many standard deviations of a reading, as the calm quarter of the differences shows it: no two of ten million
normal ones differ by as much, and what is wild is further off."""
QUARTER = 0.45
"""Lower quartile of the magnitude of differences of normal readings, in standard deviations of a reading."""
MOST_SCATTER_K = 3.0
"""Standard deviation of a reading beyond which nothing is believed: no sensor of the public logs of motors, cells
and heaters scatters by more than 0.3 K, but for one beside a large motor that disturbed it: that by 5 to 16 K."""
SECOND_QUARTER = 0.78
"""Lower quartile of the magnitude of second differences of normal readings, in standard deviations of a reading."""
WINDOW = 256
"""Readings before one that may be the one before in the sequence, of those that are not out of any reach."""

AROUND, LEAST_SHARE = 33, 0.3
"""Of so many readings around one at least this share has to be in the sequence, or it is not believed either."""
LEAST_OF_ALL = 0.05
"""And of all readings at least this share."""


def believed_run(run: Run, rates: Mapping[str, float] = MappingProxyType({})) -> Run:
    """Take out what the parts cannot have shown.

    Parameters
    ----------
    run
        As it was read.
    rates
        By part, what its temperature cannot change faster than, K/s; those not named have the board's own limit.

    Returns
    -------
    Run
        The same, readings that are not believed missing, with a sentence in `doubted` for each column that lost any.
    """
    temps, said = {}, []
    for name, values in run.temps.items():
        rate = rates.get(name, RATE_K_PER_S)
        kept = believed(run.time_s, values, rate)
        lost = int(np.count_nonzero(np.isfinite(values) & ~kept))
        temps[name] = np.where(kept, values, np.nan) if lost else values
        known = int(np.count_nonzero(np.isfinite(values)))
        alone = standing_alone(temps[name], run.pwm)
        if rate <= RATE_K_PER_S and alone.any():  # a file that says that a part is quicker means it
            said.append(
                f"{name}_degC: {np.count_nonzero(alone)} of {known} readings stand alone while PWM was held, and are "
                f"not believed{_off(run.time_s, temps[name], kept & ~alone)}"
            )
            temps[name] = np.where(alone, np.nan, temps[name])
        scatter = scatter_K(values[np.isfinite(values)])
        if lost == known and scatter > MOST_SCATTER_K:
            said.append(
                f"{name}_degC: none of {known} readings is believed: they scatter by {scatter:.0f} K (standard "
                "deviation of a reading about its neighbours), which is no temperature's"
            )
        elif lost:
            said.append(
                f"{name}_degC: {lost} of {known} readings are not believed{_off(run.time_s, values, kept)}: "
                f"a part does not change faster than {rate:g} K/s"
            )
    return replace(run, temps=temps, doubted=tuple(said)) if said else run


def believed(time: FloatArray, values: FloatArray, rate: float = RATE_K_PER_S) -> BoolArray:
    """Say which readings are believed, shape (N,); missing ones are not.

    Parameters
    ----------
    time
        Shape (N,), s, increasing.
    values
        Shape (N,), degC; NaN where missing.
    rate
        What a part cannot change faster than, K/s.
    """
    known = np.flatnonzero(np.isfinite(values))
    kept = np.isfinite(values)
    at, value = time[known], values[known]
    step = np.abs(np.diff(value))
    if known.size < 3:
        return kept
    noise = min(max(NOISE_K, SCATTER * float(np.quantile(step, 0.25)) / QUARTER), SCATTER * MOST_SCATTER_K)
    jumps = np.flatnonzero(step > noise + rate * np.diff(at))
    own = np.ones(known.size)
    for first, last in _about(jumps, known.size):
        own[first:last] = 0.0
        own[first + _longest(at[first:last], value[first:last], noise, rate)] = 1.0
    # Where next to nothing agrees the sequence goes through what is wild by chance.
    kept[known] = (own > 0.0) & (uniform_filter1d(own, AROUND, mode="nearest") >= LEAST_SHARE)
    # Where all is wild the longest sequence is as wild as its limit lets it be, or next to nothing.
    sound = np.count_nonzero(kept) >= LEAST_OF_ALL * known.size and scatter_K(values[kept]) <= MOST_SCATTER_K
    return kept if sound else np.zeros_like(kept)


def scatter_K(values: FloatArray) -> float:
    """Give the standard deviation of a reading about its neighbours, K, a ramp apart; that of the calmer readings.

    Parameters
    ----------
    values
        Shape (N,), degC, none missing.
    """
    if values.size < 3:
        return 0.0
    return float(np.quantile(np.abs(np.diff(values, 2)), 0.25)) / SECOND_QUARTER


def _about(jumps: IntArray, count: int) -> list[tuple[int, int]]:
    """Stretches about all jumps, with enough on both sides for what is sound to outweigh what is wild."""
    if not jumps.size:
        return []
    parted = np.flatnonzero(np.diff(jumps) > 4 * WINDOW)
    firsts, lasts = jumps[np.append(0, parted + 1)], jumps[np.append(parted, jumps.size - 1)]
    return [
        (max(0, first - 2 * WINDOW), min(count, last + 2 * WINDOW))
        for first, last in zip(firsts.tolist(), lasts.tolist(), strict=True)
    ]


def _longest(time: FloatArray, value: FloatArray, noise: float, rate: float) -> IntArray:
    """Places of the longest sequence in which each reading is within reach of the one before."""
    count = value.size
    length, before = np.ones(count, dtype=np.int64), np.full(count, -1, dtype=np.int64)
    best = -1  # the longest sequence that ends before the window
    for k in range(1, count):
        first = max(0, k - WINDOW)
        if first and (best < 0 or length[first - 1] > length[best]):
            best = first - 1
        reach = noise + rate * (time[k] - time[first:k])
        own = np.where(np.abs(value[k] - value[first:k]) <= reach, length[first:k], 0)
        place = own.size - 1 - int(np.argmax(own[::-1]))  # of equals the latest
        if own[place]:
            length[k], before[k] = own[place] + 1, first + place
        longer = best >= 0 and length[best] >= length[k]
        if longer and abs(value[k] - value[best]) <= noise + rate * (time[k] - time[best]):
            length[k], before[k] = length[best] + 1, best
    places = [int(np.argmax(length))]
    while before[places[-1]] >= 0:
        places.append(int(before[places[-1]]))
    return np.array(places[::-1], dtype=np.int64)


def _off(time: FloatArray, values: FloatArray, kept: BoolArray) -> str:
    """How far what is not believed is from what is, in words; nothing where none is."""
    if not kept.any():
        return ""
    between = np.interp(time, time[kept], values[kept])
    worst = float(np.max(np.abs(values - between)[np.isfinite(values) & ~kept]))
    return f", up to {worst:.0f} K off what lies around them"
