"""Days and seconds that are counted from long ago: what a number of them is as an instant."""

from __future__ import annotations

import re

_ORIGINS = (
    (30_000.0, 60_000.0, -25_569, "days since 1900, as Excel counts"),
    (60_000.0, 80_000.0, -40_587, "modified Julian days"),
    (700_000.0, 760_000.0, -719_529, "days since the year 0, as MATLAB counts"),
    (2_440_000.0, 2_500_000.0, -2_440_587.5, "Julian days"),
)
"""From and to which number of days, what 1970 is in them, and in words."""

_SINCE_1601_S, _SINCE_1_S = -11_644_473_600, -62_135_596_800
_GPS_S = 315_964_800 - 18
"""From 1970 to 1980, less the seconds by which GPS is ahead of UTC since 2017."""
_NTP_S = -2_208_988_800
_SECONDS = (
    (3.3e9, 5.0e9, -2_082_844_800, "since 1904, as LabVIEW counts"),
    (1.16e10, 1.5e10, _SINCE_1601_S, "since 1601, as Windows counts"),
    (6.2e10, 6.6e10, _SINCE_1_S, "since the year 1, as .NET counts"),
)
"""Likewise of seconds, the first from 2008 to 2062: no log lasts a hundred years."""
_NAMED = (
    (re.compile(r"(?:^|[^a-z])gps(?:[^a-z]|$)", re.IGNORECASE), 3e8, 2.5e9, _GPS_S, "since 1980, as GPS counts"),
    (re.compile(r"(?:^|[^a-z])s?ntp(?:[^a-z]|$)", re.IGNORECASE), 3.3e9, 5.0e9, _NTP_S, "since 1900, as NTP counts"),
)
"""What only a name tells: as numbers these may be seconds since 1970 or 1904, too."""


def seconds_since(seconds: float, name: str = "") -> tuple[int, str] | None:
    """What has to be added to a number of seconds so that it counts from 1970, and which seconds they are.

    Parameters
    ----------
    seconds
        The first of a log.
    name
        Of its column.

    Returns
    -------
    tuple or None
        None where it is a duration, or counts from 1970 itself.
    """
    for pattern, low, high, shift, words in _NAMED:
        if low < seconds < high and pattern.search(name):
            return shift, words
    return next(((shift, words) for low, high, shift, words in _SECONDS if low < seconds < high), None)


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
