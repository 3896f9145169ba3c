"""Who stands in for `gen` where the judge of refinement is tested."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import gen
from benchmarks.network_refinement.judge import Judged, judge
from benchmarks.plants.planted.later import follow, log
from benchmarks.plants.planted.trial import Trial, Written

TRIAL = Trial(2, ("load_heating",), 2)
SMALL = 38
"""The seed of a bench with three nodes, each with a sensor."""


@dataclass
class Oracle:
    """A model that says what it is told to, as far as the judge asks."""

    components: tuple[str, ...]
    knows: bool

    def save(self, path: Path) -> None:
        path.write_text("{}", encoding="utf-8")


@dataclass
class Found:
    """What refinement gives, as far as the judge asks."""

    model: Oracle
    verdict: str = "explained"
    named: Sequence[tuple[str, tuple[str, ...]]] = ()
    warnings: tuple[str, ...] = ()
    told: float | None = None

    def effects(self) -> pd.DataFrame:
        rows: list[tuple[str, str, dict[str, float], list[str]]]
        rows = [("motor", name, {}, list(others)) for name, others in self.named]
        return pd.DataFrame(rows, columns=["component", "effect", "parameters", "lookalikes"])

    def details(self) -> dict[str, Any]:
        return {} if self.told is None else {"after": {"test": {"rmse_K": self.told}}}


@dataclass
class Answers:
    """What stands in for `gen`: a model that knows nothing of what was planted, and what refinement makes of it."""

    written: Written
    refined: Found | Exception | None = None
    calls: list[str] = field(default_factory=list)

    @property
    def names(self) -> tuple[str, ...]:
        plant = self.written.setting.bench.plant
        return tuple(plant.names[node] for node in plant.sensed)

    def identify(self, runs: Sequence[Path], *, name: str, model: str) -> Any:  # noqa: ANN401
        assert (name, model) == ("plant", "network")
        assert [path.stem for path in runs] == [
            *(f"step_{pwm}" for pwm in (51, 102, 153, 204, 255)),
            "mixed_1",
            "mixed_2",
        ]
        assert all(path.exists() for path in runs)
        self.calls.append("identify")

        @dataclass
        class Identified:
            model: Oracle

        return Identified(Oracle(self.names, knows=False))

    def load(self, path: Path) -> Oracle:
        assert path.exists()
        return Oracle(self.names, knows=False)

    def refine(self, model: Oracle, *, fit: Sequence[Path], test: Sequence[Path], accept_change: bool = False) -> Found:
        assert not model.knows
        assert (tuple(fit), tuple(test)) == (self.written.fit, self.written.test)
        self.calls.append("refine")
        if isinstance(self.refined, Exception):
            raise self.refined
        return self.refined or Found(model, "unexplained")

    def simulate(self, model: Oracle, path: Path) -> pd.DataFrame:
        """What the sensors would be at without noise: with all that was planted, or with nothing of it."""
        stand = self.written.setting.bench
        changes = [one.change for one in self.written.setting.planted] if model.knows else []
        rows_of = log(stand, [one.change for one in self.written.setting.planted], path.stem).rows
        seen = follow(stand, changes, path.stem, stand.row_s).seen[rows_of]
        time = gen.read_run(path).index
        return pd.DataFrame({f"{name}_degC": seen[:, i] for i, name in enumerate(self.names)}, index=time)


def answering(monkeypatch: pytest.MonkeyPatch, answers: Answers) -> None:
    for name in ("identify", "load", "refine", "simulate"):
        monkeypatch.setattr(gen, name, getattr(answers, name))


def judged(
    written: Written, monkeypatch: pytest.MonkeyPatch, folder: Path, refined: Found | Exception | None
) -> Judged:
    answering(monkeypatch, Answers(written, refined))
    return judge(written, folder, folder)


def perfect(written: Written, **more: Any) -> Found:  # noqa: ANN401
    oracle = Oracle(Answers(written).names, knows=True)
    return Found(oracle, named=[(name, ()) for name in TRIAL.names], told=written.floor_K, **more)


def made(case: str, named: Sequence[str] = (), **more: Any) -> Judged:  # noqa: ANN401
    trial = Trial.parse(case)
    effects = [{"component": "rotor", "effect": name, "parameters": {}, "lookalikes": []} for name in named]
    values: dict[str, Any] = {"before_K": 1.2, "after_K": 0.33, "told_K": 0.33, "verdict": "explained"} | more
    return Judged(case, trial.seed, list(trial.names), effects=effects, floor_K=0.3, **values)
