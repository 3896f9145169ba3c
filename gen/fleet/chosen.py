"""Some of many, the same ones each time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

T = TypeVar("T")


def evenly(every: Sequence[T], most: int) -> list[T]:
    """Give at most so many, evenly over the sequence, both ends included: all of them, where there are no more."""
    places = np.unique(np.linspace(0, len(every) - 1, min(most, len(every))).round().astype(np.int64))
    return [every[place] for place in places.tolist()]
