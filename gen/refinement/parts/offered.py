"""What the runs offer to explain a residual with: channels, speeds, warm starts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.coefficients import Coefficients
from gen.model.dynamics import PWM_LEVELS
from gen.model.effects import Setting
from gen.refinement.condense import Condensed
from gen.refinement.parts.stacked_runs import StackedRuns

WARM_K = 3.0
"""A rise at which a start counts as warm."""


def offered(coefficients: Coefficients, runs: Sequence[Condensed], whole: StackedRuns, name: str) -> Setting:
    """What the data offer to explain one component's residual with."""
    model = coefficients.model
    c = whole.components.index(name)
    counts = np.concatenate([np.rint(run.pwm).astype(np.int64) for run in runs])
    spans = np.concatenate([np.diff(run.edges) for run in runs])
    middle = (whole.track.count > 0).any() and np.median(whole.track.rate[:, c][whole.weight[:, c] > 0])
    return Setting(
        component=name,
        others=tuple(other for other in whole.components if other != name),
        channels={key: float(np.sqrt(np.mean(values**2))) for key, values in whole.track.channels.items()},
        levels=_levels(counts, spans),
        rate=float(middle) if middle else float(np.median(whole.track.rate[:, c])),
        ambient_fixed=None if model.ambient_channel is not None else model.ambient_fixed,
        varying=frozenset(key for key in whole.track.channels if _varies(runs, key)),
        reverse=any(bool(np.any(run.reverse > 0.5)) for run in runs),
        warm=any(run.traces[name].start_rise > WARM_K for run in runs if name in run.traces),
        ambient_measured=all(run.measured_ambient is not None for run in runs),
    )


def _varies(runs: Sequence[Condensed], key: str) -> bool:
    values = np.concatenate([run.channels[key] for run in runs])
    return bool(np.std(values) > 0.01 * np.sqrt(np.mean(values**2)))


def _levels(counts: np.ndarray, spans: np.ndarray) -> tuple[int, ...]:
    """|PWM| at which the motor ran for at least 3 % of the time: eight at most beside rest, 8 counts apart."""
    time = np.bincount(counts, spans, PWM_LEVELS)
    chosen: list[int] = [0] if time[0] > 0.01 * time.sum() else []
    near = np.convolve(time, np.ones(5), mode="same")
    for level in np.argsort(-near):
        if near[level] < 0.03 * time.sum() or len(chosen) >= 8 + (0 in chosen):
            break
        if level > 2 and all(abs(int(level) - other) >= 8 for other in chosen):
            window = np.arange(max(level - 2, 1), min(level + 3, PWM_LEVELS))
            chosen.append(int(np.rint(np.average(window, weights=time[window] + 1e-9))))
    return tuple(sorted(chosen))


def each_speed_once(runs: Sequence[Condensed]) -> bool:
    """Whether each run has one speed of its own, so that leaving out a run leaves out its speed."""
    speeds = []
    for run in runs:
        moving = run.pwm[run.pwm > 0]
        if moving.size == 0 or np.ptp(moving) > 1.0:
            return False
        speeds.append(float(np.rint(moving[0])))
    return len(runs) >= 2 and len(set(speeds)) == len(speeds)
