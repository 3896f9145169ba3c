"""How far a model moves while a sound thermocouple without any noise gives one and the same count.

    python -m benchmarks.frozen_counts [--plants 6] [--seed 1400] [--model network]

Motors of independent physics (:mod:`benchmarks.plants`), identified from five cold steps; the two test runs of 4 h each
as their sensed parts truly were, in counts of 0.25 K, beside what the model says. A count that stays while the model
moves on is what `stuck_K` and `stuck_s` (docs/device.md) call frozen, so what is printed is what they have to exceed.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

import gen
from benchmarks.network_identification.judge import identified
from benchmarks.plants.cases import Case, fresh_runs, write_case
from gen.lowering.sensors import STUCK_K, STUCK_S

FloatArray = NDArray[np.float64]
COUNT_K = 0.25
SAMPLE_S = 0.25


@dataclass(frozen=True)
class Stay:
    """One count that stayed: where, for how long in s, and how far the model moved meanwhile, K."""

    place: str
    stayed_s: float
    moved_K: float


def stays(place: str, time_s: FloatArray, true_degC: FloatArray, model_degC: FloatArray) -> Iterator[Stay]:
    """Give every time for which the count stayed."""
    sample = np.arange(time_s[0], time_s[-1], SAMPLE_S)
    counts = np.floor(np.interp(sample, time_s, true_degC) / COUNT_K)
    model = np.interp(sample, time_s, model_degC)
    edges = [0, *(np.flatnonzero(np.diff(counts)) + 1).tolist(), sample.size]
    for first, last in pairwise(edges):
        moved = float(np.abs(model[first:last] - model[first]).max())
        yield Stay(place, (last - first) * SAMPLE_S, moved)


def stays_of(seed: int, kind: str) -> tuple[list[Stay], float]:
    """Give those of one motor, and its sensors' hours."""
    found: list[Stay] = []
    case, hours = Case.parse(f"{seed}:steps:held"), 0.0
    with tempfile.TemporaryDirectory() as folder:
        written = write_case(case, Path(folder))
        model = identified(written.fit, kind).model
        for path, measured in zip(written.test, fresh_runs(written.bench, case.room), strict=True):
            simulated, run = gen.simulate(model, path), measured.run
            for node in written.bench.plant.sensed:
                name = written.bench.plant.names[node]
                if name in model.components:
                    said = simulated[f"{name}_degC"].reindex(run.time).to_numpy(dtype=np.float64)
                    found += stays(f"{seed} {name} {path.stem}", run.time, run.temperature[:, node], said)
                    hours += float(run.time[-1] - run.time[0]) / 3600.0
    return found, hours


def main() -> None:
    """Print the largest."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plants", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1400, help="of the first plant")
    parser.add_argument("--model", choices=("parts", "network"), default="network")
    options = parser.parse_args()
    found: list[Stay] = []
    hours = 0.0
    for seed in range(options.seed, options.seed + options.plants):
        of_one, its_hours = stays_of(seed, options.model)
        found += of_one
        hours += its_hours
    worst = sorted(found, key=lambda stay: -stay.moved_K)[:5]
    frozen = sum(stay.moved_K > STUCK_K and stay.stayed_s >= STUCK_S for stay in found)
    print(f"{hours:.0f} h of sound thermocouples: {frozen} taken for frozen ({STUCK_S:g} s, {STUCK_K:g} K)")
    for stay in worst:
        print(f"  the model moved {stay.moved_K:.2f} K in {stay.stayed_s:.0f} s of one count: {stay.place}")


if __name__ == "__main__":
    main()
