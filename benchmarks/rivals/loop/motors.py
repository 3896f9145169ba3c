"""The same ways on motors of independent physics (`benchmarks.plants`): networks of 3 to 10 nodes.

Identification gets five cold steps and two mixed runs of 4 h in a held room, and is judged by what the sensors read in
two further runs of 4 h. A general tool has one input and one output, so it fits each sensed part alone, on the rise
over the room at a row a second.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import gen
from benchmarks.identify_rivals import RIVALS, FloatArray, Predictor, blocks
from benchmarks.network_identification.judge import judge
from benchmarks.plants.cases import Case, Measured, bench, floor, fresh_runs, measure, profile_chance, write_case
from benchmarks.plants.planted.trial import Trial, write_identification, write_trial
from benchmarks.plants.profiles import DataKind, fitted
from benchmarks.plants.rooms import RoomKind
from benchmarks.rivals.loop.identification import CASADI, Identified, absent, grey_box, rms
from benchmarks.rivals.loop.network import casadi_network
from benchmarks.rivals.loop.terms import courses
from benchmarks.rivals.loop.tracing import RIVALS as TRACERS
from benchmarks.rivals.loop.tracing import Traced, ours, rival
from benchmarks.scheduled_plants import AMBIENT
from gen.coefficients import load
from gen.runs import Run

SEED = 1700
NETWORK, PARTS = "gen identify, one network", "gen identify, each part alone"
FLOOR = "(what the sensors read, less the truth)"


@dataclass(frozen=True, eq=False)
class Motor:
    """What is known of one motor.

    Attributes
    ----------
    seed
        Of its bench.
    learnt, judged
        By sensed part, its runs on a grid of 1 s, in a room of `AMBIENT`.
    floor_K
        Root mean square of read minus true in the runs that judge, K.
    """

    seed: int
    learnt: dict[str, list[Run]]
    judged: dict[str, list[Run]]
    floor_K: float


def motor(seed: int) -> Motor:
    """Run one on its bench."""
    stand, room = bench(seed), RoomKind.HELD
    names = [stand.plant.names[node] for node in stand.plant.sensed]
    learnt = [measure(stand, profile, room) for profile in fitted(DataKind.MIXED, profile_chance(stand))]
    judged = fresh_runs(stand, room)
    return Motor(
        seed,
        {name: [_alone(run, name) for run in learnt] for name in names},
        {name: [_alone(run, name) for run in judged] for name in names},
        floor(stand.plant, judged),
    )


def _alone(measured: Measured, name: str) -> Run:
    """One part's run at a row a second, the room taken to `AMBIENT`."""
    columns = {key: np.asarray(values, dtype=np.float64) for key, values in measured.columns.items()}
    grid = np.arange(0.0, columns["time_s"][-1] + 1.0)
    row = np.searchsorted(columns["time_s"], grid, side="right") - 1
    read = np.isfinite(columns[f"{name}_degC"])
    rise = np.interp(grid, columns["time_s"][read], columns[f"{name}_degC"][read])
    rise -= float(np.nanmean(columns["ambient_degC"]))
    return Run(grid, columns["pwm"][row].astype(np.int64), {"part": rise + AMBIENT}, np.full(grid.size, AMBIENT))


def identified_motors(count: int, tell: Callable[[str], None]) -> list[Identified]:
    """Fit all on the same motors.

    Parameters
    ----------
    count
        How many motors.
    tell
        Told what is being done.

    Returns
    -------
    list of Identified
        A row for each way, and last the sensors' own error.
    """
    motors = []
    for seed in range(SEED, SEED + count):
        tell(f"motor {seed}")
        motors.append(motor(seed))
    found = [_ours(title, kind, motors, tell) for title, kind in ((NETWORK, "network"), (PARTS, "parts"))]
    ways = {name: fit for name, fit in RIVALS.items() if not name.startswith(("ARX", "gen"))}
    ways |= {"grey box by hand, two capacities": grey_box, CASADI: casadi_network}
    found += [_theirs(title, fit, motors, tell) for title, fit in ways.items()]
    return [*found, Identified(FLOOR, [one.floor_K for one in motors])]


def _ours(title: str, kind: str, motors: Sequence[Motor], tell: Callable[[str], None]) -> Identified:
    """Errors as `benchmarks.network_identification` has them; infinite where a part is left out."""
    errors, seconds = [], 0.0
    for one in motors:
        tell(f"{title}: motor {one.seed}")
        with tempfile.TemporaryDirectory(prefix="rivals-") as folder:
            written = write_case(Case(one.seed, DataKind.MIXED, RoomKind.HELD), Path(folder))
            begun = time.process_time()
            found = judge(written, kind, Path(folder))
            seconds += time.process_time() - begun
        errors.append(found.error_K if found.whole else float("inf"))
    return Identified(title, errors, seconds)


def _theirs(
    title: str, fit: Callable[[list[Run]], Predictor], motors: Sequence[Motor], tell: Callable[[str], None]
) -> Identified:
    if missing := absent(title):
        return Identified(title, missing=missing)
    errors, seconds = [], 0.0
    for one in motors:
        tell(f"{title}: motor {one.seed}")
        away: list[FloatArray] = []
        for name, runs in one.learnt.items():
            begun = time.process_time()
            with np.errstate(all="ignore"):
                predict = fit(runs)
                seconds += time.process_time() - begun
                away += [missed(predict, run) for run in one.judged[name]]
        errors.append(rms(np.concatenate(away)))
    return Identified(title, errors, seconds)


def missed(predict: Predictor, run: Run) -> FloatArray:
    """Predicted less read at single rows, from straight lines between the middles of the blocks that are predicted."""
    middles = blocks(run.time_s)
    predicted = np.interp(run.time_s, middles, predict(run.pwm))
    return np.asarray(predicted - (run.temps["part"] - AMBIENT), dtype=np.float64)


def traced_motors(kinds: Sequence[str], seed: int, tell: Callable[[str], None]) -> list[Traced]:
    """Identify a motor as a network, plant each effect in six later runs, and let all trace it.

    Parameters
    ----------
    kinds
        Names of effects, a trial each.
    seed
        Of the bench.
    tell
        Told what is being done.
    """
    found = []
    for kind in kinds:
        with tempfile.TemporaryDirectory(prefix="rivals-") as text:
            folder = Path(text)
            written = write_trial(Trial(seed, (kind,), 6), folder)
            tell(f"gen identify: the motor of {kind}")
            (folder / "before").mkdir()
            before = write_identification(written.setting, folder / "before")
            model = folder / "motor.json"
            gen.identify(list(before), name="motor", model="network").model.save(model)
            tell(f"gen refine: {kind}")
            found.append(ours(kind, model, written.fit, written.test))
            coefficients = load(model)
            learnt, judged = courses(coefficients, written.fit), courses(coefficients, written.test)
        for title, way in TRACERS.items():
            tell(f"{title}: {kind}")
            found.append(rival(title, way, kind, learnt, judged))
    return found
