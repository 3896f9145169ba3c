"""One trial: identify before, refine with what came later, and compare with what was planted."""

from __future__ import annotations

import fcntl
import re
import tempfile
import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import gen
from benchmarks.plants.plant import Plant
from benchmarks.plants.planted.trial import Setting, Trial, Written, write_identification
from gen.errors import CheckFailed, InputError

Kind = Literal["parts", "network"]
FAULT = re.compile(r"\b(faults?|faulty|healthy|worn|wear|wears|motor has changed)\b", re.IGNORECASE)
"""What a warning has that tells that the motor may not be what it was."""


@dataclass
class Judged:
    """What came out of a trial.

    Parameters
    ----------
    trial, bench
        Which, and the seed of the bench that it was on.
    planted
        Names of what was planted.
    truth
        What it is and how far it moves what the sensors are at, by name.
    status
        `ok`; `refused`, when refinement said in words that it cannot; `raised`, when anything else happened; `unseen`,
        when no bench shows the change; `no model`, when the motor could not be identified.
    message
        Why there is no result.
    verdict
        As refinement tells it.
    effects
        What it named, in its order: component, effect, parameters, lookalikes.
    floor_K, before_K, after_K
        Of single samples, over all sensed nodes that the model has and both test runs, K.
    before_by_run, after_by_run
        The same by test run.
    told_K
        What refinement says of the test runs after it, K.
    warnings
        What it said beside.
    pattern
        How what is left goes over time, as refinement tells it; empty where it was not asked.
    seconds
        That refinement took.
    became
        The kind of file that it left: `parts` or `network`.
    """

    trial: str
    bench: int = -1
    planted: list[str] = field(default_factory=list)
    truth: dict[str, Any] = field(default_factory=dict)
    status: str = "ok"
    message: str = ""
    verdict: str = ""
    effects: list[dict[str, Any]] = field(default_factory=list)
    floor_K: float = float("nan")
    before_K: float = float("nan")
    after_K: float = float("nan")
    before_by_run: dict[str, float] = field(default_factory=dict)
    after_by_run: dict[str, float] = field(default_factory=dict)
    told_K: float = float("nan")
    warnings: list[str] = field(default_factory=list)
    pattern: str = ""
    seconds: float = 0.0
    became: str = ""

    @property
    def fit_runs(self) -> int:
        """How many there were."""
        return Trial.parse(self.trial).fit_runs

    @property
    def named(self) -> list[str]:
        """What was named, each once, in order."""
        return list(dict.fromkeys(str(effect["effect"]) for effect in self.effects))

    @property
    def first(self) -> bool:
        """Whether the first name is of something that was planted; of nothing, whether nothing was named."""
        if self.status != "ok":
            return False
        return self.named[0] in self.planted if self.named and self.planted else not self.named and not self.planted

    @property
    def among(self) -> bool:
        """Whether all that was planted is among the names and their lookalikes."""
        said = {*self.named, *(name for effect in self.effects for name in effect["lookalikes"])}
        return self.status == "ok" and set(self.planted) <= said

    @property
    def false(self) -> list[str]:
        """Names of what was not planted."""
        return [name for name in self.named if name not in self.planted]

    @property
    def flagged(self) -> bool:
        """Whether it was said that the motor may be faulty."""
        said = [*self.warnings, self.verdict, self.message if self.status == "refused" else ""]
        return any(FAULT.search(line) for line in said)

    @property
    def placed(self) -> bool | None:
        """Whether the first name, if it is right, is where it was planted; None where no single place is right."""
        if not (self.first and self.named):
            return None
        places = self.truth.get(self.named[0], {}).get("where", [])
        return str(self.effects[0]["component"]) in places if places else None

    @property
    def before(self) -> float:
        """The error before, in noise floors."""
        return self.before_K / self.floor_K

    @property
    def after(self) -> float:
        """The error after, in noise floors."""
        return self.after_K / self.floor_K


def identified(made: Setting, models: Path, kind: Kind = "network") -> gen.Model:
    """The model of a bench before anything was changed; one that the folder has is not identified again.

    Raises
    ------
    InputError, CheckFailed
        If it cannot be identified.
    """
    models.mkdir(parents=True, exist_ok=True)
    of = "" if kind == "network" else f"-{kind}"
    kept = models / f"{made.bench.seed}-{'measured' if made.ambient_measured else 'held'}{of}.json"
    with kept.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # while one process identifies a motor, the other one waits for it
        if not kept.exists():
            with tempfile.TemporaryDirectory(prefix="plants-") as folder:
                runs = write_identification(made, Path(folder))
                gen.identify(list(runs), name="plant", model=kind).model.save(kept)
    return gen.load(kept)


def judge(
    written: Written, folder: Path, models: Path, kind: Kind = "network", *, accept_change: bool = False
) -> Judged:
    """Refine with a trial's files and compare; the models are left in the folder."""
    made = written.setting
    result = Judged(
        str(written.trial), made.bench.seed, [one.name for one in made.planted], truth(made), floor_K=written.floor_K
    )
    try:
        model = identified(made, models, kind)
    except Exception as error:  # of identification, which is judged elsewhere; the trial still counts
        result.status, result.message = "no model", f"{type(error).__name__}: {error}".replace(f"{models}/", "")
        return result
    model.save(folder / "identified.json")
    started = time.perf_counter()
    try:
        result.before_K, result.before_by_run = errors(model, written)
        started = time.perf_counter()
        found = gen.refine(model, fit=list(written.fit), test=list(written.test), accept_change=accept_change)
        result.seconds = time.perf_counter() - started
        _told(found, result, folder)
        found.model.save(folder / "refined.json")
        result.became = "network" if "instead_of_parts" in found.details() else kind
        result.after_K, result.after_by_run = errors(found.model, written)
    except (InputError, CheckFailed) as error:
        result.status, result.message = "refused", str(error).replace(f"{folder}/", "").replace(f"{models}/", "")
    except Exception as error:  # any other is a defect, and counted: no trial is dropped
        place = traceback.extract_tb(error.__traceback__)[-1]
        result.status, result.message = "raised", f"{type(error).__name__}: {error} ({place.name}:{place.lineno})"
    result.seconds = result.seconds or time.perf_counter() - started
    return result


def truth(made: Setting) -> dict[str, Any]:
    """What was planted, as JSON has it; `where` has the nodes at which it is, if each of them has a sensor."""
    plant = made.bench.plant
    found: dict[str, Any] = {}
    for one in made.planted:
        nodes = _nodes(asdict(one.change), plant)
        where = [plant.names[node] for node in nodes] if set(nodes) <= set(plant.sensed) else []
        found[one.name] = {"parameters": asdict(one.change), "where": where, "sight": asdict(one.sight)}
    return found


def _nodes(parameters: Mapping[str, Any], plant: Plant) -> list[int]:
    """Nodes that a change names, itself or by its sources."""
    found = [parameters[key] for key in ("node", "first", "second") if key in parameters]
    sources = [*parameters.get("sources", ()), *(parameters[key] for key in ("source",) if key in parameters)]
    return list(dict.fromkeys([*found, *parameters.get("nodes", ()), *(plant.sources[i].node for i in sources)]))


def _told(found: gen.Refinement, result: Judged, folder: Path) -> None:
    """What refinement says."""
    result.verdict = found.verdict
    result.warnings = [warning.replace(f"{folder}/", "") for warning in found.warnings]
    columns = ["component", "effect", "parameters", "lookalikes"]
    result.effects = [
        {str(key): value for key, value in entry.items()} | {"lookalikes": [str(name) for name in entry["lookalikes"]]}
        for entry in found.effects()[columns].to_dict("records")
    ]
    result.pattern = str((found.details().get("missing_heat") or {}).get("pattern", ""))
    told = found.details().get("after", {}).get("test", {}).get("rmse_K")
    result.told_K = float("nan") if told is None else float(told)


def errors(model: gen.Model, written: Written) -> tuple[float, dict[str, float]]:
    """Root mean square of model minus read over the test runs' samples, and of each run, K."""
    names = [written.setting.bench.plant.names[node] for node in written.setting.bench.plant.sensed]
    kept = [name for name in names if name in model.components]
    squares: dict[str, NDArray[np.float64]] = {}
    for path in written.test:
        run, simulated = gen.read_run(path), gen.simulate(model, path)
        away = [(simulated[f"{name}_degC"] - run[f"{name}_degC"]).dropna().to_numpy() for name in kept]
        squares[path.stem] = np.concatenate(away) ** 2
    return _rms(list(squares.values())), {name: _rms([values]) for name, values in squares.items()}


def _rms(squares: Sequence[NDArray[np.float64]]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(squares))))
