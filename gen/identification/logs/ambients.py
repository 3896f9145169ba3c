"""The ambient of each run: measured, noted or given; else what the runs themselves tell of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.errors import InputError
from gen.identification.logs.sources import Source
from gen.runs import Run, noted_ambient

ALIKE_K = 3.0
"""Components that begin no further apart than this begin cold."""
ASTRAY = 3.0
"""A first reading is astray by more than this many times what the next two differ by, and `ALIKE_K`."""
SAME_ROOM_K = 4.0
"""Rooms of several runs differ by no more than this: what begins warmer does not begin cold."""
UNKNOWN_K = 5.0
"""Standard deviation of a room that nothing says about where the coldest run begins, K."""
COLD_K = 0.5
"""The same where several runs begin at one level, as what begins cold does: their sensors may all be off by as much."""
AT_ONE_LEVEL_K = 1.5
"""Runs begin at one level that begin no further above the coldest of them: rooms differ by that from day to day."""
COLD_READINGS = 3
"""So many first readings of one level, of one run or several, say that these began cold."""
WARMEST_ROOM = 40.0
"""degC: what begins warmer and cools from there did not begin in its room."""
HOTTEST_ROOM = 70.0
"""degC: what begins warmer did not either, wherever it goes. (Who tries a motor in an oven gives --ambient.)"""
OTHER_ROOM_K = 1.0
"""Ambients that are noted for whole runs and differ by more than this are no one room: one drifts by as much itself."""
ROOM, ROOM_UNSURE_K = 22.0, 8.0
"""A room of which no more is known than that people work in it, degC, and its standard deviation, K."""


@dataclass(frozen=True, eq=False)
class Ambients:
    """The ambient of each run.

    Attributes
    ----------
    levels
        By run: at every row, shape (N,), or one number, degC.
    unsure_K
        Standard deviation of what all that nothing says are off by together, K; 0 where one of them is said.
    cold
        By run: whether nothing says its ambient, and others that begin at the same level tell that it began there.
    own
        Whether every run says its ambient, and they differ so much that no one stands for all.
    """

    levels: list[FloatArray | float]
    unsure_K: float
    cold: list[bool]
    own: bool = False

    def fixed(self, given: float | None) -> float | None:
        """Give the ambient of a run that does not say it, degC: the median of those that were not measured.

        None where every run has its own, and so has to be told it.

        Parameters
        ----------
        given
            As a user gave it, or None.
        """
        levels = [level for level in self.levels if isinstance(level, float)]
        if self.own:
            return None
        return float(np.median(levels)) if levels else given


def ambients_of(
    sources: Sequence[Source], fixed: float | None, warnings: list[str], *, estimated: bool = False
) -> Ambients:
    """Give the ambient of each run, and what all of them may be off by together.

    Where nothing says it a run that begins like the coldest ones begins in its room; others are taken to stand in the
    room of those. Where all begin warmer than rooms are, and cool from there, or hotter than any room, it is a usual
    room.

    Parameters
    ----------
    sources
        The runs.
    fixed
        The ambient in degC where it was not measured, or None.
    warnings
        Added to.
    estimated
        Whether the model is to find out how far off a guess is: then a guess need not come from a cold start.

    Raises
    ------
    InputError
        When what is noted is no number; when nothing says it, and no run begins cold.
    """
    said = [_said_ambient(source, fixed, warnings) for source in sources]
    levels = [float(np.mean(level)) for level in said if level is not None]
    starts = [_first_readings(source.run) for source in sources]
    if not (estimated or levels or any(map(_alike, starts))):
        raise InputError(
            "there is no ambient_degC, and the components do not start alike; give the ambient with --ambient",
            file=sources[0].path,
        )
    known = [min(firsts) for firsts, level in zip(starts, said, strict=True) if firsts and (level is None or levels)]
    usual = float(np.median(levels)) if levels else min(known)
    unsure, others = (0.0 if levels else UNKNOWN_K), "in the others"
    cools = usual > WARMEST_ROOM and _lowest([source.run for source in sources]) < usual - SAME_ROOM_K
    if not levels and (cools or usual > HOTTEST_ROOM):
        usual, unsure, others = ROOM, ROOM_UNSURE_K, "rooms usually are"
    found: list[FloatArray | float] = []
    cold = _cold(starts, usual) if unsure == UNKNOWN_K else [False] * len(sources)
    for source, level, firsts in zip(sources, said, starts, strict=True):
        if level is not None:
            found.append(level)
            continue
        own = float(np.median(firsts)) if firsts else usual
        if _alike(firsts) and own - usual <= SAME_ROOM_K:
            warnings.append(
                f"{source.path}: no ambient_degC; a cold start is assumed, so {own:g} degC, where the run begins"
            )
            found.append(own)
        else:
            warnings.append(f"{source.path}: no ambient_degC, and a warm start; {usual:g} degC is taken, as {others}")
            found.append(usual)
    own = all(level is not None for level in said) and any(isinstance(level, float) for level in said)
    own = own and max(levels) - min(levels) > OTHER_ROOM_K
    if own:
        warnings.append(
            f"the runs say ambients from {min(levels):.3g} to {max(levels):.3g} degC: the file counts from what is "
            "measured (a column ambient_degC, or a line # ambient_degC in a run), for which a board needs a sensor; "
            "with --ambient it counts from a fixed one"
        )
    return Ambients(found, COLD_K if any(cold) else unsure, cold, own)


def _cold(starts: Sequence[Sequence[float]], usual: float) -> list[bool]:
    """Which runs begin at one level, by their first readings and the lowest of them all, if these are enough to say so.

    A motor that was run before begins somewhere else each time, and its parts differ.
    """
    cold = [_alike(firsts) and float(np.median(firsts)) - usual <= AT_ONE_LEVEL_K for firsts in starts]
    readings = sum(len(firsts) for firsts, own in zip(starts, cold, strict=True) if own)
    return cold if readings >= COLD_READINGS else [False] * len(cold)


def _said_ambient(source: Source, fixed: float | None, warnings: list[str]) -> FloatArray | float | None:
    """Give the ambient that was measured, noted or given: at every row, one number, or None.

    Parameters
    ----------
    source
        The run.
    fixed
        The ambient in degC where it was not measured, or None.
    warnings
        Added to.

    Raises
    ------
    InputError
        When what is noted is no number.
    """
    run = source.run
    if run.ambient is not None and np.isfinite(run.ambient).any():
        good = np.isfinite(run.ambient)
        missing = float(np.mean(~good))
        if missing > 0.05:
            warnings.append(f"{source.path}: ambient_degC is missing in {missing:.0%} of the rows; it is interpolated")
        return np.interp(run.time_s, run.time_s[good], run.ambient[good])
    if fixed is not None:
        return float(fixed)
    return noted_ambient(run, source.path)


def _lowest(runs: Sequence[Run]) -> float:
    """What the runs' parts cool to, degC: a twentieth of some part's readings is lower."""
    known = [values[np.isfinite(values)] for run in runs for values in run.temps.values()]
    return min(float(np.quantile(values, 0.05)) for values in known if values.size)


def _first_readings(run: Run) -> list[float]:
    """The first reading of each component that has one, degC; the next, where the first alone is astray."""
    known = [values[np.isfinite(values)][:3] for values in run.temps.values()]
    return [float(first[1] if _astray(first) else first[0]) for first in known if first.size]


def _astray(first: FloatArray) -> bool:
    """Whether a sensor began with what it had before its first conversion: far from two readings that agree."""
    if first.size < 3:
        return False
    return bool(abs(first[0] - first[1]) > ALIKE_K + ASTRAY * abs(first[1] - first[2]))


def _alike(firsts: Sequence[float]) -> bool:
    """Whether a run that begins with these readings may begin cold."""
    return bool(firsts) and max(firsts) - min(firsts) <= ALIKE_K
