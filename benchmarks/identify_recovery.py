"""Recovery: random plants, their runs through a noisy, quantised, biased sensor, and what `gen identify` makes of them.

Run:  python -m benchmarks.identify_recovery [COUNT]
"""

from __future__ import annotations

import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from benchmarks.scheduled_plants import AMBIENT, QUANTUM, Plant, fresh_profile, random_plant, simulate, step_runs
from gen.coefficients import Coefficients
from gen.identification.logs.data import make_data
from gen.identification.logs.sources import Source
from gen.identification.parts.coefficient_file import coefficient_text
from gen.identification.parts.identify import Identified, identify
from gen.identification.settings import Settings
from gen.model import ExactSolution


@dataclass(frozen=True)
class Trial:
    """What came out of one plant.

    Attributes
    ----------
    order, found
        True and chosen order.
    floor_K
        Standard deviation of one reading: noise and quantiser.
    known_K, any_K
        Root mean square error of the predicted temperature on fresh profiles, at the identified speeds and at any, K.
    inside
        Of each 95 % interval (time constants, steady rises) whether it holds the true value; empty with a wrong order.
    seconds
        Time taken.
    """

    order: int
    found: int
    floor_K: float
    known_K: float
    any_K: float
    inside: dict[str, list[bool]]
    seconds: float


def trial(seed: int) -> Trial:
    """Make a plant from a seed, identify it and compare."""
    rng = np.random.default_rng([20261, seed])
    plant = random_plant(rng)
    runs = step_runs(plant, rng)
    begin = time.perf_counter()
    data = make_data([Source(f"run{i}.csv", run) for i, run in enumerate(runs)], None)
    found = identify(data, lambda _: None)["part"]
    _, loaded = coefficient_text(data, {"part": found}, Settings("plant"))
    seconds = time.perf_counter() - begin
    errors = {known: _error(plant, loaded, rng, known=known) for known in (True, False)}
    return Trial(
        plant.order,
        found.choice.chosen.structure.order,
        float(np.hypot(plant.noise, QUANTUM / np.sqrt(12.0))),
        errors[True],
        errors[False],
        coverage(plant, found),
        seconds,
    )


def _error(plant: Plant, loaded: Coefficients, rng: np.random.Generator, *, known: bool) -> float:
    pwm = fresh_profile(rng, known=known)
    rise = ExactSolution(loaded.model).simulate_times(np.arange(len(pwm)), pwm)["part"]
    return float(np.sqrt(np.mean((AMBIENT + rise - simulate(plant, pwm)) ** 2)))


def coverage(plant: Plant, found: Identified) -> dict[str, list[bool]]:
    """Say of each interval whether it holds the true value."""
    inside: dict[str, list[bool]] = {"time constants": [], "steady rise": []}
    layout = found.fit.layout
    if layout.structure.pair or layout.order != plant.order:
        return inside
    width = found.spread.factor * found.spread.deviation
    theta = layout.structure.sorted(found.fit.theta)
    for i, node in enumerate(layout.nodes.tolist()):
        for k in range(plant.order):
            gap = abs(theta[i, k] - np.log(plant.tau[node, k]))
            inside["time constants"].append(bool(gap <= width[i * layout.order + k]))
    for i, node in enumerate(layout.positive.tolist()):
        gap = abs(found.fit.steady[i] - plant.steady[node])
        inside["steady rise"].append(bool(gap <= width[layout.thetas + i]))
    return inside


def report(trials: list[Trial]) -> str:
    """Write the table."""
    lines = ["order  plants  right order  error / floor at known speeds  at any speed  (median, 95th percentile)"]
    for order in (1, 2, 3, 0):
        mine = [t for t in trials if order in (0, t.order)]
        if mine:
            right = np.mean([t.order == t.found for t in mine])
            known = np.percentile([t.known_K / t.floor_K for t in mine], [50, 95])
            free = np.percentile([t.any_K / t.floor_K for t in mine], [50, 95])
            lines.append(
                f"{order or 'all':>5}  {len(mine):6d}  {right:11.1%}  "
                f"{known[0]:21.2f}, {known[1]:6.2f}  {free[0]:6.2f}, {free[1]:5.2f}"
            )
    for what in ("time constants", "steady rise"):
        hits = [hit for t in trials for hit in t.inside[what]]
        lines.append(f"95 % intervals of {what}: {np.mean(hits):.1%} of {len(hits)} hold the true value")
    lines.append(
        f"error in K: median {np.median([t.known_K for t in trials]):.3f} at known speeds, "
        f"{np.median([t.any_K for t in trials]):.3f} at any; noise floor {np.median([t.floor_K for t in trials]):.3f}"
    )
    lines.append(f"{np.mean([t.seconds for t in trials]):.1f} s a plant")
    return "\n".join(lines)


def main() -> None:
    """Print the table for 200 plants, or as many as asked for."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    trials: list[Trial] = []
    with ProcessPoolExecutor() as pool:
        for one in pool.map(trial, range(count)):
            trials.append(one)
            if sys.stderr.isatty():
                print(f"\r{len(trials)}/{count}", end="", file=sys.stderr)
    print(report(trials))


if __name__ == "__main__":
    main()
