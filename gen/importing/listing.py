"""Lists within a message of one line."""

from __future__ import annotations

from collections.abc import Iterable

MOST_SHOWN = 12


def listed(names: Iterable[str], between: str = ", ") -> str:
    """Names with a mark between them; of many the first, and how many more there are.

    Parameters
    ----------
    names
        What is listed.
    between
        The mark.
    """
    found = list(names)
    shown = between.join(found[:MOST_SHOWN])
    more = len(found) - MOST_SHOWN
    return shown if more <= 0 else f"{shown}{between if between != ', ' else ' '}and {more} more"
