"""Alarm thresholds of each motor from what healthy motors of the whole fleet are off their own models by.

One motor's first runs show few of the ways in which it may be off and healthy. What others of its series are off their
models by counts as its own: `gen.thresholds` is given the motor's own healthy runs and those of others, spread evenly
over the fleet. Runs that the models were fitted to take no part, nor motors that `gen fleet watch` calls different,
alone or with a batch that has changed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gen.coefficients import parse, with_rules
from gen.coefficients.rules import read_rules
from gen.errors import CheckFailed, InputError
from gen.fleet.chosen import evenly
from gen.fleet.folder.models import Model, in_use, model_path, paths_in_use, read_model, sound, with_model
from gen.fleet.folder.store import Kept, Store
from gen.fleet.identify import runs_of
from gen.fleet.tasks.motor_data import is_healthy, read
from gen.fleet.tasks.residuals import learnt_by
from gen.fleet.tasks.work import Arrays, Failed, Progress, Workers, computed, workers_of
from gen.fleet.watch import QUIET, read_watched
from gen.reference.heat_blocks import Blocks
from gen.thresholds.derive import complete, error_bands
from gen.thresholds.healthy import HealthyRun, compare

FOLDER = "thresholds"
OTHERS = 40
"""Runs of other motors that count as a motor's own."""
NEWEST = 3
"""Runs of each motor that may take part."""


@dataclass(frozen=True)
class Derived:
    """What came out.

    Attributes
    ----------
    own
        By motor, how many of its own healthy runs took part.
    notes
        By motor, each rule with where its numbers come from.
    refused
        By motor, why it has none.
    """

    own: dict[str, int]
    notes: dict[str, tuple[str, ...]]
    refused: dict[str, str]


def healthy_residuals(store: Store, *, motor: str, run: list[str], model: str) -> Arrays:
    """Hold a run against its motor's model as alarm rules will (a task); `model` is the file's hash."""
    coefficients = read_model(store, in_use(store, model_path(motor)))
    kept = Kept(*run)
    if f"{kept.name}.parquet" in learnt_by(coefficients):
        raise CheckFailed(f"{kept.path}: the model was fitted to it")
    measured = read(store, kept)
    if not is_healthy(measured.comments):
        raise CheckFailed(f"{kept.path}: it says a fault")
    found = compare(coefficients, measured, kept.path)
    assert found.blocks is not None
    return {
        "name": np.array(found.name),
        "pwm": found.pwm,
        "cold": np.array(found.cold),
        "parts": np.array(list(found.deviation_K), dtype=np.str_),
        "deviation_K": np.array(list(found.deviation_K.values())),
        "hottest_rise_K": np.array(list(found.hottest_rise_K.values())),
        "magnitude": found.blocks.magnitude,
        "changes": found.blocks.changes,
        "means": found.blocks.means,
        "present": found.blocks.present,
    }


def derive_all(store: Store, rules: Path, hours: float, workers: Workers, progress: Progress) -> Derived:
    """Derive thresholds for every motor with a model; the files go into the store.

    Parameters
    ----------
    store, workers, progress
        As of :func:`gen.fleet.identify.identify_fleet`.
    rules
        The rules file, as of `gen thresholds`.
    hours
        Wanted mean time between two false alarms of rules that hold a rate, h.

    Raises
    ------
    InputError
        When the rules have a fault, or the fleet was not identified yet.
    CheckFailed
        When no healthy run is newer than its motor's model, or no model can be read.
    """
    runs = runs_of(store)
    paths = paths_in_use(store, with_model(store, runs))
    if not paths:
        raise InputError("no motor has a model; expected a fleet that gen fleet identify has seen", file=store.url)
    models, broken = sound(store, paths)
    if not models:
        raise CheckFailed(f"no motor's model can be read: {next(iter(broken.values()))}")
    read_rules(rules, next(iter(models.values())).coefficients.model.component_names)
    different = _different(store)
    tasks = {
        f"{motor}/{run.day}/{run.name}": {
            "motor": motor,
            "run": [run.motor, run.day, run.name],
            "model": model.hash,
        }
        for motor, model in models.items()
        if motor not in different
        for run in runs[motor][-NEWEST:]
    }
    with workers_of(store, workers) as client:
        found = computed(store, healthy_residuals, tasks, client, progress)
    healthy: dict[str, list[HealthyRun]] = {motor: [] for motor in models}
    for name, arrays in found.items():
        if not isinstance(arrays, Failed):
            healthy[name.partition("/")[0]].append(_healthy(arrays))
    if not any(healthy.values()):
        raise CheckFailed("no healthy run is newer than its motor's model; identify with --until, and add newer runs")
    result = _derived(store, rules, hours, models, healthy, progress)
    if not result.own and len(set(result.refused.values())) == 1:
        raise InputError(next(iter(result.refused.values())), file=str(rules))  # it is the rules' fault
    return replace(result, refused={**broken, **result.refused})


def _derived(
    store: Store,
    rules: Path,
    hours: float,
    models: Mapping[str, Model],
    healthy: Mapping[str, Sequence[HealthyRun]],
    progress: Progress,
) -> Derived:
    own, notes, refused = {}, {}, {}
    for number, (motor, model) in enumerate(models.items(), start=1):
        progress(f"thresholds: {number} of {len(models)}")
        try:
            text = with_thresholds(model, rules, hours, [*healthy[motor], *_others(healthy, motor)])
            made = parse(text.encode())
        except (InputError, CheckFailed) as error:
            refused[motor] = str(error)
            continue
        store.write(f"{FOLDER}/motor={motor}.json", text.encode())
        own[motor] = len(healthy[motor])
        notes[motor] = tuple(f"{alarm.name}: {alarm.note or 'as written'}" for alarm in made.document.alarms)
    return Derived(own, notes, refused)


def with_thresholds(model: Model, rules: Path, hours: float, runs: Sequence[HealthyRun]) -> str:
    """Give a motor's coefficient file with alarms whose thresholds come from healthy runs.

    Parameters
    ----------
    model
        The motor's.
    rules, hours
        As of :func:`derive_all`.
    runs
        The motor's own, and others that count as such.

    Raises
    ------
    InputError, CheckFailed
        When the rules have a fault, or the runs do not give a rule its numbers.
    """
    coefficients = model.coefficients
    wanted = read_rules(rules, coefficients.model.component_names)
    alarms = [complete(rule, coefficients, runs, hours) for rule in wanted.alarms]
    bands = error_bands(coefficients.document, runs)
    return with_rules(model.text, wanted, alarms, bands, source="gen fleet thresholds")


def _others(healthy: Mapping[str, Sequence[HealthyRun]], motor: str) -> list[HealthyRun]:
    """Runs of other motors, evenly over the sorted list: the same ones each time."""
    every = [run for other in sorted(healthy) if other != motor for run in healthy[other]]
    return evenly(every, OTHERS)


def _different(store: Store) -> set[str]:
    """Motors that were called different when they were last watched, alone or with a batch that has changed."""
    watched = read_watched(store)
    if watched is None:
        return set()
    alone = {state.motor for state in watched.motors if state.state not in QUIET}
    return alone.union(*(batch.motors for batch in watched.batches if batch.changed))


def _healthy(arrays: Arrays) -> HealthyRun:
    parts = [str(part) for part in arrays["parts"]]
    return HealthyRun(
        name=str(arrays["name"]),
        pwm=arrays["pwm"],
        deviation_K=dict(zip(parts, arrays["deviation_K"], strict=True)),
        hottest_rise_K=dict(zip(parts, arrays["hottest_rise_K"].tolist(), strict=True)),
        cold=bool(arrays["cold"]),
        blocks=Blocks(arrays["magnitude"], arrays["changes"], arrays["means"], arrays["present"]),
    )
