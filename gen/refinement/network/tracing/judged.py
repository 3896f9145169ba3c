"""What left-out data say of a hypothesis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.refinement.gains import p_of_gains
from gen.refinement.network.effects import NetworkEffect
from gen.refinement.network.fitting.data import Data
from gen.refinement.network.fitting.fit import Fitted
from gen.refinement.verdict import EXPLAINED, NOTHING

LEAST_NOISE_K = 0.05
BLOCK_S = 1800.0
"""Errors are compared in blocks of this length: shorter ones are not independent of each other."""


@dataclass(frozen=True, eq=False)
class Judged:
    """A hypothesis with its error on what was left out.

    Attributes
    ----------
    fitted
        At its best, all runs seen.
    error
        On what was left out, shape (N, S), K; NaN where nothing was predicted.
    score_K
        Root mean square of it, the noise of single readings included.
    noise_K
        Of single readings, root mean square over the sensors.
    """

    fitted: Fitted
    error: FloatArray
    score_K: float
    noise_K: float

    @property
    def floors(self) -> float:
        """The score in noise floors."""
        return self.score_K / self.noise_K

    @property
    def names(self) -> tuple[str, ...]:
        """Of its effects."""
        return tuple(effect.name for effect in self.fitted.shape.effects)


def judged(data: Data, fitted: Fitted, error: FloatArray) -> Judged:
    """Give the score of left-out errors."""
    cover = np.where(np.isfinite(error), data.inputs.covered, 0.0)
    square = float(np.sum(cover * (np.nan_to_num(error) ** 2 - _left_in_means(data))) / max(float(cover.sum()), 1e-9))
    noise = float(np.sqrt(np.mean([run.noise_K**2 for run in data.inputs.runs[: data.later]])))
    noise = max(noise, LEAST_NOISE_K)
    return Judged(fitted, error, float(np.sqrt(max(square, 0.0) + noise**2)), noise)


def _left_in_means(data: Data) -> FloatArray:
    """Mean square of what a sensor's noise leaves in the means of its readings over each bin, shape (N, S), K^2."""
    inputs = data.inputs
    noise, sample = (
        np.array([getattr(run, key) for run in inputs.runs])[inputs.run] for key in ("noise_K", "sample_s")
    )
    return np.asarray(noise**2 * np.minimum(sample / np.maximum(inputs.covered, 1e-9), 1.0))


def blocks(data: Data, error: FloatArray) -> FloatArray:
    """Mean square errors in blocks of half an hour of each run, all sensed nodes together, shape (B,), K^2."""
    inputs = data.inputs
    seen = np.isfinite(error)
    cover = np.where(seen, inputs.covered, 0.0)
    square = np.sum(cover * np.nan_to_num(error) ** 2, axis=1)
    length = np.array([max(BLOCK_S, run.duration / 48.0) for run in inputs.runs])[inputs.run]
    key = inputs.run * 100_000 + (inputs.begins / length).astype(np.int64)
    _, index = np.unique(key[data.is_later], return_inverse=True)
    total = np.bincount(index, square[data.is_later])
    weight = np.bincount(index, cover.sum(axis=1)[data.is_later])
    return np.asarray(total[weight > 0.0] / weight[weight > 0.0])


def p_better(data: Data, worse: Judged, better: Judged) -> float:
    """One-sided p-value that one predicts what was left out better than another, by blocks."""
    return p_of_gains(blocks(data, worse.error) - blocks(data, better.error))


def worst_sensor(data: Data, of: Judged) -> float:
    """The largest left-out error of one sensor in its noise floors.

    A sensor that is quieter than most counts as one of these: what they could not tell is not missing at it either.
    """
    cover = np.where(np.isfinite(of.error), data.inputs.covered, 0.0)
    square = np.sum(cover * (np.nan_to_num(of.error) ** 2 - _left_in_means(data)), axis=0)
    square = np.maximum(square / np.maximum(cover.sum(axis=0), 1e-9), 0.0)
    noise = np.mean([run.noise_K**2 for run in data.inputs.runs[: data.later]], axis=0)
    noise = np.maximum(noise, max(float(np.median(noise)), LEAST_NOISE_K**2))
    return float(np.sqrt(np.max((square + noise) / noise)))


def is_explained(data: Data, of: Judged) -> bool:
    """Whether so little is left that a verdict would call it explained."""
    return of.floors <= EXPLAINED and worst_sensor(data, of) <= NOTHING


def doubts(fitted: Fitted) -> list[str]:
    """Say what speaks against the effects' numbers: a physical limit, or what they would mean."""
    each = zip(fitted.shape.effects, fitted.shape.values(fitted.vector), strict=True)
    return [said for effect, values in each for said in doubts_of(effect, values)]


def doubts_of(effect: NetworkEffect, values: Sequence[float]) -> list[str]:
    """Say the same of one effect with its numbers."""
    at_limits = [
        f"{number.name} of {effect.name} is at its limit"
        for number, value in zip(effect.numbers, values, strict=True)
        if not number.low < value < number.high
    ]
    return [*effect.doubts(values), *at_limits]
