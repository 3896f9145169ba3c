"""Columns that hold the least and the largest value of each interval, of one sensor."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

import numpy as np

from gen.importing.guessing.evidence import Facts

_MIN = re.compile(r"(.*[^A-Za-z])min([^A-Za-z].*)?", re.IGNORECASE)
_APART_K = 5.0
"""How far the two lie apart at most, mostly, in their unit: those of a whole part lie further apart."""


def least_of_pairs(columns: Sequence[Facts], told: Collection[str]) -> dict[str, str]:
    """Columns of the least values beside which stands one of the largest, which alone is taken for the sensor's.

    Parameters
    ----------
    columns
        Of numbers.
    told
        Columns of which the user says something.

    Returns
    -------
    dict
        Name of the least -> name of the largest.
    """
    named = {facts.name.casefold(): facts for facts in columns}
    found = {}
    for facts in columns:
        match = _MIN.fullmatch(facts.name)
        other = named.get(f"{match[1]}max{match[2] or ''}".casefold()) if match else None
        if other is not None and not {facts.name, other.name} & set(told) and _pair(facts, other):
            found[facts.name] = other.name
    return found


def _pair(least: Facts, largest: Facts) -> bool:
    apart = [b.values - a.values for a, b in zip(least.parsed, largest.parsed, strict=True)]
    found = np.concatenate(apart)
    found = found[np.isfinite(found)]
    return bool(found.size and found.min() >= 0 and np.median(found) <= _APART_K)
