"""Make coeffs.json as one would for a motor of one's own: runs, `gen identify`, healthy runs, `gen thresholds`.

    python examples/my1016_rig/make.py [--folder RUNS] [--out COEFFS] [--network NETWORK] [--zeroed | --loaded]

And network.json, with `gen identify --model network`, of the same eight runs and four at changing speeds: a transfer
function wants speeds that are held, a network takes what there is, and only changes from speed to speed tell it what
hidden parts keep.

`--loaded`: the motor drives loads of up to 0.2 Nm that come and go, in all runs but those at one speed from cold, and
its current is measured. COEFFS is then a network that knows nothing of it, NETWORK one that it heats (`gen identify
--heat`), both with thresholds from the same healthy runs.

The motor is the simulated one (`gen.rig`) with one set of sensors, each off by up to 1.1 K. Eight runs from cold, three
hours at a speed and one at rest, identify the model. Fifty-two runs of three hours that took no part in it show what is
healthy: at eight speeds a cold and a warm start (an hour at 60 % before), each alone and with an ambient that swings
by 1 K to either side within two hours and up to 2 % of the rated torque as load; twelve more change speed every 15 to
45 minutes; eight have pauses of a minute, or a room that swings by 5 K and jumps by 4 K.
The final tables (`benchmarks/alarms_table.py`, `benchmarks.alarm_hours`) have other speeds, noise and ambients.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gen.rig import Profile, SensorConfig, Setup, make_run, sensors, warm_start, zeroed
from gen.rig.profiles import counts, cut_off, random_levels, step
from gen.rig.signals import Signal, sine, steps, total

HERE = Path(__file__).parent
SENSORS = 0
"""Seed of the sensors' offsets: they belong to the motor, and are the same in the table of alarms."""
CHANGING_IDENTIFIED = 4
IDENTIFIED = (10, 20, 25, 40, 55, 70, 85, 100)
CHANGING = 12
SURROUNDED = 4
RUN_S, PAUSE_S = 10_800.0, 60.0
LOAD_NM = 0.02
SWING_K, PERIOD_S = 1.0, 7200.0
ROOM_DEGC, ZERO_SEED = 24.0, 7
LOADED_NM = 0.2
CURRENT = "current_A"
BY_CURRENT = ("--heat", f"{CURRENT}^1", "--heat", f"{CURRENT}^2")
"""Brushes drop a voltage, copper has a resistance."""


@dataclass(frozen=True)
class Bench:
    """How the motor is fitted out.

    Attributes
    ----------
    sensors
        Its thermocouples.
    loaded
        Whether it drives loads, and its current is measured.
    """

    sensors: Mapping[str, SensorConfig]
    loaded: bool = False


def bench_of(*, has_learnt: bool, loaded: bool) -> Bench:
    """Give the motor's sensors, or as they are once the board has learnt their offsets."""
    own = sensors(SENSORS)
    return Bench(zeroed(own, ROOM_DEGC, ZERO_SEED) if has_learnt else own, loaded)


def loads(random: np.random.Generator, most_Nm: float) -> Signal:
    """Loads of up to so much that come and go: each for 10 to 45 minutes, three of ten a pause."""
    changes, at = [], float(random.uniform(0.0, 2700.0))
    while at < RUN_S:
        changes.append((at, float(random.uniform(0.0, most_Nm)) if random.random() < 0.7 else 0.0))
        at += float(random.uniform(600.0, 2700.0))
    return steps(0.0, changes)


def record(
    path: Path,
    profile: Profile,
    seed: int,
    bench: Bench,
    *,
    warm: bool = False,
    moving: bool = False,
    changing: bool = False,
    inputs: Mapping[str, Signal] | None = None,
) -> Path:
    """Make one run file of the healthy motor.

    Parameters
    ----------
    path, profile, seed, bench
        The file, what PWM acts, chance, and the motor.
    warm
        It has run for an hour.
    moving
        The ambient swings, and it drives a load.
    changing
        It drives loads, where the bench has any.
    inputs
        Of the bench over time, by their names in its setup.
    """
    random = np.random.default_rng(seed)
    setup = Setup(
        sensors=bench.sensors,
        seed=seed,
        start_degC=warm_start(step(counts(60), 3600.0)) if warm else {},
        ambient=sine(30.0, SWING_K, PERIOD_S, float(random.uniform(0.0, PERIOD_S))) if moving else 30.0,
        load_Nm=float(random.uniform(0.0, LOAD_NM)) if moving else 0.0,
        channels=("speed_rpm", CURRENT) if bench.loaded else ("speed_rpm",),
    )
    if bench.loaded and (moving or changing):
        setup = replace(setup, load_Nm=loads(random, LOADED_NM))
    setup = replace(setup, **(inputs or {}))  # type: ignore[arg-type]
    make_run(profile, setup).write(path)
    return path


def identification_runs(folder: Path, bench: Bench) -> list[Path]:
    """Steps from cold, then cooling."""
    return [
        record(folder / f"identify_{percent}.csv", cut_off(counts(percent), 10_800.0, 3600.0), 1000 + percent, bench)
        for percent in IDENTIFIED
    ]


def changing_runs(folder: Path, bench: Bench) -> list[Path]:
    """Speeds held for 10 to 45 minutes, for the network."""
    return [
        record(
            folder / f"identify_changing_{number}.csv",
            random_levels(seed, hold_s=(600.0, 2700.0)),
            seed,
            bench,
            changing=True,
        )
        for number in range(CHANGING_IDENTIFIED)
        for seed in (5000 + number,)
    ]


def healthy_runs(folder: Path, bench: Bench) -> list[Path]:
    """What a healthy motor does."""
    made = []
    for percent in IDENTIFIED:
        for warm in (False, True):
            for moving in (False, True):
                name = f"healthy_{percent}_{'warm' if warm else 'cold'}{'_moving' if moving else ''}.csv"
                seed = 2000 + 10 * percent + 2 * warm + moving
                made.append(record(folder / name, step(counts(percent)), seed, bench, warm=warm, moving=moving))
    for number in range(CHANGING):
        profile = random_levels(3000 + number, hold_s=(900.0, 2700.0))
        path, moving = folder / f"healthy_changing_{number}.csv", number % 2 == 1
        made.append(record(path, profile, 3000 + number, bench, moving=moving, changing=True))
    return made + surrounded_runs(folder, bench)


def surrounded_runs(folder: Path, bench: Bench) -> list[Path]:
    """What else is normal where the motor stands: pauses, and a room whose door opens."""
    made = []
    for number in range(SURROUNDED):
        random = np.random.default_rng(6000 + number)
        level, at = counts(float(random.uniform(15.0, 100.0))), float(random.uniform(2000.0, 6000.0))
        on, jump = float(random.uniform(300.0, 900.0)), 4.0 - 8.0 * (number % 2)
        begins = [k * (on + PAUSE_S) for k in range(int(RUN_S // (on + PAUSE_S)))]
        starts = tuple(start for begin in begins for start in (begin, begin + on))
        pauses = Profile(starts, tuple(level * (k % 2 == 0) for k in range(len(starts))), RUN_S)
        held = step(level, RUN_S)
        kinds: dict[str, tuple[Profile, dict[str, Signal]]] = {
            "pauses": (pauses, {}),
            "room": (
                held,
                {"ambient": total(sine(28.0, 2.5, PERIOD_S, at), steps(0.0, [(at, jump)]))},
            ),
        }
        for kind, (profile, inputs) in kinds.items():
            made.append(record(folder / f"healthy_{kind}_{number}.csv", profile, 6000 + number, bench, inputs=inputs))
    return made


def gen(*arguments: str | Path) -> None:
    """Run a command of the tool."""
    subprocess.run([sys.executable, "-m", "gen", *map(str, arguments)], check=True)


def main() -> None:
    """Make the runs and the coefficient file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, help="keep the runs here")
    parser.add_argument("--out", type=Path, default=HERE / "coeffs.json")
    parser.add_argument("--network", type=Path, default=HERE / "network.json")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--zeroed", action="store_true", help="the board had learnt its sensors' offsets before")
    how.add_argument("--loaded", action="store_true", help="the motor drives loads, and its current is measured")
    options = parser.parse_args()
    bench = bench_of(has_learnt=options.zeroed, loaded=options.loaded)
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        runs, healthy = identification_runs(folder, bench), healthy_runs(folder, bench)
        all_runs = [*runs, *changing_runs(folder, bench)]
        made = [
            ("parts", runs, ["--model", "parts"], options.out),
            ("network", all_runs, ["--model", "network"], options.network),
        ]
        if options.loaded:
            made = [
                ("unknown", all_runs, ["--model", "network"], options.out),
                ("known", all_runs, ["--model", "network", *BY_CURRENT], options.network),
            ]
        for name, taken, how_identified, out in made:
            identified = folder / f"{name}.json"
            gen("identify", *taken, *how_identified, "--name", "my1016_rig", "--out", identified)
            gen("thresholds", identified, *healthy, "--rules", HERE / "rules.json", "--out", out)


if __name__ == "__main__":
    main()
