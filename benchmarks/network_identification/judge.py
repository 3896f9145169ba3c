"""One case: identify from its files, predict its test runs, compare."""

from __future__ import annotations

import json
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import gen
from benchmarks.plants.cases import Bench, Case, Written
from benchmarks.plants.rooms import RoomKind
from gen.errors import CheckFailed, InputError

WINDOWS = 60
"""The declared error is that of means over this share of a run; where PWM changes, a new mean begins."""
LEAST_S = 30.0
"""Means over less than this are too noisy to hold a declared error against."""


@dataclass
class Held:
    """How many of some intervals hold what they should."""

    inside: int = 0
    of: int = 0

    def add(self, inside: bool) -> None:
        """Count one."""
        self.inside += int(inside)
        self.of += 1


@dataclass
class Judged:
    """What came out of a case.

    Parameters
    ----------
    case, model
        Which.
    status
        `ok`; `refused`, when it was said in words that nothing can be identified; `raised`, when anything else
        happened.
    message
        Why there is no model.
    floor_K, error_K
        Of single samples, over all sensed nodes that the model has and both test runs, K.
    by_run, by_node
        The same error in K by test run, and by sensed node.
    left_out
        Sensed nodes that the model lacks.
    declared
        Of the means over the test runs, how many are off by no more than the file declares (`provenance.error`).
    undeclared
        Means at a PWM for which the file declares nothing.
    true_rise, read_rise
        Of the 95 % intervals of steady rises, how many hold the true one, and the one that the biased sensors read.
    seconds
        That identification took.
    warnings
        What it said beside the model.
    chosen
        Of `auto`: which kind was taken, and why; else nothing.
    """

    case: str
    model: str
    status: str = "ok"
    message: str = ""
    floor_K: float = float("nan")
    error_K: float = float("nan")
    by_run: dict[str, float] = field(default_factory=dict)
    by_node: dict[str, float] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    nodes: int = 0
    declared: Held = field(default_factory=Held)
    undeclared: int = 0
    true_rise: Held = field(default_factory=Held)
    read_rise: Held = field(default_factory=Held)
    seconds: float = 0.0
    warnings: list[str] = field(default_factory=list)
    chosen: tuple[str, str] = ("", "")

    @property
    def floors(self) -> float:
        """The error in noise floors."""
        return self.error_K / self.floor_K

    @property
    def whole(self) -> bool:
        """Whether there is a model with every sensed node."""
        return self.status == "ok" and not self.left_out


def identified(runs: Sequence[Path], model: str) -> gen.Identification:
    """What the public function makes of run files."""
    settings: dict[str, Any] = {"model": model}
    found: gen.Identification = gen.identify(list(runs), name="plant", **settings)
    return found


def judge(written: Written, model: str, folder: Path) -> Judged:
    """Identify from a case's files and compare; the model is left in the folder."""
    stand = written.bench
    result = Judged(str(written.case), model, floor_K=written.floor_K, nodes=len(stand.plant.sensed))
    started = time.perf_counter()
    try:
        found = identified(written.fit, model)
        result.seconds = time.perf_counter() - started
        if found.choice is not None:
            result.chosen = found.choice.kind, found.choice.why.replace(f"{folder}/", "")
        found.model.save(folder / f"{model}.json")
        result.warnings = [warning.replace(f"{folder}/", "") for warning in found.warnings]
        _predict(found.model, written, result)
        _intervals(found, stand, result)
    except (InputError, CheckFailed) as error:
        result.status, result.message = "refused", str(error).replace(f"{folder}/", "")
    except Exception as error:  # any other is a defect, and counted: no case is dropped
        place = traceback.extract_tb(error.__traceback__)[-1]
        result.status, result.message = "raised", f"{type(error).__name__}: {error} ({place.name}:{place.lineno})"
    result.seconds = result.seconds or time.perf_counter() - started
    return result


def _predict(model: gen.Model, written: Written, result: Judged) -> None:
    """Errors on the test runs, and whether the declared ones hold."""
    bands = json.loads(model.text).get("provenance", {}).get("error", [])
    names = [written.bench.plant.names[node] for node in written.bench.plant.sensed]
    result.left_out = [name for name in names if name not in model.components]
    kept = [name for name in names if name in model.components]
    squares: dict[tuple[str, str], np.ndarray[Any, np.dtype[np.float64]]] = {}
    for path in written.test:
        run, simulated = gen.read_run(path), gen.simulate(model, path)
        for name in kept:
            error = (simulated[f"{name}_degC"] - run[f"{name}_degC"]).dropna()
            squares[path.stem, name] = error.to_numpy() ** 2
            _declared(error, run["pwm"], [band for band in bands if band["component"] == name], result)

    def rms(*chosen: tuple[str, str]) -> float:
        return float(np.sqrt(np.mean(np.concatenate([squares[key] for key in chosen]))))

    if kept:
        result.error_K = rms(*squares)
        result.by_run = {path.stem: rms(*((path.stem, name) for name in kept)) for path in written.test}
        result.by_node = {name: rms(*((path.stem, name) for path in written.test)) for name in kept}


def _declared(error: pd.Series[float], pwm: pd.Series[int], bands: Sequence[dict[str, Any]], result: Judged) -> None:
    """Hold means of model minus measured against what the file declares at their PWM."""
    time = pwm.index.to_numpy()
    row_s = float(np.median(np.diff(time)))
    window = np.floor((time - time[0]) / (time[-1] - time[0]) * WINDOWS).astype(np.int64)
    speed = pwm.abs().to_numpy()
    starts = np.flatnonzero((np.diff(window) != 0) | (np.diff(speed) != 0)) + 1
    for first, last in pairwise([0, *starts.tolist(), time.size]):
        inside = error.reindex(pwm.index[first:last]).dropna()
        if inside.size * row_s < LEAST_S:
            continue
        band = next((b for b in bands if b["pwm"][0] <= speed[first] <= b["pwm"][1]), None)
        if band is None:
            result.undeclared += 1
        else:
            low, high = band["model_minus_measured_K"]
            result.declared.add(low <= float(inside.mean()) <= high)


def _intervals(found: gen.Identification, stand: Bench, result: Judged) -> None:
    """Hold the intervals of the steady rises against the plant's own."""
    summary = found.summary()
    if not {"steady_rise_K_low", "steady_rise_K_high"} <= set(summary.columns):
        return
    plant = stand.plant
    sensors = {plant.names[node]: (node, sensor.bias) for node, sensor in zip(plant.sensed, stand.sensors, strict=True)}
    room = stand.thermometer.bias if Case.parse(result.case).room is not RoomKind.UNMEASURED else 0.0
    for row in summary.reset_index().to_dict("records"):
        name, pwm = str(row["component"]), int(row["pwm"])
        low, high = float(row["steady_rise_K_low"]), float(row["steady_rise_K_high"])
        if name in sensors and pwm and low <= high:
            node, bias = sensors[name]
            rise = float(plant.steady(pwm, stand.usual)[node]) - stand.usual
            result.true_rise.add(low <= rise <= high)
            result.read_rise.add(low <= rise + bias - room <= high)
