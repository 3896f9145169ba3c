"""How far a change moves what the sensors are at; and its strength, so that it can be seen and is no other motor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.cases import Bench
from benchmarks.plants.planted.change import Change
from benchmarks.plants.planted.later import FIT_NAMES, TEST_NAMES, Followed, follow
from benchmarks.plants.planted.surroundings import InitialState

FloatArray = NDArray[np.float64]
LEAST_PEAK_K, MOST_PEAK_K = 1.5, 8.0
"""Between these lies the most by which a change moves a sensed node in the runs that it is judged by."""
LEAST_RMS_K = 0.5
"""By how much it moves at least one sensed node, root mean square, in the fit runs and in the test runs."""
TARGETS_K = (2.0, 7.0)
"""Of its peak, before it has been tried in all runs."""
ROW_S = 30.0
FADES_IN = slice(int(3600.0 / ROW_S))
SEEN_IN = (FIT_NAMES[:2], TEST_NAMES)
TRIED_IN = (FIT_NAMES[0], TEST_NAMES[0])


@dataclass(frozen=True)
class Sight:
    """How far a change moves what the sensors are at.

    Parameters
    ----------
    peak_K
        The most, over all runs and sensed nodes.
    fit_K, test_K
        Root mean square at the node that it moves most, in two fit runs and in the test runs.
    """

    peak_K: float
    fit_K: float
    test_K: float

    @property
    def fair(self) -> bool:
        """Whether it can be seen, and is not too large."""
        rms = min(self.fit_K, self.test_K)
        return LEAST_PEAK_K <= self.peak_K <= MOST_PEAK_K and rms >= LEAST_RMS_K


@dataclass(frozen=True)
class _Still(Change):
    """The room is held, and nothing else is changed."""

    else_held = True


@lru_cache(maxsize=64)
def _unchanged(stand: Bench, name: str, held: bool) -> FloatArray:
    return follow(stand, (_Still(),) if held else (), name, ROW_S).seen


def moved(stand: Bench, change: Change, name: str) -> FloatArray:
    """What the sensors are at with a change minus without it, in one run, K, shape (N, sensed nodes and 1).

    The last is by how much the room's thermometer is off.
    """
    changed = follow(stand, (change,), name, ROW_S)
    if isinstance(change, InitialState):
        away = _beside_guesses(stand, changed, name)
    else:
        away = changed.seen - _unchanged(stand, name, change.else_held)
    return np.column_stack([away, changed.room_seen - changed.run.ambient])


def _beside_guesses(stand: Bench, changed: Followed, name: str) -> FloatArray:
    """Minus the best of what can be guessed of the nodes without a sensor, from those that have one."""
    plant, start = stand.plant, changed.run.temperature[0].copy()
    inside = [node for node in range(plant.size) if node not in plant.sensed]
    if not inside:
        return np.zeros_like(changed.seen)
    running = plant.at(0)
    settled = running.matrix[np.ix_(inside, list(plant.sensed))] @ start[list(plant.sensed)]
    settled += running.outlet[inside] * changed.run.ambient[0]
    found = []
    for guess in (
        np.full(len(inside), changed.run.ambient[0]),
        np.linalg.solve(running.matrix[np.ix_(inside, inside)], -settled),
    ):
        start[inside] = guess
        found.append(changed.seen - follow(stand, (), name, ROW_S, start.copy()).seen)
    return min(found, key=lambda away: float(np.mean(away**2)))


def sight(stand: Bench, change: Change) -> Sight:
    """How far a change moves what the sensors are at; what was before a run counts by its first hour, as it fades."""
    rows = FADES_IN if isinstance(change, InitialState) else slice(None)
    fit, test = (np.concatenate([moved(stand, change, name)[rows] for name in names]) for names in SEEN_IN)
    peak = max(float(np.max(np.abs(away))) for away in (fit, test))
    return Sight(peak, *(float(np.sqrt(np.max(np.mean(away**2, axis=0)))) for away in (fit, test)))


def sized(stand: Bench, build: Callable[[float], Change], span: tuple[float, float], target_K: float) -> Change:
    """A change of about a wanted peak.

    Parameters
    ----------
    build
        The change of some strength; the stronger, the farther it moves the sensors.
    span
        The weakest and the strongest that there can be.
    target_K
        The peak.
    """
    low, high = span
    strength = float(np.sqrt(low * high))
    for _ in range(8):
        peak = _tried(stand, build(strength))
        if 0.8 <= peak / target_K <= 1.25:
            break
        wanted = strength * float(np.clip(target_K / max(peak, 1e-6), 0.2, 5.0))
        following = float(np.clip(wanted, low, high))
        if following == strength:
            break
        strength = following
    return build(strength)


def _tried(stand: Bench, change: Change) -> float:
    try:
        return max(float(np.max(np.abs(moved(stand, change, name)))) for name in TRIED_IN)
    except (RuntimeError, FloatingPointError):  # it runs away
        return 1e3
