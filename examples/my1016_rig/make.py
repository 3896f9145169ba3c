"""Make coeffs.json as one would for a motor of one's own: runs, `gen identify`, healthy runs, `gen thresholds`.

    python examples/my1016_rig/make.py [--folder RUNS] [--out COEFFS] [--network NETWORK] [--zeroed]

And network.json, with `gen identify --model network`, of the same eight runs and four at changing speeds: a transfer
function wants speeds that are held, a network takes what there is, and only changes from speed to speed tell it what
hidden parts keep.

The motor is the simulated one (`gen.rig`) with one set of sensors, each off by up to 1.1 K. Eight runs from cold, three
hours at a speed and one at rest, identify the model. Fifty-two runs of three hours that took no part in it show what is
healthy: at eight speeds a cold and a warm start (an hour at 60 % before), each alone and with an ambient that swings
by 1 K to either side within two hours and up to 2 % of the rated torque as load; twelve more change speed every 15 to
45 minutes; eight have pauses of a minute, or a room that swings by 5 K and jumps by 4 K.
The final tables (`benchmarks/alarms_table.py`, `benchmarks/alarm_hours.py`) have other speeds, noise and ambients.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import replace
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
Sensors = Mapping[str, SensorConfig]


def board_sensors(*, has_learnt: bool) -> Sensors:
    """Give the motor's sensors, or as they are once the board has learnt their offsets."""
    own = sensors(SENSORS)
    return zeroed(own, ROOM_DEGC, ZERO_SEED) if has_learnt else own


def record(
    path: Path,
    profile: Profile,
    seed: int,
    fitted: Sensors,
    *,
    warm: bool = False,
    moving: bool = False,
    inputs: Mapping[str, Signal] | None = None,
) -> Path:
    """Make one run file of the healthy motor; `inputs` of the bench over time, by their names in its setup."""
    random = np.random.default_rng(seed)
    setup = Setup(
        sensors=fitted,
        seed=seed,
        start_degC=warm_start(step(counts(60), 3600.0)) if warm else {},
        ambient=sine(30.0, SWING_K, PERIOD_S, float(random.uniform(0.0, PERIOD_S))) if moving else 30.0,
        load_Nm=float(random.uniform(0.0, LOAD_NM)) if moving else 0.0,
        channels=("speed_rpm",),
    )
    setup = replace(setup, **(inputs or {}))  # type: ignore[arg-type]
    make_run(profile, setup).write(path)
    return path


def identification_runs(folder: Path, fitted: Sensors) -> list[Path]:
    """Steps from cold, then cooling."""
    return [
        record(folder / f"identify_{percent}.csv", cut_off(counts(percent), 10_800.0, 3600.0), 1000 + percent, fitted)
        for percent in IDENTIFIED
    ]


def changing_runs(folder: Path, fitted: Sensors) -> list[Path]:
    """Speeds held for 10 to 45 minutes, for the network."""
    return [
        record(folder / f"identify_changing_{number}.csv", random_levels(seed, hold_s=(600.0, 2700.0)), seed, fitted)
        for number in range(CHANGING_IDENTIFIED)
        for seed in (5000 + number,)
    ]


def healthy_runs(folder: Path, fitted: Sensors) -> list[Path]:
    """What a healthy motor does."""
    made = []
    for percent in IDENTIFIED:
        for warm in (False, True):
            for moving in (False, True):
                name = f"healthy_{percent}_{'warm' if warm else 'cold'}{'_moving' if moving else ''}.csv"
                seed = 2000 + 10 * percent + 2 * warm + moving
                made.append(record(folder / name, step(counts(percent)), seed, fitted, warm=warm, moving=moving))
    for number in range(CHANGING):
        profile = random_levels(3000 + number, hold_s=(900.0, 2700.0))
        path, moving = folder / f"healthy_changing_{number}.csv", number % 2 == 1
        made.append(record(path, profile, 3000 + number, fitted, moving=moving))
    return made + surrounded_runs(folder, fitted)


def surrounded_runs(folder: Path, fitted: Sensors) -> list[Path]:
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
            made.append(record(folder / f"healthy_{kind}_{number}.csv", profile, 6000 + number, fitted, inputs=inputs))
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
    parser.add_argument("--zeroed", action="store_true", help="the board had learnt its sensors' offsets before")
    options = parser.parse_args()
    fitted = board_sensors(has_learnt=options.zeroed)
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        runs, healthy = identification_runs(folder, fitted), healthy_runs(folder, fitted)
        all_runs = [*runs, *changing_runs(folder, fitted)]
        for model, taken, out in (("parts", runs, options.out), ("network", all_runs, options.network)):
            identified = folder / f"{model}.json"
            gen("identify", *taken, "--model", model, "--name", "my1016_rig", "--out", identified)
            gen("thresholds", identified, *healthy, "--rules", HERE / "rules.json", "--out", out)


if __name__ == "__main__":
    main()
