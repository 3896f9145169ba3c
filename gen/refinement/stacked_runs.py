"""All runs side by side, as arrays for one fit: time, component, lane, run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gen.coefficients import Coefficients
from gen.model.effects import tolerance_K
from gen.model.effects.integrate import Track
from gen.model.effects.response import Response, answer, response
from gen.refinement.condense import Condensed
from gen.runs.run import FloatArray

FOLDS = 6
"""Most folds; fewer runs than that are left out one by one, so that each effect is excited in as many as can be."""
BLOCKS = 6
"""Blocks of each run for the test of an improvement."""
LEAST_BLOCKS = 36
"""Blocks that there shall be at least: few runs are cut finer."""


@dataclass(frozen=True)
class StackedRuns:
    """Residuals of some components in all runs; K bins (padded), C components, R runs.

    Parameters
    ----------
    components
        Their names.
    track
        The drive, axes (K or K + 1, C or 1, 1, R).
    residual, weight
        K, and number of samples; shape (K, C, 1, R); weight 0 where there is nothing.
    noise_K
        Standard deviation of a sample by component, shape (C,).
    left_out
        True for bins that fold f leaves out, shape (F, K, R).
    blocks
        Number of the block of each bin, shape (K, R), -1 for padding.
    responses
        Of the components of higher order than 1.
    tolerance_K
        Largest sensor offset that is fitted beside every hypothesis, K.
    """

    components: tuple[str, ...]
    track: Track
    residual: FloatArray
    weight: FloatArray
    noise_K: FloatArray
    left_out: np.ndarray
    blocks: np.ndarray
    responses: dict[str, Response]
    tolerance_K: float = field(default_factory=tolerance_K)

    def only(self, name: str) -> StackedRuns:
        """The same with one component."""
        at = self.components.index(name)
        part = slice(at, at + 1)
        track = replace(
            self.track,
            **{key: getattr(self.track, key)[:, part] for key in ("base", "fading", "rate", "heat")},
            measured_rise=self.track.measured_rise[part],
            others={other: rise for other, rise in self.track.others.items() if other != name},
            response=self.responses.get(name),
        )
        if track.response is not None:
            faded = answer(
                track.response, 0.0, np.zeros((1, 1, 1, 1)), np.zeros((1, 1, 1, 1)), np.ones(track.base.shape[1:])
            )
            track = replace(track, fading=faded)
        return replace(
            self,
            components=(name,),
            track=track,
            residual=self.residual[:, part],
            weight=self.weight[:, part],
            noise_K=self.noise_K[part],
        )

    def with_others(self, rises: dict[str, FloatArray]) -> StackedRuns:
        """The same with other components' rises, shape (K + 1, R) each."""
        others = {name: rise[:, None, None, :] for name, rise in rises.items()}
        return replace(self, track=replace(self.track, others={**self.track.others, **others}))


def stack_runs(coefficients: Coefficients, runs: Sequence[Condensed]) -> StackedRuns:
    """Stack the runs.

    Parameters
    ----------
    coefficients
        The baseline.
    runs
        Condensed runs; padding repeats their last state in steps of length 0.
    """
    model = coefficients.model
    names = tuple(c.name for c in model.components if any(c.name in run.traces for run in runs))
    length = max(run.edges.size - 1 for run in runs)

    def edges(values: Sequence[FloatArray]) -> FloatArray:
        return np.stack([np.pad(v, (0, length + 1 - v.size), mode="edge") for v in values], axis=-1)

    def bins(values: Sequence[FloatArray], fill: float = 0.0) -> FloatArray:
        return np.stack([np.pad(v, (0, length - v.size), constant_values=fill) for v in values], axis=-1)

    def lanes(array: FloatArray) -> FloatArray:
        return array[:, None, None, :]

    def by_component(key: str, ends: bool) -> FloatArray:
        stacked = []
        for name in names:
            columns = [
                getattr(run.traces[name], key) if name in run.traces else np.zeros(run.edges.size - (0 if ends else 1))
                for run in runs
            ]
            stacked.append(edges(columns) if ends else bins(columns))
        return np.stack(stacked, axis=1)[:, :, None, :]

    residual = by_component("residual", ends=False)
    weight = np.broadcast_to(lanes(bins([run.weight for run in runs])), residual.shape).copy()
    for c, name in enumerate(names):
        for r, run in enumerate(runs):
            if name not in run.traces:
                weight[:, c, :, r] = 0.0
    weight[~np.isfinite(residual)] = 0.0
    residual = np.where(weight > 0.0, residual, 0.0)
    ambient = lanes(edges([run.ambient for run in runs]))
    sensed = all(run.measured_ambient is not None for run in runs)
    measured = [run.measured_ambient if sensed and run.measured_ambient is not None else run.ambient for run in runs]
    base = by_component("base", ends=True)
    pwm = bins([run.pwm for run in runs])
    common = [key for key in runs[0].channels if all(key in run.channels for run in runs)]
    start = np.array([[run.traces[n].start_rise if n in run.traces else 0.0 for run in runs] for n in names])
    noise = [
        np.sqrt(np.mean([max(t.noise_K, t.resolution_K / np.sqrt(12.0)) ** 2 for t in _traces(runs, name)]))
        for name in names
    ]
    track = Track(
        step=lanes(bins([np.diff(run.edges) for run in runs])),
        elapsed=lanes(edges([run.edges - run.edges[0] for run in runs])),
        base=base,
        fading=by_component("fading", ends=True),
        ambient=ambient,
        measured_ambient=lanes(edges(measured)),
        rate=by_component("rate", ends=False),
        heat=by_component("heat", ends=False),
        pwm=lanes(pwm / model.full_scale),
        count=lanes(pwm),
        reverse=lanes(bins([run.reverse for run in runs])),
        standstill=lanes(bins([run.standstill for run in runs])),
        channels={key: lanes(bins([run.channels[key] for run in runs])) for key in common},
        others={name: base[:, c : c + 1] for c, name in enumerate(names)},
        measured_rise=start[:, None, :],
    )
    sizes = [run.edges.size - 1 for run in runs]
    return StackedRuns(
        components=names,
        track=track,
        residual=residual,
        weight=weight,
        noise_K=np.maximum(np.asarray(noise), 1e-3),
        left_out=_folds(sizes, length),
        blocks=_blocks(sizes, length),
        responses={
            c.name: response(c, np.rint(pwm).astype(np.int64), track.step[:, 0, 0, :])
            for c in model.components
            if c.name in names and c.order > 1
        },
    )


def _traces(runs: Sequence[Condensed], name: str) -> list:  # type: ignore[type-arg]
    return [run.traces[name] for run in runs if name in run.traces]


def _folds(sizes: Sequence[int], length: int) -> np.ndarray:
    """Whole runs, dealt to at most FOLDS folds; a single run is cut into three stretches instead."""
    if len(sizes) == 1:
        parts = np.arange(length) * 3 // max(sizes[0], 1)
        return np.stack([(parts == f)[:, None] for f in range(3)])
    many = min(len(sizes), FOLDS)
    owner = np.arange(len(sizes)) % many
    return np.stack([np.broadcast_to(owner == f, (length, len(sizes))) for f in range(many)])


def _blocks(sizes: Sequence[int], length: int) -> np.ndarray:
    many = max(BLOCKS, -(-LEAST_BLOCKS // len(sizes)))
    made = np.full((length, len(sizes)), -1)
    for r, size in enumerate(sizes):
        made[:size, r] = np.arange(size) * many // size + many * r
    return made
