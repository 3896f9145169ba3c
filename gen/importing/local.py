"""Local times: where they go back or ahead by hours, how that is told, and what instants they are in a time zone."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from zoneinfo import ZoneInfo

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.errors import InputError

_HOUR_S = 3600.0
_NS = 10**9
_NOT = np.iinfo(np.int64).min
_MOST_YEARS = 200
_SET_BACK = {
    12.0: "the clock goes back by 12 hours, as hours from 1 to 12 do; expected times that tell AM from PM",
    24.0: "the clock goes back by a day, as where the date does not go on at midnight; expected --time with a column "
    "of times of day, if it has one",
}
"""By hours: what --split would make of it begins at another time than it says."""


def goes_back(time_s: FloatArray, row: int, hours: float) -> bool:
    """Whether a row's time is some hours before what its usual interval makes of the row before.

    Parameters
    ----------
    time_s
        Finite, s, shape (N,).
    row
        From 1 on.
    hours
        How many.
    """
    usual = _usual(time_s)
    return _near(float(time_s[row] - time_s[row - 1]) + hours * _HOUR_S, usual)


def goes_ahead_an_hour(time_s: FloatArray) -> IntArray:
    """Rows whose time is an hour beyond what the usual interval makes of the row before.

    Parameters
    ----------
    time_s
        Finite, s, shape (N,).
    """
    steps, usual = np.diff(time_s), _usual(time_s)
    return np.flatnonzero([_near(float(step) - _HOUR_S, usual) for step in steps]) + 1


def _near(step: float, usual: float) -> bool:
    return usual < _HOUR_S / 2 and 0.5 * usual <= step <= 1.5 * usual


def _usual(time_s: FloatArray) -> float:
    steps = np.diff(time_s)
    return float(np.median(steps[steps > 0])) if (steps > 0).any() else _HOUR_S


def is_zone(name: str) -> bool:
    """Whether a time zone has that name, such as Europe/Berlin."""
    try:
        ZoneInfo(name)
    except (KeyError, ValueError, OSError):
        return False
    return True


def in_utc(local_ns: IntArray, zone: ZoneInfo) -> IntArray:
    """Instants of local times, ns since 1970 in UTC.

    Of an hour that is there twice, rows are of the first until they go back. A time that the zone leaves out counts
    from the hour before.

    Parameters
    ----------
    local_ns
        As if they were in UTC; the smallest integer where missing, shape (N,).
    zone
        The zone.

    Raises
    ------
    InputError
        Without a file name: the times are of more than 200 years.
    """
    good = np.flatnonzero(local_ns != _NOT)
    made = local_ns.copy()
    if not good.size:
        return made
    local = local_ns[good]
    begins, offsets = _offsets(zone, int(local.min() // _NS), int(local.max() // _NS))
    candidates = np.stack([local - offset * _NS for offset in sorted(set(offsets), reverse=True)])  # earliest first
    held = np.array(offsets)[np.maximum(np.searchsorted(begins, candidates // _NS, side="right") - 1, 0)]
    fits = local - held * _NS == candidates
    backward = local.size > 1 and np.median(np.diff(local)) < 0
    one = fits.sum(axis=0) == 1
    chosen = candidates[np.argmax(fits, axis=0), np.arange(local.size)]
    chosen[~fits.any(axis=0)] = candidates[-1, ~fits.any(axis=0)]
    before = _NOT
    for i in range(local.size - 1, -1, -1) if backward else range(local.size):
        if not one[i] and fits[:, i].any():
            later = candidates[fits[:, i], i]
            chosen[i] = next((value for value in later if value >= before), later[0])
        before = chosen[i]
    made[good] = chosen
    return made


def _offsets(zone: ZoneInfo, first_s: int, last_s: int) -> tuple[list[int], list[int]]:
    """From which second on, in UTC, which offset holds, in s."""
    if last_s - first_s > _MOST_YEARS * 366 * 86_400:
        raise InputError(f"holds times of more than {_MOST_YEARS} years; expected a log")

    def offset(second: int) -> int:
        found = datetime.fromtimestamp(second, UTC).astimezone(zone).utcoffset()
        return int(found.total_seconds()) if found is not None else 0

    begin, end = first_s - 2 * 86_400, last_s + 2 * 86_400
    begins, offsets = [begin], [offset(begin)]
    for day in range(begin, end, 86_400):
        new = offset(day + 86_400)
        if new != offsets[-1]:
            begins.append(_change(offset, day, day + 86_400))
            offsets.append(new)
    return begins, offsets


def _change(offset: Callable[[int], int], before: int, after: int) -> int:
    """The first minute between two instants at which the later one's offset holds."""
    new = offset(after)
    while after - before > 60:
        middle = (before + after) // 120 * 60
        before, after = (before, middle) if offset(middle) == new else (middle, after)
    return after


_RING_STEPS = 3.0
"""Usual intervals by which the last row of a ring comes before its first one."""


def told_reset(time_s: FloatArray, row: int, *, local: bool, single: bool) -> str:
    """Say why a clock that begins anew at a row may do so, and what helps."""
    if local and single and goes_back(time_s, row, 1.0):
        return (
            "the clock goes back by an hour, as where summer time ends; expected --zone with the name of its time "
            "zone, such as Europe/Berlin, which lets it go on (dates with times only), or --split, which makes a "
            "run of each stretch"
        )
    for hours, said in _SET_BACK.items():
        if local and goes_back(time_s, row, hours):
            return f"{said}, or --split, which makes a run of each stretch and leaves when the later ones began wrong"
    begun = f"{time_s[row]:g} s after {time_s[row - 1]:g} s"
    if single and 0.0 < time_s[0] - time_s[-1] <= _RING_STEPS * float(np.median(np.diff(time_s))):
        return (
            f"rows go on before the first one: {begun}, as in a ring that was read from its middle; expected --sort, "
            "which puts rows in the order of their times, or --split, which makes a run of each stretch"
        )
    return f"the clock begins anew: {begun}; expected --split, which makes a run of each stretch"
