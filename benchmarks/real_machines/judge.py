"""One case: references and `gen` on the same runs, and their errors on the runs that took no part."""

from __future__ import annotations

import tempfile
import time
import traceback
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

import gen
from benchmarks.real_machines.logs.case import Case, FloatArray
from benchmarks.real_machines.references import Fitted, fitted
from gen.errors import CheckFailed, InputError
from gen.runs import Run, write_run

HELD = "value held"
REFERENCES = ("one node", "two rates", "hidden node")
NETWORK, PARTS, AUTO, REFINED = "network", "parts", "auto", "refined"

Predict = Callable[[Run, str], FloatArray]


@dataclass
class Answer:
    """What one model said of a case.

    Attributes
    ----------
    rmse_K
        Over all readings of the test runs, each run and part counting alike; NaN where there is no model.
    by_part
        The same for each part, K.
    seconds
        To make the model.
    said
        Its verdict, or why there is none.
    names
        Effects that were found.
    status
        ``ok``; ``refused`` in words; ``raised`` for anything else.
    warnings
        What was said beside.
    """

    rmse_K: float = float("nan")
    by_part: dict[str, float] = field(default_factory=dict)
    seconds: float = float("nan")
    said: str = ""
    names: list[str] = field(default_factory=list)
    status: str = "ok"
    warnings: list[str] = field(default_factory=list)


@dataclass
class Judged:
    """All answers of a case.

    Attributes
    ----------
    machine, what
        Which.
    answers
        By model.
    """

    machine: str
    what: str
    answers: dict[str, Answer]

    @property
    def best_K(self) -> float:
        """The smallest error of the hand-fitted references, K."""
        return min(self.answers[name].rmse_K for name in REFERENCES)

    @property
    def ratio(self) -> float:
        """The network's error over the best reference's; infinite for a refusal, unless holding a value beats all."""
        return self.over_best(NETWORK)

    def over_best(self, name: str) -> float:
        """The same of any answer."""
        own = self.answers[name].rmse_K
        if np.isfinite(own):
            return own / self.best_K
        return 1.0 if self.answers[HELD].rmse_K < self.best_K else float("inf")


def judge(
    case: Case, models: Collection[str], heat: Sequence[str] = (), drives: Literal["", "motor", "heater"] = ""
) -> Judged:
    """Fit and test everything on one case.

    Parameters
    ----------
    case
        The runs.
    models
        Which of `PARTS`, `AUTO` and `REFINED` to make beside the network.
    heat
        Columns that the network is told to take for heat.
    drives
        What `gen identify` is told that the input drives.
    """
    answers = {HELD: _scored(case, _held)}
    started = time.perf_counter()
    by_part = {part: fitted(list(case.fit.values()), part) for part in case.parts}
    seconds = time.perf_counter() - started
    for name in REFERENCES:
        answers[name] = _scored(case, _shown_by({part: each[name] for part, each in by_part.items()}))
        answers[name].seconds = seconds / len(REFERENCES)
    with tempfile.TemporaryDirectory(prefix="real-") as folder:
        fit, test = _written(case.fit, Path(folder) / "fit"), _written(case.test, Path(folder) / "test")
        answers[NETWORK], model = _identified(case, fit, test, NETWORK, heat=heat, drives=drives)
        for kind in (PARTS, AUTO):
            if kind in models:
                answers[kind], _ = _identified(case, fit, test, kind, drives=drives)
        if REFINED in models and model is not None:
            answers[REFINED] = _refined(case, model, fit, test)
    return Judged(case.machine, case.what, answers)


def _shown_by(fits: Mapping[str, Fitted]) -> Predict:
    """What references of one kind say of each part."""
    return lambda run, part: fits[part].predict(run, part)


def _held(run: Run, part: str) -> FloatArray:
    known = run.temps[part][np.isfinite(run.temps[part])]
    return np.full(run.time_s.size, known[0])


def _scored(case: Case, predict: Predict) -> Answer:
    squares: dict[str, list[float]] = {part: [] for part in case.parts}
    for run in case.test.values():
        for part in case.parts:
            if part in run.temps and np.isfinite(run.temps[part]).any():
                error = predict(run, part) - run.temps[part]
                squares[part].append(float(np.nanmean(error**2)))
    by_part = {part: float(np.sqrt(np.mean(of))) for part, of in squares.items()}
    return Answer(float(np.sqrt(np.mean([one for of in squares.values() for one in of]))), by_part)


def _written(runs: Mapping[str, Run], folder: Path) -> dict[str, Path]:
    folder.mkdir()
    paths = {name: folder / f"{name}.csv" for name in runs}
    for name, run in runs.items():
        write_run(paths[name], run)
    return paths


def _predicted(case: Case, model: gen.Model, test: Mapping[str, Path]) -> Answer:
    shown = {name: gen.simulate(model, path) for name, path in test.items()}
    name_of = {id(run): name for name, run in case.test.items()}

    def predict(run: Run, part: str) -> FloatArray:
        if f"{part}_degC" not in shown[name_of[id(run)]]:
            raise InputError(f"{part} is left out of the model")
        return np.asarray(shown[name_of[id(run)]][f"{part}_degC"].to_numpy(dtype=np.float64))

    return _scored(case, predict)


def _identified(
    case: Case, fit: Mapping[str, Path], test: Mapping[str, Path], kind: str, **told: object
) -> tuple[Answer, gen.Model | None]:
    return _tried(lambda: _identify(case, list(fit.values()), test, {"model": kind, **told}))


def _identify(
    case: Case, fit: Sequence[Path], test: Mapping[str, Path], settings: dict[str, Any]
) -> tuple[Answer, gen.Model]:
    started = time.perf_counter()
    found: gen.Identification | gen.NetworkIdentification = gen.identify(fit, name="machine", **settings)
    seconds = time.perf_counter() - started
    answer = _predicted(case, found.model, test)
    answer.seconds, answer.said = seconds, found.verdict
    if found.choice is not None:
        answer.names, answer.said = [found.choice.kind], found.choice.why
    answer.warnings = [_bare(warning) for warning in found.warnings]
    return answer, found.model


def _refined(case: Case, model: gen.Model, fit: Mapping[str, Path], test: Mapping[str, Path]) -> Answer:
    def work() -> tuple[Answer, gen.Model]:
        started = time.perf_counter()
        found = gen.refine(model, fit=list(fit.values()), test=list(test.values()))
        seconds = time.perf_counter() - started
        answer = _predicted(case, found.model, test)
        answer.seconds, answer.said = seconds, found.verdict

        answer.names = [str(effect["name"]) for effect in found.details()["effects"]]
        answer.warnings = [_bare(warning) for warning in found.warnings]
        return answer, found.model

    return _tried(work)[0]


def _tried(work: Callable[[], tuple[Answer, gen.Model]]) -> tuple[Answer, gen.Model | None]:
    started = time.perf_counter()
    try:
        return work()
    except (InputError, CheckFailed) as error:
        status, said = "refused", _bare(str(error))
    except Exception as error:  # any other is a defect, and counted: no case is dropped
        place = traceback.extract_tb(error.__traceback__)[-1]
        status, said = "raised", f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"
    return Answer(seconds=time.perf_counter() - started, status=status, said=said), None


def _bare(text: str) -> str:
    """Without the folder that files stood in for the while."""
    return " ".join(word.rsplit("/", 1)[-1] if "/real-" in word else word for word in text.split(" "))
