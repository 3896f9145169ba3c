"""The rivals: each makes a number of every block and part, and alarms where it exceeds 1.2 times the worst healthy one.

`limit`: the part's temperature over the usual room of 30 degC; so "1.2 times the worst" is a temperature.
`rise_watch`: how much it has risen within two minutes, as printers' firmware watches a heater (there, that it rises
enough; here, that it does not rise too much).
`ModelRate`: a one-capacity model of each part, fitted to the healthy runs; its rate of change against the measured one
in K/s behind a low-pass, as printers' firmware does it with thermal models of heaters.
`residual`: measured less the identified model, without anything else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from benchmarks.rivals.alarms.blocks import BLOCK_S, FIXED_ROOM_DEGC, Blocks, FloatArray

MARGIN = 1.2
WATCHED_S = 120.0
LOW_PASS_S = 300.0
Statistic = Callable[[Blocks], FloatArray]


@dataclass(frozen=True)
class Detector:
    """A statistic and its thresholds.

    Attributes
    ----------
    title
        What the table calls it.
    statistic
        Gives a number for each block and part, shape (n, components).
    threshold
        By component, in the statistic's unit, shape (components,).
    """

    title: str
    statistic: Statistic
    threshold: FloatArray

    def first_s(self, blocks: Blocks) -> float | None:
        """Time of the first alarm of any part, s, or None."""
        above = (self.statistic(blocks) > self.threshold).any(axis=1)
        return float(blocks.end_s[np.argmax(above)]) if above.any() else None


def limit(blocks: Blocks) -> FloatArray:
    """Temperature over the usual room, K."""
    return blocks.measured_degC - FIXED_ROOM_DEGC


def rise_watch(blocks: Blocks) -> FloatArray:
    """Rise within `WATCHED_S`, K."""
    back = round(WATCHED_S / BLOCK_S)
    risen = np.zeros_like(blocks.measured_degC)
    risen[back:] = blocks.measured_degC[back:] - blocks.measured_degC[:-back]
    return risen


def residual(blocks: Blocks) -> FloatArray:
    """Measured less modelled, K."""
    return blocks.measured_degC - blocks.model_degC


class ModelRate:
    """A one-capacity model of each part: dT/dt = p u + q u^2 - (r + s u) (T - room), u the drive 0..1."""

    def __init__(self, healthy: Sequence[Blocks]) -> None:
        parts = healthy[0].measured_degC.shape[1]
        self._fitted = []
        for part in range(parts):
            terms = np.concatenate([self._terms(blocks, part) for blocks in healthy])
            rates = np.concatenate([self._rates(blocks)[:, part] for blocks in healthy])
            self._fitted.append(np.linalg.lstsq(terms, rates, rcond=None)[0])

    def __call__(self, blocks: Blocks) -> FloatArray:
        """Measured less modelled rate behind a low-pass of `LOW_PASS_S`, K/s."""
        expected = np.column_stack([self._terms(blocks, part) @ fit for part, fit in enumerate(self._fitted)])
        share = 1.0 - np.exp(-BLOCK_S / LOW_PASS_S)
        slow = lfilter([share], [1.0, share - 1.0], self._rates(blocks) - expected, axis=0)
        return np.vstack([np.zeros((1, len(self._fitted))), slow])

    @staticmethod
    def _rates(blocks: Blocks) -> FloatArray:
        return np.asarray(np.diff(blocks.measured_degC, axis=0) / BLOCK_S, dtype=np.float64)

    @staticmethod
    def _terms(blocks: Blocks, part: int) -> FloatArray:
        """Means between neighbouring blocks of what acts, shape (n - 1, 4)."""
        drive = blocks.drive[1:] / 2 + blocks.drive[:-1] / 2
        over = blocks.measured_degC[:, part] - blocks.room_degC
        over = over[1:] / 2 + over[:-1] / 2
        return np.column_stack([drive, drive**2, -over, -over * drive])


def detectors(healthy: Sequence[Blocks]) -> list[Detector]:
    """All rivals, with thresholds from the same healthy runs: `MARGIN` times the worst of each part."""
    ways: list[tuple[str, Statistic]] = [
        ("fixed limit", limit),
        ("temperature-rise watch, 2 min", rise_watch),
        ("one-capacity model, K/s", ModelRate(healthy)),
        ("plain residual", residual),
    ]
    return [
        Detector(title, way, MARGIN * np.max([way(blocks).max(axis=0) for blocks in healthy], axis=0))
        for title, way in ways
    ]
