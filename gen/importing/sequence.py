"""The order of times: what repeats, what goes back, where the clock begins anew, where nothing was recorded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.errors import InputError
from gen.importing.local import goes_back

_SOON = 10
"""Rows within which a time that went back is ahead again, if a row was only late."""
_LATE_S = 60.0
_MOST_RESETS = 1000
_WRAP_STEPS = 3.0
"""Usual intervals within which a counter that ran over was before its end, and is after 0."""
_STEADY = 0.01
GAP_STEPS = 10.0
GAP_S = 60.0


@dataclass(frozen=True)
class Order:
    """Rows of one table in order.

    Parameters
    ----------
    kept
        Rows that stay, ascending, shape (n,).
    time_s
        Of them, s, shape (n,); within a piece strictly increasing.
    resets
        Positions in `kept` at which the clock begins anew, ascending.
    repeated, late
        Rows left out, because the time is that of the row before, or lies before it.
    jumped
        Rows left out, because their time alone lies far ahead.
    wraps
        Rows at which the clock went round, and what it counts.
    """

    kept: IntArray
    time_s: FloatArray
    resets: IntArray
    repeated: IntArray
    late: IntArray
    jumped: IntArray
    wraps: tuple[tuple[int, str], ...] = ()


@dataclass(frozen=True)
class Round:
    """What a clock begins anew after.

    Parameters
    ----------
    name
        What it counts.
    period_s
        How long a round is, s.
    begin_s
        Where it begins, s.
    running
        Whether a clock that begins where a round does is a test of that length instead: nothing but its beginning would
        tell the two apart.
    """

    name: str
    period_s: float
    begin_s: float = 0.0
    running: bool = False


@dataclass(frozen=True)
class Ticks:
    """What is known of a clock beside its times.

    Parameters
    ----------
    rounds
        After which it may begin anew.
    local
        Whether times are those of a place, without their distance from UTC.
    """

    rounds: tuple[Round, ...] = ()
    local: bool = False


def unwrapped(time_s: FloatArray, rounds: Sequence[Round]) -> tuple[FloatArray, tuple[tuple[int, str], ...]]:
    """Times of a clock that went round, made to go on; and the rows at which it did.

    A second test in one file begins near 0, too, and may follow on one that lasted as long as the counter: so the
    interval across the end has to be one that the counter has elsewhere.

    Parameters
    ----------
    time_s
        Finite, s, shape (N,).
    rounds
        That it may make.
    """
    steps = np.diff(time_s)
    rising = steps[steps > 0]
    if not rising.size:
        return time_s, ()
    usual = float(np.median(rising))
    least, most = np.percentile(rising, (1, 99))
    near, slack = _WRAP_STEPS * usual, most - least + _STEADY * usual
    possible = [turn for turn in rounds if not (turn.running and time_s[0] - turn.begin_s < near)]
    made, found = time_s.copy(), []
    for row in np.flatnonzero(steps < 0):
        for turn in possible:
            end, ahead = turn.begin_s + turn.period_s, float(steps[row]) + turn.period_s
            at_its_end = end - near < time_s[row] < end and 0 <= time_s[row + 1] - turn.begin_s < near
            if at_its_end and abs(ahead - max(1, round(ahead / usual)) * usual) <= slack:  # rows may be missing
                made[row + 1 :] += turn.period_s
                found.append((int(row) + 1, turn.name))
                break
    return made, tuple(found)


def order(time_s: FloatArray, rows: IntArray, repeats: str, ticks: Ticks = Ticks()) -> Order:
    """Put rows in order; nothing is sorted, what does not fit is left out and told.

    Parameters
    ----------
    time_s
        Finite, s, shape (N,).
    rows
        Of the table, for each time, shape (N,).
    repeats
        Of rows with one time: "first" (also for their "mean"), "last", or "spread" evenly until the next time.
    ticks
        What is known of the clock.
    """
    ahead = _spikes(time_s)
    jumped, time_s, rows = rows[ahead], time_s[~ahead], rows[~ahead]
    time_s, wraps = unwrapped(time_s, ticks.rounds)
    resets = _resets(time_s, ticks.local)
    piece = np.zeros(time_s.size, dtype=np.int64)
    piece[resets] = 1
    piece = np.cumsum(piece)
    time = _spread(time_s, piece) if repeats == "spread" else time_s
    highest = _highest_before(time, piece)
    late = time < highest
    good = ~late
    repeated = np.zeros(time.size, dtype=bool)
    position = np.flatnonzero(good)
    same = (np.diff(time[position]) == 0) & (np.diff(piece[position]) == 0)
    if repeats == "last":
        repeated[position[:-1][same]] = True
    else:
        repeated[position[1:][same]] = True
    kept = np.flatnonzero(good & ~repeated)
    begins = np.flatnonzero(np.diff(piece[kept], prepend=piece[kept[0]] if kept.size else 0) > 0)
    over = tuple((int(rows[i]), name) for i, name in wraps)
    return Order(rows[kept], time[kept], begins, rows[repeated], rows[late], jumped, over)


def _spikes(time_s: FloatArray) -> BoolArray:
    """Rows whose time alone lies far ahead: the next one goes on from the one before."""
    found = np.zeros(time_s.size, dtype=bool)
    if time_s.size > 2:
        before, here, after = time_s[:-2], time_s[1:-1], time_s[2:]
        found[1:-1] = (here - before > GAP_S) & (after < here) & (after >= before)
    return found


def _resets(time_s: FloatArray, local: bool) -> list[int]:
    """Rows at which time goes back and stays there: it begins anew."""
    found: list[int] = []
    begin, peaks = 0, np.maximum.accumulate(time_s)
    for row in np.flatnonzero(np.diff(time_s) < 0) + 1:
        peak = float(peaks[row - 1 - begin])
        summer_ends = local and goes_back(time_s, int(row), 1.0)
        if time_s[row] >= peak or (not summer_ends and _late(time_s, int(row), peak)):
            continue
        if len(found) == _MOST_RESETS:
            raise InputError(
                f"time goes back more than {_MOST_RESETS} times; expected a column that rises, or --sort, which puts "
                "rows in its order"
            )
        found.append(int(row))
        begin, peaks = int(row), np.maximum.accumulate(time_s[row:])
    return found


def _late(time_s: FloatArray, row: int, peak: float) -> bool:
    """Whether a row that goes back is only late: the old time is passed soon, or it was set back by little."""
    if (time_s[row : row + _SOON + 1] > peak).any():
        return True
    back = peak - time_s[row]
    if row + _SOON >= time_s.size:
        return bool(back < _LATE_S / 10)
    return bool(back < _LATE_S and time_s[row] > 0.5 * peak and _overtakes(time_s, row, peak))


def _overtakes(time_s: FloatArray, row: int, highest: float) -> bool:
    """Whether a clock that was set back a little passes its old time without falling back again."""
    return bool((time_s[row : row + 1000] > highest).any())


def _highest_before(time_s: FloatArray, piece: IntArray) -> FloatArray:
    """The largest time before each row within its piece; minus infinity for the first."""
    made = np.full(time_s.size, -np.inf)
    for number in range(int(piece[-1]) + 1 if piece.size else 0):
        rows = np.flatnonzero(piece == number)
        made[rows[1:]] = np.maximum.accumulate(time_s[rows])[:-1]
    return made


def _spread(time_s: FloatArray, piece: IntArray) -> FloatArray:
    """Rows of one time shared out evenly until the next time; the last ones by the usual interval."""
    begins = np.flatnonzero(np.concatenate([[True], (np.diff(time_s) != 0) | (np.diff(piece) != 0)]))
    lengths = np.diff(np.append(begins, time_s.size))
    ahead = np.append(np.diff(time_s[begins]), np.nan)
    ahead[np.append(np.diff(piece[begins]) != 0, True)] = np.nan
    rising = ahead[ahead > 0]
    usual = float(np.median(rising)) if rising.size else 1.0
    ahead = np.where(np.isfinite(ahead) & (ahead > 0), np.minimum(ahead, 1.5 * usual), usual)
    within = np.arange(time_s.size) - np.repeat(begins, lengths)
    return np.asarray(time_s + within * np.repeat(ahead / lengths, lengths))


def gap_length(time_s: FloatArray) -> float:
    """From which interval on, in s, nothing was recorded: ten usual intervals, and a minute at least."""
    steps = np.diff(time_s)
    steps = steps[steps > 0]
    return max(GAP_STEPS * float(np.median(steps)), GAP_S) if steps.size else GAP_S


def gaps(time_s: FloatArray, resets: IntArray, longest_s: float) -> IntArray:
    """Positions that follow a longer interval, those at which the clock begins anew left out."""
    found = np.flatnonzero(np.diff(time_s) > longest_s) + 1
    return np.setdiff1d(found, resets)
