"""Temperatures that look like degrees Fahrenheit under a name of degC."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.identification.logs.sources import Source

_HOT_K = 30.0
"""Who begins no further above the room may have run before; 22 degC read as Fahrenheit begin 50 K above it."""
_COLD_K = 6.0
"""What began cold is within this of its room when it is converted."""


def fahrenheit(sources: Sequence[Source], levels: Sequence[FloatArray | float]) -> list[str]:
    """Suspect Fahrenheit: all parts begin far above their ambient, and at it when converted.

    Parameters
    ----------
    sources
        The runs.
    levels
        The ambient of each, at every row, shape (N,), or one number, degC.
    """
    firsts, rooms = [], []
    for source, level in zip(sources, levels, strict=True):
        for values in source.run.temps.values():
            known = np.flatnonzero(np.isfinite(values))
            if known.size:
                firsts.append(float(values[known[0]]))
                rooms.append(level if isinstance(level, float) else float(level[known[0]]))
    first, room = np.array(firsts), np.array(rooms)
    converted = (first - 32.0) / 1.8
    if not first.size or np.any(first - room <= _HOT_K) or np.any(np.abs(converted - room) >= _COLD_K):
        return []
    return [
        f"every run begins {np.mean(first - room):.0f} K above ambient: are the temperatures in Fahrenheit? "
        "degC is expected; they are taken as they are, as a warm start"
    ]
