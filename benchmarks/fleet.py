"""A made fleet: models after one run, faults found, motors per hour, a worker that is killed, memory.

One random motor of independent physics, and others that differ from it by 5 to 10 % in every parameter; sensors with
noise, bias, lag and steps of a quarter of a kelvin. Half of them have one run of 4 h, the others three. In their last
run some are worn or have a shifted sensor; `--effect` gives the winding of all of them more heat then.

    python -m benchmarks.fleet --motors 24
    python -m benchmarks.fleet --pool 1000
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from benchmarks.made_fleet.draw import Made, Motor, fleet, ran
from gen.coefficients import Coefficients, parse
from gen.errors import CheckFailed, InputError
from gen.fleet.folder.labels import add_labels
from gen.fleet.folder.models import COMMON, model_path
from gen.fleet.folder.store import MODELS, RUNS, TASKS, Store
from gen.fleet.statistics.pooling import Pool, Told, pooled
from gen.fleet.watch import QUIET, read_watched
from gen.identification.choice.models import Options, network_of
from gen.identification.logs.sources import Source
from gen.identification.settings import Settings
from gen.reference.simulate import simulate_run
from gen.runs import Run

UNTIL = "2026-01-31"
TEST, LAST = 20, 9
"""Numbers of the healthy run to test with, and of the last one."""
VISIBLE_K = 1.0
"""A fault that changes every sensor by less than this (root mean square over the run) is counted apart."""


def runs_before(number: int) -> int:
    """How many runs a motor has before its last one."""
    return 1 if number % 2 else 3


def filled(folder: Path, motors: list[Motor]) -> Store:
    """A store with all runs; of a store that is kept, what is missing is added."""
    store = Store(str(folder))
    for number, motor in enumerate(motors):
        add_labels(store, motor.name, motor.labels)
        if len(store.runs(motor.name)) > runs_before(number):
            continue
        for k in range(runs_before(number)):
            store.add(motor.name, f"2026-01-0{k + 1}", f"run{k}", ran(motor, k, last=False).run)
        store.add(motor.name, "2026-02-01", "last", ran(motor, LAST, last=True).run)
    return store


@dataclass(frozen=True)
class Took:
    """What a command took: time on the clock, and of all processors, s; others may be at work beside it."""

    clock_s: float
    processor_s: float

    def __str__(self) -> str:
        return f"{self.clock_s:.0f} s ({self.processor_s:.0f} s of processors)"


def gen(*arguments: str, kill: bool = False, shown: bool = False) -> Took:
    """Run a command, and give what it took; one of its workers is killed in the middle, if asked."""
    began, before_s = time.perf_counter(), processor_s()
    stdout = None if shown else subprocess.DEVNULL
    process = subprocess.Popen([sys.executable, "-m", "gen", "fleet", *arguments], stdout=stdout)
    if kill:
        _kill_one(process.pid, Path(arguments[1]) / TASKS)
    if process.wait():
        raise SystemExit(f"gen fleet {' '.join(arguments)} ended with {process.returncode}")
    return Took(time.perf_counter() - began, processor_s() - before_s)


def processor_s() -> float:
    """Of all commands so far and their workers."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _kill_one(pid: int, tasks: Path) -> None:
    """Kill the process that works hardest, in the middle of the first round of fits."""
    while len(list(tasks.glob("fitted_in_common-*"))) < 3:
        time.sleep(0.2)
    workers = psutil.Process(pid).children(recursive=True)
    busiest = max(workers, key=lambda worker: sum(worker.cpu_times()[:2]))
    busiest.kill()


@dataclass(frozen=True)
class Job:
    """One identification of the fleet: its store, its workers, and whether one of them is killed in the middle."""

    name: str
    workers: int
    kill: bool = False

    @property
    def said(self) -> str:
        """In words."""
        return f"{self.workers} workers, one killed in the middle" if self.kill else f"{self.workers} worker(s)"


def identify(place: Store, job: Job, motors: int) -> None:
    """Identify the fleet, and print what it took."""
    began = time.time()
    took = gen("identify", place.url, "--until", UNTIL, "--jobs", str(job.workers), kill=job.kill)
    form = scouting_s(place, began)
    models_s = took.clock_s - form
    rate = 3600.0 * motors / models_s
    print(f"{job.workers:<7}  {form:<8.0f}  {models_s:<10.0f}  {rate:<31.0f}  {took.processor_s:.0f}", flush=True)


def identifications(folder: Path, store: Store, motors: int, *, quick: bool) -> None:
    """Identify the fleet on two workers; and, unless it has to be quick, again on others, for the same files."""
    print("workers  form (s)  models (s)  motors per hour, the form apart  processors (s)", flush=True)
    identify(store, Job("two", 2), motors)
    for job in [] if quick else [Job("one", 1), Job("four", 4), Job("killed", 2, kill=True)]:
        place = Store(str(folder / job.name))
        shutil.copytree(Path(store.url) / RUNS, Path(place.url) / RUNS)
        identify(place, job, motors)
        same = "the same" if models(place) == models(store) else "DIFFER"
        print(f"    {job.said}: {len(models(place))} files {same}", flush=True)


def scouting_s(store: Store, began: float) -> float:
    """How long the choice of the form took, s; nothing where a kept store has it."""
    return max(0.0, max(path.stat().st_mtime for path in (Path(store.url) / TASKS).glob("suits-*")) - began)


def models(store: Store) -> dict[str, bytes]:
    """Every coefficient file's bytes."""
    return {name: store.read(f"{MODELS}/{name}") for name in store.names(MODELS)}


def error_K(model: Coefficients, run: Run) -> float:
    """Root mean square error over all sensors, K."""
    shown = simulate_run(model, run, "exact", "auto", "test")
    squares = [np.nanmean((shown[f"{name}_degC"] - values) ** 2) for name, values in run.temps.items()]
    return float(np.sqrt(np.mean(squares)))


def alone(run: Run) -> Coefficients | None:
    """What gen identify makes of one run."""
    try:
        source = Source("run.csv", run)
        return network_of([source], Options(Settings("motor")), lambda _: None).coefficients
    except (InputError, CheckFailed):
        return None


def after_one_run(store: Store, motors: list[Motor], most_alone: int) -> None:
    """Print the errors on a run that took no part."""
    mean = parse(store.read(COMMON))
    rows: dict[str, list[float]] = {"alone": [], "pooled": [], "the fleet's mean": []}
    three: list[float] = []
    known = set(models(store))
    for number, motor in enumerate(motors):
        if Path(model_path(motor.name)).name not in known:
            print(f"  {motor.name}: no model")
            continue
        test = ran(motor, TEST, last=False)
        read = [
            test.run.temps[motor.plant.names[node]] - test.course.temperature[:, node] for node in motor.plant.sensed
        ]
        floor = float(np.sqrt(np.nanmean(np.concatenate(read) ** 2)))
        own = error_K(parse(store.read(model_path(motor.name))), test.run) / floor
        if runs_before(number) > 1:
            three.append(own)
            continue
        rows["pooled"].append(own)
        rows["the fleet's mean"].append(error_K(mean, test.run) / floor)
        if len(rows["alone"]) < most_alone:
            single = alone(ran(motor, 0, last=False).run)
            rows["alone"].append(np.inf if single is None else error_K(single, test.run) / floor)
    print("Error on a fresh run of 4 h, in noise floors            motors  median    90%  worst")
    for name, found in (*((f"one run, {name}", found) for name, found in rows.items()), ("three runs, pooled", three)):
        if not found:
            continue
        middle, high, most = np.quantile(found, [0.5, 0.9, 1.0])
        print(f"  {name:<52}  {len(found):>6}  {middle:>6.2f} {high:>6.2f} {most:>6.2f}")
    worse = sum(p > a for p, a in zip(rows["pooled"], rows["alone"], strict=False))
    print(f"  pooled is worse than alone: {worse} of {len(rows['alone'])}")


def shows_K(motor: Motor) -> float:
    """What a fault changes at the sensor that shows most of it, root mean square over the last run, K."""
    healthy = replace(motor, worn=motor.sound, shifted=motor.usual)
    away = ran(motor, LAST, last=True).course.temperature - ran(healthy, LAST, last=True).course.temperature
    by_heat = np.sqrt(np.mean(away[:, list(motor.plant.sensed)] ** 2, axis=0))
    by_sensor = [abs(shift - usual) for shift, usual in zip(motor.shifted, motor.usual, strict=True)]
    return float(max(by_heat.max(), max(by_sensor)))


def tally(store: Store, motors: list[Motor]) -> str:
    """Say how many faults were found, large and small, and how many healthy motors were called."""
    watched = read_watched(store)
    assert watched is not None
    called = {state.motor for state in watched.motors if state.state not in QUIET}
    seen = [motor for motor in motors if motor.truth and shows_K(motor) >= VISIBLE_K]
    small = [motor for motor in motors if motor.truth and shows_K(motor) < VISIBLE_K]
    healthy = [motor for motor in motors if not motor.truth]

    def found(some: list[Motor]) -> str:
        return f"{sum(motor.name in called for motor in some)} of {len(some)}"

    return f"{found(seen)} faults of {VISIBLE_K:g} K and more, {found(small)} smaller ones; false: {found(healthy)}"


def faults(store: Store, motors: list[Motor]) -> None:
    """Print which faults were found."""
    watched = read_watched(store)
    assert watched is not None
    states = {state.motor: state for state in watched.motors}
    for line in watched.common:
        print(f"in common: {line}")
    for batch in watched.batches:
        print(f"batch: {batch.said}")
    print(f"found: {tally(store, motors)} healthy motors")
    for motor in motors:
        state = states[motor.name]
        if motor.truth or state.state not in QUIET:
            print(f"  {motor.name}: {motor.truth or 'healthy'} ({shows_K(motor):.2f} K): {state.state} {state.said}")


def alarms(motor: Motor) -> Iterator[dict[str, Any]]:
    """Rules without thresholds: two kinds at each sensor."""
    for node in motor.plant.sensed:
        name = motor.plant.names[node]
        usual = {"component": name, "speed_percent": [10, 100], "settle_s": 600}
        yield {"name": f"{name}_hot", "kind": "above_model", "persistence_s": 60, **usual}
        yield {"name": f"{name}_slow", "kind": "cusum", **usual}


def pooling(motors: int, parameters: int) -> None:
    """Print what pooling alone costs, on normal matrices that are drawn."""
    rng = np.random.default_rng(0)
    truth = rng.normal(0.0, 0.08, (motors, parameters))
    matrix = np.empty((motors, parameters, parameters))
    for number in range(motors):
        root = rng.normal(0.0, 20.0, (parameters // 3, parameters))  # a run leaves two thirds of the directions open
        matrix[number] = root.T @ root
    vector = np.einsum("mij,mj->mi", matrix, truth)
    first = Pool(np.zeros(parameters), np.full(parameters, 0.09))
    began = time.perf_counter()
    found = pooled(Told(matrix, vector), first, np.zeros(parameters, dtype=np.bool_))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    spread = float(np.sqrt(np.median(found.variance)))
    print(
        f"pooling {motors} motors of {parameters} parameters: {time.perf_counter() - began:.0f} s, {peak:.0f} MB; "
        f"spread {spread:.3f}, in truth 0.080"
    )


@contextmanager
def place_of(kept: Path | None) -> Iterator[Path]:
    """A folder for the stores: one that stays, or one that goes."""
    if kept is not None:
        kept.mkdir(parents=True, exist_ok=True)
        yield kept
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


def largest_MB() -> float:
    """Of all processes of the commands so far, the most memory that one had."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0


def main() -> None:
    """Make the fleet, run the commands, print."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fleet", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--motors", type=int, default=24)
    parser.add_argument("--seed", type=int, default=3, help="of the series")
    parser.add_argument("--faulty", type=float, default=0.15, help="share of motors")
    parser.add_argument("--effect", type=float, default=1.0, help="factor on the heat of all windings in the last run")
    parser.add_argument("--alone", type=int, default=6, help="motors that are identified alone, too")
    parser.add_argument("--refine", action="store_true", help="and gen fleet refine, and watch again")
    parser.add_argument("--thresholds", action="store_true", help="and gen fleet thresholds, two rules a sensor")
    parser.add_argument("--store", type=Path, metavar="FOLDER", help="kept; again, the job goes on where it was")
    parser.add_argument("--quick", action="store_true", help="on two workers only, not on one and four, too")
    parser.add_argument("--pool", type=int, metavar="N", help="only what pooling N motors costs")
    options = parser.parse_args()
    if options.pool:
        pooling(options.pool, 150)
        return
    made = Made(options.motors, options.seed, options.faulty, options.effect)
    motors = fleet(made)
    if made.effect != 1.0 and not any(source.kind == "copper" for source in motors[0].plant.sources):
        raise SystemExit("this series has no copper loss")
    with place_of(options.store) as folder:
        began = time.perf_counter()
        store = filled(folder / "two", motors)
        print(f"{len(motors)} motors' runs made and added in {time.perf_counter() - began:.0f} s", flush=True)
        identifications(folder, store, len(motors), quick=options.quick)
        watching = gen("watch", store.url, "--jobs", "2")
        print(f"watched in {watching}; largest process {largest_MB():.0f} MB", flush=True)
        faults(store, motors)
        if options.refine:
            refining = gen("refine", store.url, "--jobs", "2", shown=True)
            gen("watch", store.url, "--jobs", "2")
            print(f"refined in {refining}, and watched again", flush=True)
            faults(store, motors)
        if options.thresholds:
            rules = folder / "rules.json"
            rules.write_text(json.dumps({"alarms": list(alarms(motors[0]))}))
            deriving = gen("thresholds", store.url, "--rules", str(rules), "--jobs", "2")
            print(f"thresholds in {deriving}; largest process {largest_MB():.0f} MB", flush=True)
        after_one_run(store, motors, options.alone)


if __name__ == "__main__":
    main()
