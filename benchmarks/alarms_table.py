"""False alarms of a healthy motor, and what the rules say of both faults: the study's rules beside our own.

    python benchmarks/alarms_table.py [COEFFS ...] [--all] [--target twin|emulated|both] [--speeds 70 100] [--json FILE]

Without COEFFS: the study's rules with the study's model (`examples/my1016`), then the rules of `gen thresholds` with
the model of `gen identify` (`examples/my1016_rig`). Both are on the same simulated motor (`gen.rig`) with the same
sensors, each off by up to 1.1 K; noise, ambient and load are others than in the runs that the thresholds come from.

Cold: all parts at 30 degC when power comes on. Warm: the motor has run at 60 % for three hours before. Moving: the
ambient swings by 1 K to either side within two hours, with 1 % of the rated torque as load. The faults begin an hour
after a cold start. `--room`: in every run the ambient swings by 5 K within two hours, and jumps by 4 K after 90
minutes. Default are four speeds; `--all` are all ten and a line that changes speed every 15 to 45 minutes.
`twin` judges with the references of model and rules, which `gen verify` proves equal to the board's; `emulated` runs
the firmware itself on the emulated Mega, some 100 s for a run. Its sensors are read at other moments than the twin's,
and have other noise; `both` runs the firmware, lets the twin judge the very words that it was given, and compares when
each rule's alarm came (at speeds that are held).
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray
from rich.box import MARKDOWN
from rich.console import Console
from rich.table import Table

from gen.coefficients import Coefficients, load
from gen.emulate.board import Board
from gen.emulate.firmware import build_firmware, cache_folder
from gen.emulate.plants.plant import STEP_S, Plant, Reading
from gen.emulate.plants.rig import RigPlant
from gen.emulate.plants.twin import alarm_times
from gen.emulate.results import results_of
from gen.emulate.session import run_session
from gen.rig import Fault, MotorConfig, Profile, sensors, warm_start
from gen.rig.config import FaultKind
from gen.rig.profiles import counts, random_levels, step
from gen.rig.signals import Signal, sine, steps, total

ROOT = Path(__file__).parent.parent
EXAMPLES = [ROOT / "examples" / name / "coeffs.json" for name in ("my1016", "my1016_rig")]
DURATION_S = 10_800.0
FAULT_START_S = 3600.0
SPEEDS = (10, 40, 70, 100)
ALL_SPEEDS = tuple(range(10, 101, 10))
ROW_S = 1.0
"""Between two rows of the board."""
FIRST_READ = 2
"""So many steps before a row arrives the words in it were read: rows hold what these steps gave, every one."""
CHANGING = 0
"""Stands for the line with changing speeds."""
HEALTHY = ("healthy, cold", "healthy, warm", "healthy, moving")
KINDS: tuple[FaultKind, ...] = get_args(FaultKind)
CASES: tuple[str, ...] = (*HEALTHY, *KINDS)
VERDICTS = {"bearing": "bearing_fault", "brush": "brush_fault"}
SWING_K, PERIOD_S, LOAD_NM = 1.0, 7200.0, 0.01
ROOM_SWING_K, ROOM_JUMP_K, ROOM_JUMP_S = 2.5, 4.0, 5400.0
"""What `--room` does: a swing of 5 K from end to end, and a jump."""


@dataclass(frozen=True)
class Case:
    """One run: a speed in percent, or `CHANGING`, and what the motor is like."""

    speed: int
    name: str

    def profile(self, seed: int) -> Profile:
        """What PWM acts."""
        if self.speed == CHANGING:
            return random_levels(seed + 1, DURATION_S, hold_s=(900.0, 2700.0))
        return step(counts(self.speed), DURATION_S)

    def plant(self, coefficients: Coefficients, sensor_seed: int, seed: int, *, room: bool) -> RigPlant:
        """Make the motor with its sensors; `room`: the ambient swings by 5 K and jumps by 4 K in every run."""
        wiring = coefficients.document.wiring
        assert wiring is not None
        moving = self.name == "healthy, moving"
        faults = {str(kind): (Fault(kind, FAULT_START_S),) for kind in KINDS}
        own = 1000 * seed + 10 * self.speed + CASES.index(self.name)
        return RigPlant(
            [chip.channel for chip in wiring.thermocouples],
            motor=MotorConfig(faults=faults.get(self.name, ())),
            sensors=sensors(sensor_seed),
            start_degC=warm_start(step(153, DURATION_S)) if self.name == "healthy, warm" else None,
            ambient_degC=self._ambient(moving=moving, room=room),
            load_Nm=LOAD_NM if moving else 0.0,
            pulses_per_revolution=wiring.encoder.pulses_per_revolution if wiring.encoder else 0,
            seed=own,
        )

    def _ambient(self, *, moving: bool, room: bool) -> Signal:
        phase_s = 700.0 * self.speed
        if room:
            return total(sine(30.0, ROOM_SWING_K, PERIOD_S, phase_s), steps(0.0, [(ROOM_JUMP_S, ROOM_JUMP_K)]))
        return sine(30.0, SWING_K, PERIOD_S, phase_s) if moving else 30.0


class Recorded:
    """A plant, and what it has answered."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self.readings: list[Reading] = []

    def step(self, pwm: int, dt_s: float) -> Reading:
        """Answer as the plant does."""
        self.readings.append(self._plant.step(pwm, dt_s))
        return self.readings[-1]


class Played:
    """A plant that answers as one has answered before, from some step on."""

    def __init__(self, readings: Sequence[Reading]) -> None:
        self._readings = iter(readings)

    def step(self, pwm: int, dt_s: float) -> Reading:
        """Give the next answer, whatever PWM acts."""
        return next(self._readings)


def judged_again(
    coefficients: Coefficients, seen: Recorded, profile: Profile, time_zero_s: float
) -> NDArray[np.float64]:
    """Time of each rule's first alarm by the references, of what the firmware was given from its first sample on."""
    readings = seen.readings[round(time_zero_s / STEP_S) - FIRST_READ :]
    lasts_s = min(profile.duration_s, (len(readings) - 1) * STEP_S)
    first: NDArray[np.float64] = alarm_times(coefficients, [Played(readings)], [profile], lasts_s)[0]
    return first


def emulated_times(
    coefficients: Coefficients, plant: Plant, profile: Profile
) -> tuple[NDArray[np.float64], float | None]:
    """Time of each rule's first alarm as the firmware itself has it, s, NaN without; and when its time is 0."""
    wiring = coefficients.document.wiring
    assert wiring is not None
    firmware = build_firmware(coefficients, "fixed", "table", "coeffs.json", cache_folder())
    board = Board(firmware.elf, firmware.cache, wiring, plant, encoder="batched")
    levels = tuple(zip(profile.starts_s, profile.levels, strict=True))
    session = run_session(board, profile.duration_s, profile=levels)
    first = np.full(len(coefficients.document.alarms), np.nan)
    names = [rule.name for rule in coefficients.document.alarms]
    for alarm in results_of(coefficients.document, board, session).alarms:
        index = names.index(alarm.rule)
        if np.isnan(first[index]):
            first[index] = alarm.raised_s
    board.close()
    return first, session.time_zero_s


def times(
    coefficients: Coefficients, cases: Sequence[Case], options: argparse.Namespace, tell: Callable[[str], None]
) -> NDArray[np.float64]:
    """Time of each rule's first alarm in each case, s, NaN without; shape (cases, rules)."""
    plants = [case.plant(coefficients, options.sensors, options.seed, room=options.room) for case in cases]
    profiles = [case.profile(options.seed) for case in cases]
    if options.target == "twin":
        return alarm_times(
            coefficients, plants, profiles, DURATION_S, progress=lambda t: tell(f"{t:.0f} of {DURATION_S:.0f} s")
        )
    rows: list[NDArray[np.float64]] = []
    for case, plant, profile in zip(cases, plants, profiles, strict=True):
        tell(f"run {len(rows) + 1} of {len(cases)}")
        seen = Recorded(plant)
        row, time_zero_s = emulated_times(coefficients, seen, profile)
        rows.append(row)
        if options.target == "both":
            assert time_zero_s is not None
            told = judged_again(coefficients, seen, profile, time_zero_s)
            print(compared(case, [rule.name for rule in coefficients.document.alarms], row, told), flush=True)
    return np.array(rows)


def compared(case: Case, names: Sequence[str], board: NDArray[np.float64], told: NDArray[np.float64]) -> str:
    """Say whether the references raise what the board did, each within the second that a row stands for."""
    raised = [
        f"{name} {there:.0f} s"
        for name, there, here in zip(names, board, told, strict=True)
        if not np.isnan(there) and abs(there - here) <= ROW_S
    ]
    differ = [
        f"{name}: board {there:.2f} s, reference {here:.2f} s"
        for name, there, here in zip(names, board, told, strict=True)
        if not (np.isnan(there) and np.isnan(here)) and not abs(there - here) <= ROW_S
    ]
    said = f"DIFFERS: {'; '.join(differ)}" if differ else f"the same: {', '.join(raised) or 'no alarm'}"
    return f"{case.speed} %, {case.name}: {said}"


def text_of(case: Case, first: NDArray[np.float64], names: list[str]) -> str:
    """Say what the rules said: alarms in order; for faults with the delay since the fault began, and the verdict."""
    order = [i for i in np.argsort(first) if not np.isnan(first[i])]
    if case.name in HEALTHY:
        return ", ".join(f"{names[i]} {first[i]:.0f} s" for i in order) or "none"
    if not order:
        return "not detected"
    early = [i for i in order if first[i] < FAULT_START_S]
    if early:
        return "false alarm before: " + ", ".join(f"{names[i]} {first[i]:.0f} s" for i in early)
    verdicts = [(kind, first[names.index(rule)]) for kind, rule in VERDICTS.items() if rule in names]
    given = sorted((when, kind) for kind, when in verdicts if not np.isnan(when))
    said = ", then ".join(f"{kind} {when - FAULT_START_S:+.0f} s" for when, kind in given) or "no verdict"
    return f"{names[order[0]]} {first[order[0]] - FAULT_START_S:+.0f} s; {said}"


def summary(cases: Sequence[Case], first: NDArray[np.float64], names: list[str]) -> str:
    """Count false alarms, detections and right verdicts."""
    false = sum(1 for case, row in zip(cases, first, strict=True) if _false(case, row))
    lines = [f"{false} of {len(cases)} runs have a false alarm (of a healthy motor, or before the fault)"]
    for kind, rule in VERDICTS.items():
        rows = [row for case, row in zip(cases, first, strict=True) if case.name == kind]
        if not rows:
            continue
        detected = sum(1 for row in rows if np.any(row >= FAULT_START_S) and not np.any(row < FAULT_START_S))
        other = VERDICTS["brush" if kind == "bearing" else "bearing"]
        right = [row for row in rows if not np.isnan(row[names.index(rule)]) and np.isnan(row[names.index(other)])]
        lines.append(
            f"{kind}: {detected} of {len(rows)} detected without a false alarm before, {len(right)} told right"
        )
    return "; ".join(lines)


def _false(case: Case, first: NDArray[np.float64]) -> bool:
    limit = DURATION_S + 1.0 if case.name in HEALTHY else FAULT_START_S
    return bool(np.any(first < limit))


def main() -> None:
    """Run the cases and print a table for each file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("coefficients", type=Path, nargs="*", default=EXAMPLES)
    parser.add_argument("--target", choices=("twin", "emulated", "both"), default="twin")
    parser.add_argument("--speeds", type=int, nargs="+", default=SPEEDS, help="percent; 0: changing")
    parser.add_argument("--all", action="store_true", help="all ten speeds, and changing ones")
    parser.add_argument("--room", action="store_true", help="a room that swings by 5 K and jumps by 4 K")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=CASES)
    parser.add_argument("--sensors", type=int, default=0, help="seed of the sensors' offsets")
    parser.add_argument("--seed", type=int, default=1, help="of noise and changing speeds")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    if options.all:
        options.speeds = [*ALL_SPEEDS, CHANGING]
    if options.target == "both" and CHANGING in options.speeds:
        parser.error("--target both is for speeds that are held")
    cases = [Case(speed, name) for speed in options.speeds for name in options.cases]
    console = Console(width=300)
    found = []
    for path in options.coefficients:
        coefficients = load(path)
        names = [rule.name for rule in coefficients.document.alarms]
        with Console(stderr=True).status("") as status:
            first = times(coefficients, cases, options, status.update)
        title = f"{coefficients.name}, {options.target}, sensors {options.sensors}, seed {options.seed}"
        table = Table("speed", *options.cases, box=MARKDOWN)
        for index in range(0, len(cases), len(options.cases)):
            part = slice(index, index + len(options.cases))
            cells = [text_of(case, row, names) for case, row in zip(cases[part], first[part], strict=True)]
            table.add_row(f"{cases[index].speed} %" if cases[index].speed else "changing", *cells)
        console.print(title, table, summary(cases, first, names), sep="\n", highlight=False)
        found += [
            {
                "model": coefficients.name,
                "speed_percent": case.speed,
                "case": case.name,
                "first_s": {name: None if np.isnan(t) else float(t) for name, t in zip(names, row, strict=True)},
            }
            for case, row in zip(cases, first, strict=True)
        ]
    if options.json is not None:
        options.json.write_text(json.dumps({"target": options.target, "runs": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()
