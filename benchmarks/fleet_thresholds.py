"""Alarm thresholds of a made fleet: false alarms and faults heard, with the fleet's healthy runs and without.

Needs a fleet that `benchmarks.fleet` has identified, watched and kept. Each motor gets thresholds from the one healthy
run that its model was not fitted to: alone, or with 40 runs of others (`gen fleet thresholds`). Both are given a fresh
healthy run of 4 h; motors with a fault that shows 1 K and more also a fresh run with it.

    python -m benchmarks.fleet --motors 1000 --faulty 0.05 --quick --alone 0 --store build/fleet
    python -m benchmarks.fleet_thresholds --motors 1000 --faulty 0.05 --store build/fleet
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.fleet import LAST, TEST, VISIBLE_K, alarms, gen, runs_before, shows_K
from benchmarks.made_fleet.draw import Made, Motor, fleet, ran
from gen.coefficients import Coefficients, parse
from gen.errors import CheckFailed, InputError
from gen.fleet.alarm_thresholds import FOLDER, with_thresholds
from gen.fleet.folder.models import Model, in_use, model_path, read_model, sound
from gen.fleet.folder.store import Store
from gen.reference.run_alarms import raised_s
from gen.reference.simulate import simulate_run
from gen.runs import Run
from gen.thresholds.healthy import compare

WORN = 21
"""Number of the fresh run with a fault."""
HOURS = 1000.0
"""Between two false alarms of rules that hold a rate."""


@dataclass(frozen=True)
class Heard:
    """One motor's alarms on a fresh run.

    Attributes
    ----------
    fault
        What is wrong with it there; nothing where it is healthy.
    alone, pooled
        Whether any alarm was raised; None where there are no thresholds.
    """

    fault: str
    alone: bool | None
    pooled: bool | None


def heard(coefficients: Coefficients | None, run: Run) -> bool | None:
    """Whether a file's rules raise an alarm on a run."""
    if coefficients is None:
        return None
    shown = simulate_run(coefficients, run, "exact", "auto", "fresh")
    model = {name: np.asarray(shown[f"{name}_degC"], dtype=np.float64) for name in coefficients.model.component_names}
    return bool(raised_s(coefficients, run, model))


def alone(store: Store, motor: Motor, rules: Path) -> Coefficients | None:
    """Thresholds from the motor's own healthy run; None where that does not give them."""
    model = next(iter(sound(store, {motor.name: in_use(store, model_path(motor.name))})[0].values()), None)
    return None if model is None else _from(model, ran(motor, LAST, last=False).run, rules)


def _from(model: Model, run: Run, rules: Path) -> Coefficients | None:
    try:
        return parse(with_thresholds(model, rules, HOURS, [compare(model.coefficients, run, "own")]).encode())
    except (InputError, CheckFailed):
        return None


def judged(store: Store, motors: Iterable[Motor], rules: Path) -> Iterable[Heard]:
    """Give each motor its fresh runs."""
    known = set(store.names(FOLDER))
    for motor in motors:
        path = f"motor={motor.name}.json"
        both = alone(store, motor, rules), read_model(store, f"{FOLDER}/{path}") if path in known else None
        fresh = [("", ran(motor, TEST, last=False).run)]
        if motor.truth and shows_K(motor) >= VISIBLE_K:
            fresh.append((motor.truth, ran(motor, WORN, last=True).run))
        for fault, run in fresh:
            yield Heard(fault, *(heard(one, run) for one in both))


def table(results: Sequence[Heard]) -> None:
    """Print counts."""
    kinds: Mapping[str, list[Heard]] = {
        "healthy, an alarm in 4 h": [one for one in results if not one.fault],
        "with a fault, an alarm in 4 h": [one for one in results if one.fault],
    }
    print("a fresh run                    own run alone  with 40 runs of others")
    for what, found in kinds.items():
        cells = []
        for answers in ([one.alone for one in found], [one.pooled for one in found]):
            known = [answer for answer in answers if answer is not None]
            cells.append(f"{sum(known)} of {len(known)}")
        print(f"{what:<29}  {cells[0]:<13}  {cells[1]}")


def main() -> None:
    """Derive, judge, print."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fleet_thresholds",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--motors", type=int, default=24)
    parser.add_argument("--seed", type=int, default=3, help="of the series")
    parser.add_argument("--faulty", type=float, default=0.15, help="share of motors")
    parser.add_argument("--judge", type=int, default=200, help="as many healthy motors with one run before, evenly")
    parser.add_argument("--store", type=Path, metavar="FOLDER", required=True, help="of benchmarks.fleet")
    options = parser.parse_args()
    motors = fleet(Made(options.motors, options.seed, options.faulty, 1.0))
    store = Store(str(options.store / "two"))
    rules = options.store / "rules.json"
    rules.write_text(json.dumps({"alarms": list(alarms(motors[0]))}))
    deriving = gen("thresholds", store.url, "--rules", str(rules), "--jobs", "2")
    print(f"thresholds in {deriving}", flush=True)
    once = [motor for number, motor in enumerate(motors) if runs_before(number) == 1]
    healthy = [motor for motor in once if not motor.truth]
    places = np.unique(np.linspace(0, len(healthy) - 1, min(options.judge, len(healthy))).round().astype(int))
    faulty = [motor for motor in once if motor.truth]
    table(list(judged(store, [*(healthy[place] for place in places), *faulty], rules)))


if __name__ == "__main__":
    main()
