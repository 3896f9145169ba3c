"""Days and seconds that are counted from long ago: what a number of them is as an instant."""

from __future__ import annotations

_ORIGINS = (
    (30_000.0, 60_000.0, -25_569, "days since 1900, as Excel counts"),
    (700_000.0, 760_000.0, -719_529, "days since the year 0, as MATLAB counts"),
    (2_440_000.0, 2_500_000.0, -2_440_587.5, "Julian days"),
)
"""From and to which number of days, what 1970 is in them, and in words."""

_SINCE_1904 = (3.3e9, 5.0e9, -2_082_844_800, "s since 1904, as LabVIEW counts")
"""Likewise of seconds, from 2008 to 2062: no log lasts a hundred years."""


def seconds_since(seconds: float) -> tuple[int, str] | None:
    """What has to be added to a number of seconds so that it counts from 1970, and which seconds they are.

    Parameters
    ----------
    seconds
        The first of a log.

    Returns
    -------
    tuple or None
        None where it is a duration, or counts from 1970 itself.
    """
    low, high, shift, words = _SINCE_1904
    return (shift, words) if low < seconds < high else None


def days_since(days: float) -> tuple[float, str] | None:
    """What has to be added to a number of days so that it counts from 1970, and which days they are.

    Parameters
    ----------
    days
        The first of a log.

    Returns
    -------
    tuple or None
        None where it is a duration.
    """
    return next(((shift, words) for low, high, shift, words in _ORIGINS if low < days < high), None)
