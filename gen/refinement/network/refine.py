"""`gen refine` on a network: effects are its terms, fitted together with all that its file leaves open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gen.coefficients import Coefficients, parse, with_network
from gen.coefficients.messages import building
from gen.errors import InputError
from gen.model.effects import registry
from gen.reference.simulate import simulate_run
from gen.refinement.admission import healthy
from gen.refinement.condense import check_apart, check_measured, read_measured
from gen.refinement.errors import Errors
from gen.refinement.network.ambient import MovingAmbient, moving_ambient
from gen.refinement.network.anchored import Anchored
from gen.refinement.network.changed import looks_like_a_change
from gen.refinement.network.data import make_data
from gen.refinement.network.effects import NetworkEffect
from gen.refinement.network.effects.base import WHOLE
from gen.refinement.network.effects.sensors import SensorEffect
from gen.refinement.network.fit import Fitted
from gen.refinement.network.folds import described
from gen.refinement.network.judged import LEVEL, p_better
from gen.refinement.network.trace import Considered, Step, Traced, trace
from gen.refinement.network.writer import NetworkWriter
from gen.refinement.refine import EXPLAINED, NOTHING, Verdict
from gen.refinement.run_errors import compared

INTERVAL = 1.96
GENERIC = "vary what drives the one while the other's drive is held, for two hours each"
AT_THE_SENSOR = "a matter of the sensor: no coefficient file of a network holds it, so mend or calibrate the sensor"


@dataclass(frozen=True, eq=False)
class NetworkRefinement:
    """All that a refinement found.

    Attributes
    ----------
    text
        The refined coefficient file.
    before, after
        Errors of the file and of the refined one: what `gen simulate` gives for each run.
    effects
        As the JSON summary has them.
    verdict
        "explained", "partly explained", "nothing missing" or "unexplained".
    refitted
        Whether numbers that the file had left open were fitted anew, with or without effects.
    traced
        For the report.
    warnings
        What to look at, one sentence each.
    """

    text: str
    before: Errors
    after: Errors
    effects: list[dict[str, Any]]
    verdict: Verdict
    refitted: bool
    traced: Traced
    warnings: list[str]

    @property
    def judged_on(self) -> str:
        """What was left out of the fits, in turn."""
        return described(self.traced.data.later)

    def summary(self) -> dict[str, Any]:
        """The JSON summary."""
        return {
            "before": self.before.summary(),
            "after": self.after.summary(),
            "effects": self.effects,
            "verdict": self.verdict,
            "judged_on": self.judged_on,
            "refitted": self.refitted,
            "left_out_rmse_K": {"without_effects": self.traced.null.score_K, "with": self.traced.final.score_K},
            "noise_floor_K": self.traced.null.noise_K,
            "considered": [_considered(step) for step in self.traced.steps],
            "warnings": self.warnings,
        }


def refine_network(
    coefficients: Coefficients,
    raw: str,
    fit_paths: Sequence[Path],
    test_paths: Sequence[Path],
    progress: Callable[[str], None],
    *,
    accept_change: bool = False,
) -> NetworkRefinement:
    """Trace the error of a network on the fit runs, extend it, and open the test runs once, at the end.

    Parameters
    ----------
    coefficients, raw
        The file, and its text.
    fit_paths, test_paths
        Run files; none may be in both.
    progress
        Called with what is being done.
    accept_change
        Write what looks like another motor, too.

    Raises
    ------
    InputError
        For files that are no runs, or with no admitted run to fit; for a network with convection or radiation.
    """
    network = coefficients.model.network
    assert network is not None
    for number, law in network.laws:
        kind = type(law).__name__.lower()
        raise InputError(f"gen refine knows no path with {kind} yet", place=f"$.network.paths[{number}].{kind}")
    check_apart(fit_paths, test_paths)
    for path in test_paths:
        progress(f"checking {path}")
        check_measured(coefficients, path)  # only whether it can be judged: its values stay unopened until the end
    runs = []
    for path in fit_paths:
        progress(f"reading {path}")
        runs.append((str(path), read_measured(coefficients, path)))
    runs, warnings = healthy(runs)
    data = make_data(coefficients, runs)
    shape = Anchored(network, coefficients.document.input.full_scale, data.columns)
    traced = trace(data, shape, progress)
    room = moving_ambient(coefficients, runs, data, traced.file)
    changes = {id(found): looks_like_a_change(found.effect, _values(found), data) for found in _added(traced)}
    warnings += [change for change in changes.values() if change]
    kept = [found for found in _added(traced) if accept_change or not changes[id(found)]]
    text, refitted, refused = _written(coefficients, raw, traced, [found.effect for found in kept], room)
    warnings += refused
    effects = [
        _entry(step, step.added, traced, changes[id(step.added)]) for step in traced.steps if step.added is not None
    ]
    if room is not None:
        effects.insert(0, _ambient_entry(room))
    kept_paths = [Path(name) for name, _ in runs]
    before = _errors(coefficients, kept_paths, test_paths, lambda path: progress(f"judging {path}"))
    after = before
    if text != raw:
        refined = parse(text.encode())
        after = _errors(refined, kept_paths, test_paths, lambda path: progress(f"judging {path} with what was found"))
    verdict = _verdict(traced, room is not None, changed=any(changes.values()))
    return NetworkRefinement(text, before, after, effects, verdict, refitted, traced, warnings)


def _added(traced: Traced) -> list[Considered]:
    return [step.added for step in traced.steps if step.added is not None]


def _values(found: Considered) -> tuple[float, ...]:
    fitted = found.judged.fitted
    return fitted.shape.values(fitted.vector)[-1]


def _verdict(traced: Traced, moving_room: bool, *, changed: bool) -> Verdict:
    """The verdict from what was left out of the fits alone."""
    worst = _worst_sensor(traced)
    if not _added(traced) and not moving_room:
        return "nothing missing" if max(traced.null.floors, worst) <= NOTHING else "unexplained"
    if traced.final.floors <= EXPLAINED and worst <= NOTHING and not changed:
        return "explained"
    return "partly explained"


def _worst_sensor(traced: Traced) -> float:
    """The largest left-out error of one sensor in its noise floors."""
    data, error = traced.data, traced.final.error
    cover = np.where(np.isfinite(error), data.inputs.covered, 0.0)
    square = np.sum(cover * np.nan_to_num(error) ** 2, axis=0) / np.maximum(cover.sum(axis=0), 1e-9)
    noise = np.maximum(np.mean([run.noise_K**2 for run in data.inputs.runs[: data.later]], axis=0), 0.05**2)
    return float(np.sqrt(np.max((square + noise) / noise)))


def _written(
    coefficients: Coefficients,
    raw: str,
    traced: Traced,
    effects: Sequence[NetworkEffect],
    room: MovingAmbient | None,
) -> tuple[str, bool, list[str]]:
    """The file with what was found, whether anything is new in it, and what it cannot hold."""
    null = traced.null
    final = traced.final.fitted
    document = coefficients.document
    assert document.network is not None
    channel = None if room is None else room.channel
    if not effects and (null.floors > NOTHING or not _file_is_worse(traced)):
        if room is None:
            return raw, False, []
        return with_network(raw, document.network, "refined: ambient", channel), False, []
    fitted = final if _added(traced) else null.fitted
    said = ", ".join(f"{effect.name} at {effect.component}" for effect in effects)
    for kept in (effects, ()):
        writer = NetworkWriter(document.network, document.input.full_scale, traced.data.offered.ranges)
        try:
            with building():
                fitted.shape.write(writer, fitted.vector, kept)
                text = with_network(raw, writer.entry, f"refined: {said if kept else 'no effect'}", channel)
            parse(text.encode())
        except InputError as error:
            if not kept:
                break
            refused = f"{said}: found, but a file with it is none that can be built ({error})"
            continue
        return text, True, [] if kept or not effects else [refused]
    return raw, False, [refused] if effects else []


def _file_is_worse(traced: Traced) -> bool:
    """Whether the file as it is predicts the runs worse than what was fitted predicts what was left out of it."""
    return p_better(traced.data, traced.file, traced.null) < LEVEL and (
        traced.null.score_K < 0.95 * traced.file.score_K
    )


def _ambient_entry(room: MovingAmbient) -> dict[str, Any]:
    """The measured ambient in the place of a fixed one, as the summary has it."""
    return {
        "name": "ambient",
        "component": WHOLE,
        "parameters": {"channel": room.channel},
        "evidence": {
            "left_out_rmse_K": {"before": room.fixed_K, "after": room.measured_K},
            "p_value": room.p_value,
            "level": LEVEL,
            "judged_on": "all later runs: nothing was fitted",
            "intervals_95": {},
            "lookalikes": [],
        },
    }


def _entry(step: Step, found: Considered, traced: Traced, change: str) -> dict[str, Any]:
    """One effect as the summary has it."""
    final = traced.final.fitted
    place = next(k for k, effect in enumerate(final.shape.effects) if effect is found.effect)
    values = final.shape.values(final.vector)[place]
    known = registry()[found.effect.name].lookalikes
    note = change or (
        AT_THE_SENSOR if isinstance(found.effect, SensorEffect) and not found.effect.held_by_the_file else ""
    )
    return {
        "name": found.effect.name,
        "component": found.effect.component,
        "parameters": {
            **found.effect.acts_by,
            **{number.name: value for number, value in zip(found.effect.numbers, values, strict=True)},
        },
        "evidence": {
            "left_out_rmse_K": {"before": step.without.score_K, "after": found.judged.score_K},
            "p_value": found.p_value,
            "level": LEVEL,
            "judged_on": described(traced.data.later),
            "intervals_95": _intervals(final, place),
            "lookalikes": [
                {
                    "name": other.effect.name,
                    "component": other.effect.component,
                    "left_out_rmse_K": other.judged.score_K,
                    "told_apart_by": known.get(other.effect.name, GENERIC),
                }
                for other in step.lookalikes
            ],
            **({"note": note} if note else {}),
        },
    }


def _intervals(fitted: Fitted, place: int) -> dict[str, list[float]]:
    """95 % intervals of an effect's numbers, from the last linearised problem."""
    matrix, _ = fitted.problem.assembled(fitted.fit.normal, fitted.vector)
    deviation = np.sqrt(np.maximum(np.diag(np.linalg.inv(matrix)), 0.0))
    made = {}
    effect, columns = fitted.shape.effects[place], fitted.shape.places[place].columns
    for number, column in zip(effect.numbers, columns.tolist(), strict=True):
        half = INTERVAL * float(deviation[column])
        ends = [number.value(float(fitted.vector[column]) + side * half) for side in (-1.0, 1.0)]
        made[number.name] = [max(ends[0], number.low), min(ends[1], number.high)]
    return made


def _considered(step: Step) -> dict[str, Any]:
    """What one search looked at."""
    return {
        "without_K": step.without.score_K,
        "candidates": [
            {
                "name": one.effect.name,
                "component": one.effect.component,
                "left_out_rmse_K": one.judged.score_K,
                "p_value": one.p_value,
                "against": list(one.reasons),
            }
            for one in step.considered
        ],
    }


def _errors(
    model: Coefficients, fit_paths: Sequence[Path], test_paths: Sequence[Path], say: Callable[[Path], None]
) -> Errors:
    """What `gen simulate` gives for each run, compared with what was measured."""
    errors = Errors()
    for paths, scores in ((fit_paths, errors.fit), (test_paths, errors.test)):
        for path in paths:
            say(path)
            run = read_measured(model, path)
            columns = simulate_run(model, run, "exact", "auto", str(path))
            shown = {name: np.asarray(columns[f"{name}_degC"], dtype=np.float64) for name in run.temps}
            scores[str(path)], errors.curves[str(path)] = compared(run, shown)
    return errors
