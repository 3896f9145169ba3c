"""What can these runs tell at all? Checked before any hypothesis is fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.model.effects import registry
from gen.refinement.condense import Condensed

_HOUR = 3600.0


@dataclass(frozen=True)
class Excitation:
    """What the runs excite.

    Parameters
    ----------
    facts
        Label and figure, for the report.
    missing
        What the runs cannot tell, and the experiment that would.
    """

    facts: list[tuple[str, str]]
    missing: list[str]


def excitation(coefficients: Coefficients, runs: Sequence[Condensed]) -> Excitation:
    """Look at speeds, stops, directions, temperatures and channels."""
    step = np.concatenate([np.diff(run.edges) for run in runs])
    pwm = np.concatenate([run.pwm for run in runs])
    reverse = float(np.sum(step * np.concatenate([run.reverse for run in runs])) / _HOUR)
    still = float(np.sum(step * np.concatenate([run.standstill for run in runs])) / _HOUR)
    warm = [run for run in runs if any(trace.start_rise > 5.0 for trace in run.traces.values())]
    stops = sum(_hot_stops(run) for run in runs)
    scale = coefficients.document.input.full_scale
    held = np.unique(np.rint(pwm[pwm > 0] / scale * 20) * 5)
    facts = [
        ("runs", str(len(runs))),
        ("hours", f"{float(step.sum()) / _HOUR:.1f}"),
        ("speeds, %", ", ".join(f"{level:g}" for level in held) or "none"),
        ("hours at PWM 0", f"{still:.1f}"),
        ("cut-offs from hot", str(stops)),
        ("hours in reverse", f"{reverse:.1f}"),
        ("warm starts", str(len(warm))),
    ]
    common = sorted(set.intersection(*(set(run.channels) for run in runs)))
    values = {name: np.concatenate([run.channels[name] for run in runs]) for name in common}
    facts += [(name, f"{column.min():.4g} .. {column.max():.4g}") for name, column in values.items()]
    lacks = [
        (len(runs) < 3, "with fewer than three runs a run can hardly be left out: log more"),
        (
            stops == 0,
            "no cut-off from hot: a hidden hot part and the cooling at standstill cannot be seen; log one for 2 h",
        ),
        (reverse == 0.0, "one direction of rotation only: run the same speed in reverse for 2 h"),
        (
            held.size < 3,
            "fewer than three speeds: a wrong schedule cannot be told from a sensor's gain; run others for 2 h",
        ),
        (not warm, "no warm start: log a run that begins warm"),
        *((True, sentence) for sentence in _silent_channels(values)),
        (
            all(run.measured_ambient is None for run in runs),
            "no ambient was logged: a room that warms looks like a drift",
        ),
    ]
    return Excitation(facts, [sentence for lacking, sentence in lacks if lacking])


def _silent_channels(values: Mapping[str, FloatArray]) -> list[str]:
    """Quantities that effects read and nobody logged, and channels that never change."""
    wanted = [source for effect in registry().values() for source in effect.inputs if source.quantity]
    missing = [
        f"no {source.quantity} was logged: its effect cannot be seen"
        for source in wanted
        if not any(source.fits(name) for name in values)
    ]
    still = [name for name, column in values.items() if float(np.std(column)) < 1e-9]
    return missing + [f"{name} never changes: its effect cannot be seen" for name in still]


def _hot_stops(run: Condensed) -> int:
    """Times at which the motor stops with a part over 10 K warm and stays so for ten minutes."""
    still = run.standstill > 0.95
    stops = 0
    for k in np.flatnonzero(still[1:] & ~still[:-1]) + 1:
        after = run.edges[k:][: np.argmin(still[k:])] if not still[k:].all() else run.edges[k:]
        hot = any(trace.base[k] > 10.0 for trace in run.traces.values())
        stops += bool(hot and after.size and after[-1] - after[0] >= 600.0)
    return stops
