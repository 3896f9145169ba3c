"""What changes in many motors of a made fleet: batches that are found and called, and faults beside them; ageing.

Needs a fleet that `benchmarks.fleet` has identified and kept; identification does not see the last runs, so that they
can be made anew with a batch that differs in them, or with motors that have aged.

    python -m benchmarks.fleet --motors 100 --quick --alone 0 --store build/fleet
    python -m benchmarks.fleet_changes --motors 48 --store build/fleet
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.fleet import LAST, faults, gen
from benchmarks.made_fleet.draw import Made, fleet, ran
from gen.fleet.folder.labels import add_labels
from gen.fleet.folder.store import MODELS, RUNS, Store
from gen.fleet.identify import runs_of
from gen.fleet.statistics.batches import groups_of
from gen.fleet.statistics.judging import judge
from gen.fleet.tasks.residuals import products_in
from gen.fleet.tasks.work import Failed, Workers
from gen.fleet.watch import residuals

LEVEL = 0.01
SHIFTS_K = (0.0, 0.5, 1.0, 2.0)
SHARES = (0.1, 0.25, 0.5)
CHANGES = (
    ("a quarter of the motors have a sensor off by 1.5 K", 1.5, 1.0, 0.0),
    ("a quarter of the motors have 40 % more heat of one source", 0.0, 1.4, 0.0),
    ("every motor has up to 30 % more friction", 0.0, 1.0, 0.3),
)
"""What it is, then of the batch what a sensor is off by (K) and the factor on heat, and of all the most growth."""


def changed(store: Store, folder: Path, made: Made) -> None:
    """Watch the same fleet with other last runs, and print what is found."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(Path(store.url) / MODELS, folder / MODELS)
    place, motors = Store(str(folder)), fleet(made)
    for motor in motors:
        own = Path(RUNS) / f"motor={motor.name}"
        shutil.copytree(Path(store.url) / own, folder / own, ignore=shutil.ignore_patterns("day=2026-02-01"))
        add_labels(place, motor.name, motor.labels)
        place.add(motor.name, "2026-02-01", "last", ran(motor, LAST, last=True).run)
    gen("watch", place.url, "--jobs", "2")
    faults(place, motors)


def drawn(store: Store, labellings: int) -> None:
    """Print how often a batch is found that is drawn at random, with a sensor shifted in its residuals."""
    found = residuals(store, runs_of(store), Workers(), lambda _: None)
    fresh = [each for each in found.values() if not isinstance(each, Failed) and not each["seen"]]
    hypotheses = json.loads(str(fresh[0]["hypotheses"]))
    offsets = [place for place, (kind, _) in enumerate(hypotheses) if kind == "offset"]
    products = [products_in(each, "own") for each in fresh]
    learnt = np.array([int(each["learnt"]) for each in fresh])
    print(f"{len(products)} motors, {labellings} labellings each, level {LEVEL:g}")
    print("share  shift (K)  found  as that sensor's offset  off by (K)  another label called")
    for share in SHARES:
        for shift in SHIFTS_K:
            rng = np.random.default_rng([20286, round(100 * share), round(10 * shift)])
            hit, named, away, other = 0, 0, [], 0
            for _ in range(labellings):
                inside = np.zeros(len(products), dtype=np.bool_)
                inside[rng.permutation(len(products))[: round(share * len(products))]] = True
                place = int(rng.choice(offsets))
                labels = [
                    {"batch": "x" if there else str(rng.choice(["y", "z"])), "supplier": str(rng.choice(["A", "B"]))}
                    for there in inside
                ]
                shifted = [
                    replace(each, along=each.along + shift * there * each.gram[:, place])
                    for each, there in zip(products, inside, strict=True)
                ]
                judged = judge(shifted, learnt, groups_of(labels), LEVEL).batches
                mine = [batch.finding for batch in judged if "batch=x" in batch.group.labels]
                hit += bool(mine)
                other += len(judged) > len(mine)
                if mine and mine[0].place == place:
                    named += 1
                    away.append(abs(mine[0].amount - shift))
            middle = f"{np.median(away):.2f}" if away else "-"
            print(f"{share:<5g}  {shift:<9g}  {hit:<5}  {named:<23}  {middle:<10}  {other}", flush=True)


def main() -> None:
    """Read what is asked, and print."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fleet_changes",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--motors", type=int, required=True, help="of those that were kept, the first")
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--faulty", type=float, default=0.15)
    parser.add_argument("--store", type=Path, metavar="FOLDER", required=True, help="of benchmarks.fleet")
    parser.add_argument("--labellings", type=int, default=200)
    options = parser.parse_args()
    made = Made(options.motors, options.seed, options.faulty)
    store = Store(str(options.store / "two"))
    drawn(store, options.labellings)
    for said, sensor_K, heat, ageing in CHANGES:
        print(f"{said}:", flush=True)
        now = replace(made, batch_sensor_K=sensor_K, batch_heat=heat, ageing=ageing)
        changed(store, options.store / "changed", now)


if __name__ == "__main__":
    main()
