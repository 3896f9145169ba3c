"""All runs side by side, as arrays for one fit: time, component, lane, run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.coefficients.checks.effect_checks import runs_away
from gen.model.effects import Applied, tolerance_K
from gen.model.effects.integrate import Track
from gen.model.effects.response import Response, answer, response
from gen.refinement.condense import Condensed

FOLDS = 6
"""Most folds; fewer runs than that are left out one by one, so that each effect is excited in as many as can be."""
BLOCKS = 6
"""Blocks of each run for the test of an improvement."""
LEAST_BLOCKS = 36
"""Blocks that there shall be at least: few runs are cut finer."""
LEAST_NOISE_K = 1e-3
WHOLE_RUNS = "whole runs"
THIRDS = "thirds of the one run"


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
    left_out_parts
        What they are, in words: whole runs, or of a single run its thirds.
    blocks
        Number of the block of each bin, shape (K, R), -1 for padding.
    responses
        Of the components of higher order than 1.
    tolerance_K
        Largest sensor offset that is fitted beside every hypothesis, K.
    runs_away
        Whether temperatures would grow without end with these effects beside the baseline's.
    """

    components: tuple[str, ...]
    track: Track
    residual: FloatArray
    weight: FloatArray
    noise_K: FloatArray
    left_out: np.ndarray
    left_out_parts: str
    blocks: np.ndarray
    responses: dict[str, Response]
    tolerance_K: float = field(default_factory=tolerance_K)
    runs_away: Callable[[Sequence[Applied]], bool] = lambda _: False

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
    stack = _Stack(names, tuple(runs))
    residual, weight = _residual(stack)
    track = _track(stack, model.full_scale)
    sizes = [run.edges.size - 1 for run in runs]
    left_out, left_out_parts = _folds(sizes, stack.length)
    counts, step = np.rint(track.count[:, 0, 0, :]).astype(np.int64), track.step[:, 0, 0, :]
    return StackedRuns(
        components=names,
        track=track,
        residual=residual,
        weight=weight,
        noise_K=np.array([max(_noise_K(runs, name), LEAST_NOISE_K) for name in names]),
        left_out=left_out,
        left_out_parts=left_out_parts,
        blocks=_blocks(sizes, stack.length),
        responses={c.name: response(c, counts, step) for c in model.components if c.name in names and c.order > 1},
        runs_away=lambda more: runs_away(coefficients.document, model, coefficients.effects, more),
    )


@dataclass(frozen=True)
class _Stack:
    """Runs of different length side by side: K bins of the longest, R runs."""

    names: tuple[str, ...]
    runs: tuple[Condensed, ...]

    @property
    def length(self) -> int:
        return max(run.edges.size - 1 for run in self.runs)

    def ends(self, values: Iterable[FloatArray]) -> FloatArray:
        """Values at the bins' ends, the last one held: shape (K + 1, 1, 1, R)."""
        padded = [np.pad(v, (0, self.length + 1 - v.size), mode="edge") for v in values]
        return np.stack(padded, axis=-1)[:, None, None, :]

    def means(self, values: Iterable[FloatArray]) -> FloatArray:
        """Means of the bins, zeros after the last one: shape (K, 1, 1, R)."""
        padded = [np.pad(v, (0, self.length - v.size)) for v in values]
        return np.stack(padded, axis=-1)[:, None, None, :]

    def means_of_runs(self, key: str) -> FloatArray:
        """A run's means of the bins, zeros after the last one: shape (K, 1, 1, R)."""
        return self.means(getattr(run, key) for run in self.runs)

    def ends_of(self, key: str) -> FloatArray:
        """A component's values at the bins' ends, zeros where it was not measured: shape (K + 1, C, 1, R)."""
        return np.concatenate([self.ends(self._of(name, key, 0)) for name in self.names], axis=1)

    def means_of(self, key: str) -> FloatArray:
        """A component's means of the bins, zeros where it was not measured: shape (K, C, 1, R)."""
        return np.concatenate([self.means(self._of(name, key, 1)) for name in self.names], axis=1)

    def _of(self, name: str, key: str, fewer: int) -> Iterator[FloatArray]:
        for run in self.runs:
            yield getattr(run.traces[name], key) if name in run.traces else np.zeros(run.edges.size - fewer)


def _residual(stack: _Stack) -> tuple[FloatArray, FloatArray]:
    """The residual, K, and the number of samples behind it, 0 where a component was not measured; (K, C, 1, R)."""
    residual = stack.means_of("residual")
    measured = np.array([[name in run.traces for run in stack.runs] for name in stack.names])
    weight = np.where(measured[:, None, :], stack.means_of_runs("weight"), 0.0)
    weight[~np.isfinite(residual)] = 0.0
    return np.where(weight > 0.0, residual, 0.0), weight


def _track(stack: _Stack, full_scale: int) -> Track:
    """What drives the components' effects."""
    base = stack.ends_of("base")
    count = stack.means_of_runs("pwm")
    return Track(
        step=stack.means(np.diff(run.edges) for run in stack.runs),
        elapsed=stack.ends(run.edges - run.edges[0] for run in stack.runs),
        base=base,
        fading=stack.ends_of("fading"),
        ambient=stack.ends(run.ambient for run in stack.runs),
        measured_ambient=stack.ends(_measured_ambient(stack.runs)),
        rate=stack.means_of("rate"),
        heat=stack.means_of("heat"),
        pwm=count / full_scale,
        count=count,
        reverse=stack.means_of_runs("reverse"),
        standstill=stack.means_of_runs("standstill"),
        channels=_channels(stack),
        others={name: base[:, c : c + 1] for c, name in enumerate(stack.names)},
        measured_rise=_start_rise(stack)[:, None, :],
    )


def _measured_ambient(runs: Sequence[Condensed]) -> list[FloatArray]:
    """The measured ambient where every run has it, else the one that the model counts from, degC."""
    measured = [run.measured_ambient for run in runs if run.measured_ambient is not None]
    return measured if len(measured) == len(runs) else [run.ambient for run in runs]


def _channels(stack: _Stack) -> dict[str, FloatArray]:
    """Extra channels that every run has."""
    common = [key for key in stack.runs[0].channels if all(key in run.channels for run in stack.runs)]
    return {key: stack.means(run.channels[key] for run in stack.runs) for key in common}


def _start_rise(stack: _Stack) -> FloatArray:
    """Measured rise at the start, 0 where a component was not measured, K, shape (C, R)."""
    return np.array([[run.traces[n].start_rise if n in run.traces else 0.0 for run in stack.runs] for n in stack.names])


def _noise_K(runs: Sequence[Condensed], name: str) -> float:
    """Standard deviation of a component's samples in all runs, at least that of its readings' steps, K."""
    traces = [run.traces[name] for run in runs if name in run.traces]
    return float(np.sqrt(np.mean([max(t.noise_K, t.resolution_K / np.sqrt(12.0)) ** 2 for t in traces])))


def _folds(sizes: Sequence[int], length: int) -> tuple[np.ndarray, str]:
    """Whole runs, dealt to at most FOLDS folds; a single run is cut into thirds instead. Second: which of the two."""
    if len(sizes) == 1:
        parts = np.arange(length) * 3 // max(sizes[0], 1)
        return np.stack([(parts == f)[:, None] for f in range(3)]), THIRDS
    many = min(len(sizes), FOLDS)
    owner = np.arange(len(sizes)) % many
    return np.stack([np.broadcast_to(owner == f, (length, len(sizes))) for f in range(many)]), WHOLE_RUNS


def _blocks(sizes: Sequence[int], length: int) -> np.ndarray:
    many = max(BLOCKS, -(-LEAST_BLOCKS // len(sizes)))
    made = np.full((length, len(sizes)), -1)
    for r, size in enumerate(sizes):
        made[:size, r] = np.arange(size) * many // size + many * r
    return made
