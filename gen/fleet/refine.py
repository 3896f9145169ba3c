"""What all motors of a fleet show, and their models lack: an effect of the catalogue that predicts their left-out data.

Each candidate is put on some motors' networks, beside their newer runs; what promises most to most of them is held
against what was left out. An effect is in common when it predicts what was left out better in so many
motors, and by so much, that it is no chance (tests by mean and by rank over motors, Bonferroni). Its numbers are the
fleet's, pooled by empirical Bayes, and the same in each motor's file: no motor's own runs teach its model, so that what
one motor shows alone is still seen, and not learnt.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.coefficients import Coefficients
from gen.errors import CheckFailed, InputError
from gen.fleet.chosen import evenly
from gen.fleet.folder.models import COMMON, identified_paths, model_path, read_model, refined_path, sound
from gen.fleet.folder.store import Kept, Store
from gen.fleet.identify import runs_of
from gen.fleet.statistics.pooling import Pool, Told, pooled
from gen.fleet.statistics.shared_effects import Key, said, together, with_means
from gen.fleet.tasks.effect_tasks import compared, errors_with, numbers_told, promised
from gen.fleet.tasks.residuals import learnt_by
from gen.fleet.tasks.scouting import as_lists
from gen.fleet.tasks.work import Arrays, Failed, Progress, Workers, computed, workers_of
from gen.refinement.gains import LEAST_GAIN, LEVEL, p_of_gains
from gen.refinement.network.effects import Offered
from gen.refinement.network.tracing.paths import MOST_EFFECTS
from gen.refinement.network.tracing.search import LEAST_GAIN_BESIDE

FEWEST = 6
"""Motors that are needed to tell what is in common: fewer say no p-value that is small enough."""
MOST_KEYS = 5
"""Candidates that are held against what was left out in one search."""
OF_EACH = 2
"""Of one name."""
FAR = 5.0
"""Scaled median deviations from the median beyond which a motor's numbers are its own, and no part of the mean."""
SAME = 1e-3
"""What numbers of like motors differ by at least, in standard deviations of their priors."""


@dataclass(frozen=True)
class Common:
    """An effect that all motors show.

    Attributes
    ----------
    key
        Which.
    motors
        That were asked.
    better
        In how many of them it predicts what was left out better.
    gain
        Share of the left-out error that it takes away, in the median.
    p_value
        That this is chance.
    """

    key: Key
    motors: int
    better: int
    gain: float
    p_value: float

    @property
    def said(self) -> str:
        """In words."""
        return (
            f"{said(self.key)}: {self.better} of {self.motors} motors predict what was left out better with it, by "
            f"{self.gain:.0%} in the median (p = {self.p_value:.1g})"
        )


@dataclass(frozen=True)
class RefinedFleet:
    """What came out.

    Attributes
    ----------
    common
        What all motors show, in the order in which it was found.
    error_K
        By motor with newer runs, root mean square error on them, before and after.
    refined
        Motors whose files have what was found.
    refused
        By motor, why its file is not refined, or why it took no part.
    """

    common: tuple[Common, ...]
    error_K: dict[str, tuple[float, float]]
    refined: tuple[str, ...]
    refused: dict[str, str]


def refine_fleet(store: Store, scouts: int, workers: Workers, progress: Progress) -> RefinedFleet:
    """Find what all motors show, and write it into their coefficient files.

    Parameters
    ----------
    store, workers, progress
        As of :func:`gen.fleet.identify.identify_fleet`.
    scouts
        Motors on which it is searched.

    Raises
    ------
    InputError
        When the store has no runs, the fleet was not identified yet, or the mean's file is broken.
    CheckFailed
        When too few motors have a newer run than their model.
    """
    runs = runs_of(store)
    paths = identified_paths(store, runs)
    if not paths or not store.exists(COMMON):
        raise InputError("no motor has a model; expected a fleet that gen fleet identify has seen", file=store.url)
    read_model(store, COMMON)
    models, broken = sound(store, paths)
    newer = {motor: _newer(model.coefficients, runs[motor]) for motor, model in models.items()}
    newer = {motor: own for motor, own in newer.items() if own}
    if len(newer) < FEWEST:
        raise CheckFailed(
            f"{len(newer)} motor(s) have a newer run than their model; expected {FEWEST} at least: "
            "identify with --until, and add newer runs"
        )
    tasks = {
        motor: {"motor": motor, "runs": as_lists(own), "model": models[motor].hash} for motor, own in newer.items()
    }
    chosen = evenly(sorted(newer), max(scouts, FEWEST))
    with workers_of(store, workers) as client:
        fleet = _Fleet(store, tasks, client, progress)
        common, offered, refused = fleet.search(chosen)
        keys = [one.key for one in common]
        if not keys:
            _written(store, {}, sorted(paths))  # what was found another time is not found now
            return RefinedFleet(tuple(common), {}, (), {**broken, **refused})
        mean, silent = fleet.numbers(keys, offered)
        errors = fleet.errors(keys, offered, mean)
    made, wrong = {COMMON: with_means(store.read(COMMON).decode(), keys, mean, offered)}, {}
    for motor, model in models.items():
        try:
            made[model_path(motor)] = with_means(model.text, keys, mean, offered)
        except (CheckFailed, InputError) as error:
            wrong[motor] = str(error)
    _written(store, made, sorted(paths))
    refined = tuple(motor for motor in paths if model_path(motor) in made)
    return RefinedFleet(tuple(common), errors, refined, {**broken, **refused, **silent, **wrong})


@dataclass(frozen=True, eq=False)
class _Fleet:
    """Motors with newer runs: the arguments that all of their tasks have."""

    store: Store
    tasks: Mapping[str, Mapping[str, Any]]
    client: Any
    progress: Progress

    def of(self, motors: Sequence[str], **more: Any) -> dict[str, dict[str, Any]]:  # noqa: ANN401
        return {motor: {**self.tasks[motor], **more} for motor in motors}

    def search(self, motors: Sequence[str]) -> tuple[list[Common], Offered, dict[str, str]]:
        """Find one effect after the other; what motors' runs have, and who cannot be searched."""
        common: list[Common] = []
        while True:
            keys = [one.key for one in common]
            answers = computed(self.store, promised, self.of(motors, found=keys), self.client, self.progress)
            good = [each for each in answers.values() if not isinstance(each, Failed)]
            refused = {motor: each.message for motor, each in answers.items() if isinstance(each, Failed)}
            if len(good) < FEWEST:
                reasons = "; ".join(sorted(set(refused.values()))[:3])
                raise CheckFailed(f"{len(good)} motor(s) can be searched; expected {FEWEST} at least: {reasons}")
            asked = _promising(good, keys) if len(common) < MOST_EFFECTS else []
            best = self._best(motors, keys, asked) if asked else None
            if best is None:
                break
            common.append(best)
        return common, together([Offered(**json.loads(str(each["offered"]))) for each in good]), refused

    def _best(self, motors: Sequence[str], found: list[Key], asked: list[Key]) -> Common | None:
        """The effect that predicts most of what was left out, of those that do so by more than chance."""
        more = {"found": found, "keys": asked}
        answers = computed(self.store, compared, self.of(motors, **more), self.client, self.progress)
        good = [each for each in answers.values() if not isinstance(each, Failed)]
        gains = np.array([np.log(each["without_K"] / each["with_K"]) for each in good])
        least = -np.log(1.0 - (LEAST_GAIN_BESIDE if found else LEAST_GAIN))
        best = None
        for key, own in zip(asked, gains.T, strict=True):
            told = own[np.isfinite(own)]
            if told.size < FEWEST:
                continue
            p, median = p_of_gains(told), float(np.median(told))
            if p > LEVEL / len(asked) or median < least:
                continue
            made = Common(key, told.size, int(np.sum(told > 0.0)), 1.0 - float(np.exp(-median)), p)
            best = made if best is None or made.gain > best.gain else best
        return best

    def numbers(self, keys: list[Key], offered: Offered) -> tuple[FloatArray, dict[str, str]]:
        """Give the fleet's numbers in standard deviations of each number's prior, and who says nothing of them."""
        asked = self.of(sorted(self.tasks), found=keys, offered=_plain(offered))
        answers = computed(self.store, numbers_told, asked, self.client, self.progress)
        good = [each for each in answers.values() if not isinstance(each, Failed)]
        if not good:
            raise CheckFailed("no motor's runs say how large what was found is")
        told = Told(np.array([each["matrix"] for each in good]), np.array([each["vector"] for each in good]))
        size = told.vector.shape[1]
        first, none = Pool(np.zeros(size), np.ones(size)), np.zeros(size, dtype=np.bool_)
        pool = pooled(told, first, none)
        alike = _alike(told, pool)
        if 2 * int(alike.sum()) > len(good):
            pool = pooled(Told(told.matrix[alike], told.vector[alike]), first, none)
        return pool.mean, {motor: each.message for motor, each in answers.items() if isinstance(each, Failed)}

    def errors(self, keys: list[Key], offered: Offered, mean: FloatArray) -> dict[str, tuple[float, float]]:
        """Give each motor's error on its newer runs without and with the effects, K."""
        asked = self.of(sorted(self.tasks), found=keys, offered=_plain(offered), mean=mean.tolist())
        answers = computed(self.store, errors_with, asked, self.client, self.progress)
        good = {motor: each for motor, each in answers.items() if not isinstance(each, Failed)}
        return {motor: (float(each["error_K"][0]), float(each["error_K"][1])) for motor, each in good.items()}


def _written(store: Store, made: Mapping[str, str], motors: Sequence[str]) -> None:
    """Put files in the place of those that were refined another time."""
    for path in (COMMON, *map(model_path, motors)):
        if path in made:
            store.write(refined_path(path), made[path].encode())
        else:
            store.remove(refined_path(path))


def _newer(model: Coefficients, runs: Sequence[Kept]) -> list[Kept]:
    """A motor's runs that did not teach its model."""
    seen = learnt_by(model)
    return [run for run in runs if f"{run.name}.parquet" not in seen]


def _promising(good: Sequence[Arrays], found: Sequence[Key]) -> list[Key]:
    """What promises most to the motor in the middle: one that is worn says nothing of the fleet."""
    gains = [json.loads(str(each["gains"])) for each in good]
    every = {name: float(np.median([own.get(name, 0.0) for own in gains])) for own in gains for name in own}
    best: list[Key] = []
    for name in sorted(every, key=lambda name: (-every[name], name)):
        key = json.loads(name)
        same = sum(other["what"] == key["what"] for other in best)
        if every[name] > 0.0 and key not in found and same < OF_EACH and len(best) < MOST_KEYS:
            best.append(key)
    return best


def _alike(told: Told, pool: Pool) -> BoolArray:
    """Motors whose numbers are near the middle of all, shape (M,)."""
    inverse = np.linalg.inv(told.matrix + np.diag(1.0 / pool.variance))
    numbers = np.einsum("mij,mj->mi", inverse, told.vector + pool.mean / pool.variance)
    away = np.abs(numbers - np.median(numbers, axis=0))
    scale = 1.4826 * np.median(away, axis=0) + SAME
    return np.asarray((away / scale).max(axis=1) < FAR)


def _plain(offered: Offered) -> dict[str, Any]:
    """As a task's arguments: pairs are lists there."""
    return {**asdict(offered), "ranges": {name: list(ends) for name, ends in offered.ranges.items()}}
