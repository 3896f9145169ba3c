"""Measured temperatures that follow the room only: a sensor that fell off, or the ambient's under a part's name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.identification.logs.records import resolution
from gen.identification.logs.sources import Source
from gen.runs import AMBIENT

STILL_K, STEPS = 1.0, 4.0
"""What moves less than this, K, or than so many steps of its sensor, does not rise."""
RISES_K = 10.0
"""Another part rises by this, K: the motor was warm enough for all of its parts to be seen."""
LITTLE = 0.25
"""Where nothing says the ambient: what moves by less than this share of what moves most may be the room."""
_MOST = 98.0
"""Share of the readings that a course's movement is of, percent: single ones are noise."""


def followers(sources: Sequence[Source], names: Sequence[str]) -> list[str]:
    """Give a sentence for each part that stays as warm as it is, or as the room is, in all runs while others rise.

    Parameters
    ----------
    sources
        The runs.
    names
        Parts.
    """
    said = []
    for name in names:
        told = [_still(source, name) for source in sources if name in source.run.temps]
        known = [one for one in told if one is not None]
        if known and all(moved < limit for moved, limit, _, _ in known):
            moved, _, risen, other = max(known, key=lambda one: one[2])
            if risen > RISES_K:
                said.append(
                    f"{name}: never rises, or follows the room only: it moves by {moved:.1f} K where {other} moves by "
                    f"{risen:.0f} K; is its sensor on the motor, or is it the ambient's?"
                )
    return said or _rooms(sources, names)


def _rooms(sources: Sequence[Source], names: Sequence[str]) -> list[str]:
    """A sentence for the part that may be the room, where nothing says the ambient: the one that moves least by far."""
    if any(source.run.ambient is not None or AMBIENT in source.run.comments for source in sources):
        return []
    courses = {name: [s.run.temps[name] for s in sources if name in s.run.temps] for name in names}
    moved = {name: _moved(np.concatenate(values)) for name, values in courses.items() if values}
    if len(moved) < 2:
        return []
    least, most = min(moved, key=lambda name: moved[name]), max(moved, key=lambda name: moved[name])
    if moved[most] < RISES_K or moved[least] > LITTLE * moved[most]:
        return []
    return [
        f"{least} moves by {moved[least]:.1f} K where {most} moves by {moved[most]:.0f} K, and nothing says the "
        f"ambient: if {least} is the room's, name it ambient_degC (in the run's header, or by gen import --column)"
    ]


def _still(source: Source, name: str) -> tuple[float, float, float, str] | None:
    """By how much a part moves, what counts as still, and what moves most beside it, K; None without readings."""
    run = source.run
    values = run.temps[name]
    if np.count_nonzero(np.isfinite(values)) < 2:
        return None
    moved = _moved(values) if run.ambient is None else min(_moved(values), _moved(values - run.ambient))
    others = {each: _moved(own) for each, own in run.temps.items() if each != name}
    if run.ambient is not None:
        others["ambient"] = _moved(run.ambient)
    most = max(others, key=lambda each: others[each], default="")
    return moved, max(STILL_K, STEPS * resolution(values[np.isfinite(values)])), others.get(most, 0.0), most


def _moved(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    if known.size < 2:
        return float("inf")
    low, high = np.percentile(known, [50.0 - _MOST / 2.0, 50.0 + _MOST / 2.0])
    return float(high - low)
