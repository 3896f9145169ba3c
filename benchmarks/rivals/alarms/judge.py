"""Rivals and generated rules on the same runs."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.alarm_hours.judged import DEFAULT
from benchmarks.alarm_hours.lives import RUN_S, Life, fault_lives, healthy_lives
from benchmarks.rivals.alarms.blocks import Blocks, FloatArray, blocks_of
from benchmarks.rivals.alarms.detectors import Detector, detectors
from examples.my1016_rig.make import bench_of, healthy_runs
from gen.coefficients import Coefficients, load
from gen.lowering.alarms import lower_alarms
from gen.reference.run_alarms import raised_s
from gen.reference.simulate import simulate_run
from gen.rig import make_run
from gen.runs import Run, read_run

SEED = 41
HOUR_S = 3600.0
SEVERITIES = ("1", "0.25")
LEVELS, ALL = "gen, level rules", "gen, all rules"


@dataclass(frozen=True)
class Heard:
    """What one way made of one run.

    Attributes
    ----------
    kind
        Of the run.
    fault_s
        When its fault begins, s, or None.
    hours
        How long the motor was healthy in it.
    first_s
        By way, the first alarm, s, or None.
    """

    kind: str
    fault_s: float | None
    hours: float
    first_s: dict[str, float | None]


def judged(quick: bool, tell: Callable[[str], None]) -> list[Heard]:
    """Give thresholds to the rivals, and run all ways.

    Parameters
    ----------
    quick
        Fewer runs: a third of the healthy ones, faults at full severity and three speeds.
    tell
        Told what is being done.
    """
    coefficients = load(DEFAULT)
    tell("healthy runs for the thresholds")
    rivals = detectors(trained(coefficients, 3 if quick else 1))
    lives = list(_lives(quick))
    found = []
    for number, life in enumerate(lives, start=1):
        tell(f"run {number} of {len(lives)}: {life.kind}")
        run = make_run(life.profile, life.setup).run
        hours = (RUN_S if life.fault_s is None else life.fault_s) / HOUR_S
        found.append(Heard(life.kind, life.fault_s, hours, heard(coefficients, rivals, run)))
    return found


def trained(coefficients: Coefficients, every: int) -> list[Blocks]:
    """The healthy runs that the example's own thresholds come from, or each so-many-th of them."""
    with tempfile.TemporaryDirectory(prefix="rivals-") as folder:
        paths = healthy_runs(Path(folder), bench_of(has_learnt=False, loaded=False))[::every]
        return [_blocks(coefficients, read_run(path)) for path in paths]


def heard(coefficients: Coefficients, rivals: Sequence[Detector], run: Run) -> dict[str, float | None]:
    """The first alarm of each way, s."""
    model = _model(coefficients, run)
    blocks = blocks_of(run, model)
    first = {rival.title: rival.first_s(blocks) for rival in rivals}
    raised = raised_s(coefficients, run, model)
    levels = {rule.name for rule in lower_alarms(coefficients) if rule.heat is None}
    first[LEVELS] = min((when for name, when in raised.items() if name in levels), default=None)
    first[ALL] = min(raised.values(), default=None)
    return first


def _lives(quick: bool) -> Iterable[Life]:
    yield from healthy_lives(RUN_S / HOUR_S * (13 if quick else 39), SEED)
    for number, life in enumerate(fault_lives(SEED)):
        severity = life.kind.split()[1]
        if severity in SEVERITIES[: 1 if quick else 2] and not (quick and number % 3):
            yield life


def _model(coefficients: Coefficients, run: Run) -> dict[str, FloatArray]:
    shown = simulate_run(coefficients, run, "exact", "auto", "run")
    return {name: np.asarray(shown[f"{name}_degC"], dtype=np.float64) for name in coefficients.model.component_names}


def _blocks(coefficients: Coefficients, run: Run) -> Blocks:
    return blocks_of(run, _model(coefficients, run))
