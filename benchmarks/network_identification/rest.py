"""What nobody can know of a motor that never rested: the true motor itself, with its cooling at rest guessed.

``python -m benchmarks.network_identification.rest --plants 12 --seed 400`` predicts the test runs of the table with the
true plants, whose conductances at PWM 0 are those of the slowest PWM measured, all times one factor. So everything but
rest is known exactly, laws and sensors' lag aside; steps at |PWM| of 20 % and more cannot tell the factor. The row with
the lowest 90 % is the best that any method can do which takes one factor for all motors, and takes it from the answer.
``--data mixed`` takes only those of the motors that never rested in the steps and mixed runs of the table.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.network_identification.table import GOOD, rested
from benchmarks.plants.cases import Bench, Case, bench, floor, fresh_runs
from benchmarks.plants.course import course
from benchmarks.plants.plant import FollowedRates, Plant
from benchmarks.plants.profiles import STEP_LEVELS, DataKind
from benchmarks.plants.rooms import RoomKind

FloatArray = NDArray[np.float64]
FACTORS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2)


@dataclass(frozen=True)
class Guessed:
    """A plant whose cooling at rest is not its own.

    Parameters
    ----------
    plant
        The true one.
    factor
        Conductances at rest over those at the slowest PWM measured.
    """

    plant: Plant
    factor: float

    @property
    def changes(self) -> Sequence[float]:
        """Nothing of it jumps beside PWM."""
        return self.plant.changes

    @property
    def longest_s(self) -> float:
        """As of the plant."""
        return self.plant.longest_s

    def rest(self, ambient: float) -> FloatArray:
        """Temperatures after a long rest in a room, degC, shape (N,)."""
        return self.plant.rest(ambient)

    def rates(self, pwm: int, begin: float) -> FollowedRates:
        """How its temperatures change at a PWM, K/s."""
        if pwm != 0:
            return self.plant.rates(pwm, begin)
        running = self.plant.at(STEP_LEVELS[0])
        running.power[:] = running.growth[:] = 0.0
        running.matrix += np.diag((1.0 - self.factor) * running.outlet)
        for part in (running.outlet, running.natural, running.radiating):
            part *= self.factor
        return running.rates


def errors(stand: Bench, room: RoomKind) -> list[float]:
    """Error on the test runs in such a room for each factor, in noise floors."""
    runs = fresh_runs(stand, room)
    own = floor(stand.plant, runs)
    made = []
    for factor in FACTORS:
        missed = []
        for run in runs:
            # The rows that the logger lost are no rows of the truth.
            told = course(Guessed(stand.plant, factor), run.profile, run.room, stand.row_s)
            at = np.searchsorted(told.time, run.run.time)
            for node in stand.plant.sensed:
                missed.append(run.columns[f"{stand.plant.names[node]}_degC"] - told.temperature[at, node])
        made.append(float(np.sqrt(np.nanmean(np.concatenate(missed) ** 2))) / own)
    return made


def main(argv: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.network_identification.rest",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--plants", type=int, default=12, help="how many")
    parser.add_argument("--seed", type=int, default=400, help="of the first plant; the others follow")
    parser.add_argument(
        "--data",
        choices=[DataKind.STEPS, DataKind.MIXED],
        default=DataKind.STEPS,
        help="which motors: that never rest in",
    )
    parser.add_argument("--room", choices=[RoomKind.HELD, RoomKind.MOVING], default=RoomKind.HELD, help="of the tests")
    options = parser.parse_args(argv)
    room = RoomKind(options.room)
    cases = [Case(seed, DataKind(options.data), room) for seed in range(options.seed, options.seed + options.plants)]
    table = np.array([errors(bench(case.seed), room) for case in cases if not rested(case)])
    print(f"the true motors, their conductances at rest guessed, {len(table)} plants: error in noise floors")
    print(f"at rest / at the slowest step  median  90%   worst  at most {GOOD}")
    for factor, column in zip(FACTORS, table.T, strict=True):
        low, high, worst = np.median(column), np.quantile(column, 0.9), column.max()
        print(f"{factor:<29g}  {low:<6.2f}  {high:<4.2f}  {worst:<5.2f}  {np.mean(column <= GOOD):.0%}")


if __name__ == "__main__":
    main()
