"""A state for each motor from its newest run, and what all motors, or all of one label, show: not wrong with one."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.errors import InputError
from gen.fleet.folder.labels import Labels, labels_of
from gen.fleet.folder.models import COMMON, in_use, models_of
from gen.fleet.folder.names import checked_motor
from gen.fleet.folder.store import Kept, Store
from gen.fleet.identify import runs_of
from gen.fleet.statistics.batches import groups_of
from gen.fleet.statistics.findings import LEAST_K, Finding
from gen.fleet.statistics.judging import FEWEST, Judged, judge
from gen.fleet.statistics.patterns import Hypothesis
from gen.fleet.tasks.residuals import newest_against_models, products_in
from gen.fleet.tasks.scouting import as_lists
from gen.fleet.tasks.work import Arrays, Failed, Progress, Workers, computed, workers_of

FILE = "watch.json"
SHOWN = 12
"""Runs of each motor in the course of its error."""
GROWN = 2.0
"""What the error of a motor's own model may have grown by on its newest run, so that it still explains the motor."""
QUIET = ("ok", "not enough data")
"""States that are no alarm."""


@dataclass(frozen=True)
class State:
    """What is known of one motor.

    Attributes
    ----------
    motor
        Whose.
    state
        `ok`, `warmer`, `cooler`, `sensor differs`, `differs from its fleet`, `differs from its model` (in a fleet too
        small to say how) or `not enough data`.
    said
        In words.
    error_K
        Of its own model on its newest run, root mean square of means over a minute, K; None where there is none.
    course_K
        The same of its newest runs in time, oldest first.
    days
        Of those runs.
    last_alarm
        Day and words of the last state that was an alarm; may be empty.
    labels
        `KEY=VALUE` of each.
    """

    motor: str
    state: str
    said: str
    error_K: float | None = None
    course_K: tuple[float | None, ...] = ()
    days: tuple[str, ...] = ()
    last_alarm: str = ""
    labels: tuple[str, ...] = ()


@dataclass(frozen=True)
class Apart:
    """What motors of one label show together beside the others: no fault of one of them.

    Attributes
    ----------
    labels
        Which, `KEY=VALUE`; several where they name the same motors.
    motors
        Those whose newest runs were judged.
    said
        In words.
    changed
        Whether since they were identified; else their own models explain it.
    """

    labels: tuple[str, ...]
    motors: tuple[str, ...]
    said: str
    changed: bool


@dataclass(frozen=True)
class Watched:
    """What was found.

    Attributes
    ----------
    motors
        By name.
    common
        What all motors show beside their models, in words; may be empty.
    limit
        In standard deviations; None where there were too few motors.
    level
        Of false alarms, a run of a healthy motor.
    batches
        What motors of one label show.
    """

    motors: tuple[State, ...]
    common: tuple[str, ...]
    limit: float | None
    level: float
    batches: tuple[Apart, ...] = ()


def watch(store: Store, level: float, workers: Workers, progress: Progress) -> Watched:
    """Judge all motors, and keep the result in the store.

    Raises
    ------
    InputError
        When the store has no runs, or the fleet was not identified yet.
    """
    runs = runs_of(store)
    found = residuals(store, runs, workers, progress)
    result = _with_alarms(_judged(runs, labels_of(store, runs), found, level), read_watched(store))
    store.write(FILE, (json.dumps(asdict(result), indent=1, allow_nan=False) + "\n").encode())
    return result


def residuals(
    store: Store, runs: dict[str, list[Kept]], workers: Workers, progress: Progress
) -> dict[str, Arrays | Failed]:
    """Give what :func:`gen.fleet.tasks.residuals.newest_against_models` gives of each motor with a model.

    Raises
    ------
    InputError
        When the fleet was not identified yet.
    """
    if not store.exists(COMMON):
        raise InputError("is missing; expected a fleet that gen fleet identify has seen", file=f"{store.url}/{COMMON}")
    mean = _hash(store.read(in_use(store, COMMON)))
    tasks = {
        motor: {"motor": motor, "runs": as_lists(runs[motor][-SHOWN:]), "models": [_hash(model), mean]}
        for motor, model in models_of(store, runs).items()
    }
    with workers_of(store, workers) as client:
        return computed(store, newest_against_models, tasks, client, progress)


def read_watched(store: Store) -> Watched | None:
    """Give what was found last, or None."""
    if not store.exists(FILE):
        return None
    try:
        said: dict[str, Any] = json.loads(store.read(FILE))
        motors = [State(**_tuples(each)) for each in said["motors"]]
        batches = tuple(Apart(**_tuples(each)) for each in said.get("batches", ()))
        for state in motors:
            checked_motor(state.motor)  # pages are named after it
        return Watched(tuple(motors), tuple(said["common"]), said["limit"], said["level"], batches)
    except (ValueError, TypeError, KeyError, InputError) as error:
        raise InputError(f"is not what gen fleet watch writes: {error}", file=f"{store.url}/{FILE}") from error


def _tuples(said: dict[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in said.items()}


def _with_alarms(now: Watched, before: Watched | None) -> Watched:
    """The same with each motor's last alarm, which may have been told another time."""
    older = {} if before is None else {state.motor: state.last_alarm for state in before.motors}
    made = []
    for state in now.motors:
        new = f"{state.days[-1]}: {state.state}" if state.state not in QUIET else older.get(state.motor, "")
        made.append(replace(state, last_alarm=new))
    return replace(now, motors=tuple(made))


def _judged(
    runs: dict[str, list[Kept]], labels: dict[str, Labels], found: dict[str, Arrays | Failed], level: float
) -> Watched:
    good = {motor: each for motor, each in found.items() if not isinstance(each, Failed)}
    fresh = [motor for motor, each in good.items() if not each["seen"]]
    enough = len(fresh) >= FEWEST
    states, common, limit = {}, [], None
    batches: tuple[Apart, ...] = ()
    if enough:
        names = [Hypothesis(*pair) for pair in json.loads(str(good[fresh[0]]["hypotheses"]))]
        groups = groups_of([labels[motor] for motor in fresh])
        learnt = np.array([int(good[motor]["learnt"]) for motor in fresh])
        own, mean = (
            judge([products_in(good[m], which) for m in fresh], learnt, groups, level) for which in ("own", "mean")
        )
        limit, batches = own.limit, _apart(names, fresh, own, mean)
        if own.common is not None:
            state = names[own.common.place].state(own.common.amount)
            common.append(f"missing in the model, as all motors show it: {state} {_words(names, own.common)}")
        for motor, mine, other in zip(fresh, own.own, mean.own, strict=True):
            states[motor] = _state(names, mine, other, explained=_explained(good[motor]["errors_K"]))
    made = []
    for motor in sorted(runs):
        each = found.get(motor)
        if each is None or isinstance(each, Failed):
            made.append(State(motor, "not enough data", "it has no model" if each is None else each.message))
            continue
        state, said = states.get(motor) or _alone(each, len(fresh))
        course = tuple(float(value) if np.isfinite(value) else None for value in each["errors_K"])
        days = tuple(run.day for run in runs[motor][-SHOWN:])
        made.append(State(motor, state, said, course[-1], course, days))
    made = [replace(each, labels=tuple(f"{k}={v}" for k, v in sorted(labels[each.motor].items()))) for each in made]
    return Watched(tuple(made), tuple(common), limit, level, batches)


def _alone(each: Arrays, fresh: int) -> tuple[str, str]:
    """What can be said of a motor that is not judged beside others: whether its own model still explains it."""
    if each["seen"]:
        return "not enough data", "its newest run taught its model"
    why = f"{fresh} motors have a newer run than their model; expected {FEWEST} at least"
    errors_K = each["errors_K"]
    if _explained(errors_K):
        return "not enough data", why
    before = float(np.median(_earlier(errors_K)))
    missed = f"its own model misses its newest run by {errors_K[-1]:.2g} K, those before by {before:.2g} K"
    return "differs from its model", f"{missed}; {why} to say where, and by how much a healthy one may"


def _apart(names: list[Hypothesis], motors: list[str], own: Judged, mean: Judged) -> tuple[Apart, ...]:
    """Each batch once: as a change since it was identified, else as it is beside the fleet."""
    said = {batch.group.labels for batch in own.batches}
    found = [(batch, True) for batch in own.batches]
    found += [(batch, False) for batch in mean.batches if batch.group.labels not in said]
    made = []
    for batch, changed in found:
        inside = tuple(motor for motor, there in zip(motors, batch.group.motors, strict=True) if there)
        words = f"{names[batch.finding.place].state(batch.finding.amount)} {_words(names, batch.finding)}"
        when = "together since they were identified" if changed else "together beside the fleet, as identified"
        labels = batch.group.labels
        made.append(Apart(labels, inside, f"{', '.join(labels)}: {len(inside)} motors, {when}: {words}", changed))
    return tuple(made)


def _state(names: list[Hypothesis], own: Finding | None, mean: Finding | None, *, explained: bool) -> tuple[str, str]:
    if own is not None:
        return names[own.place].state(own.amount), f"{_words(names, own)}"
    if mean is not None:
        state, words = names[mean.place].state(mean.amount), _words(names, mean)
        return ("differs from its fleet", f"{state} {words}") if explained else (state, f"{words} beside its fleet")
    return "ok", ""


def _explained(errors_K: FloatArray) -> bool:
    """Whether a motor's own model says its newest run about as well as those before, to which it was fitted."""
    before = _earlier(errors_K)
    return bool(before.size == 0 or errors_K[-1] <= max(GROWN * float(np.median(before)), LEAST_K))


def _earlier(errors_K: FloatArray) -> FloatArray:
    """Errors of the runs before the newest, of those that could be read."""
    return np.asarray(errors_K[:-1][np.isfinite(errors_K[:-1])])


def _words(names: list[Hypothesis], finding: Finding) -> str:
    said = names[finding.place].said(finding.amount, finding.explained_K)
    return f"{said} ({finding.score:+.1f} standard deviations)"


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
