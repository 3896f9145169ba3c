"""False alarms of a healthy motor, and what the rules say of both faults, at ten speeds.

    python benchmarks/alarms_table.py [COEFFS] [--target twin|emulated] [--speeds 70 100] [--json FILE]

The simulated motor (`gen.rig`) has the study's sensors, each with an offset within 1.1 K that the seed chooses. Cold:
all parts at 30 degC when power comes on. Warm: the motor has run at 60 % for three hours before. The faults begin an
hour after a cold start. `twin` judges with the references of model and rules, which `gen verify` proves equal to the
board's; `emulated` runs the firmware itself on the emulated Mega, some 100 s for a run.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from gen.coefficients import Coefficients, load
from gen.emulate.board import Board
from gen.emulate.firmware import build_firmware, cache_folder
from gen.emulate.results import results_of
from gen.emulate.rig import RigPlant
from gen.emulate.session import run_session
from gen.emulate.twin import alarm_times
from gen.rig import Fault, MotorConfig, Profile, sensors, warm_start

ROOT = Path(__file__).parent.parent
DURATION_S = 10_800.0
FAULT_START_S = 3600.0
SPEEDS = tuple(range(10, 101, 10))
CASES = ("healthy, cold", "healthy, warm", "bearing", "brush")


def plant_of(coefficients: Coefficients, case: str, seed: int) -> RigPlant:
    """Make the motor of a case, cold or warm, healthy or not."""
    wiring = coefficients.document.wiring
    assert wiring is not None
    faults = (Fault("bearing", FAULT_START_S),) if case == "bearing" else ()
    faults = (Fault("brush", FAULT_START_S),) if case == "brush" else faults
    start = warm_start(Profile((0.0,), (153,), DURATION_S)) if case == "healthy, warm" else None
    return RigPlant(
        [chip.channel for chip in wiring.thermocouples],
        motor=MotorConfig(faults=faults),
        sensors=sensors(seed),
        start_degC=start,
        pulses_per_revolution=wiring.encoder.pulses_per_revolution if wiring.encoder else 0,
        seed=seed,
    )


def emulated_times(coefficients: Coefficients, plant: RigPlant, pwm: int) -> NDArray[np.float64]:
    """Time of each rule's first alarm as the firmware itself has it, s, NaN without."""
    wiring = coefficients.document.wiring
    assert wiring is not None
    firmware = build_firmware(coefficients, "fixed", "table", "coeffs.json", cache_folder())
    board = Board(firmware.elf, firmware.cache, wiring, plant)
    session = run_session(board, DURATION_S, profile=((0.0, pwm),))
    first = np.full(len(coefficients.document.alarms), np.nan)
    names = [rule.name for rule in coefficients.document.alarms]
    for alarm in results_of(coefficients.document, board, session).alarms:
        index = names.index(alarm.rule)
        if np.isnan(first[index]):
            first[index] = alarm.raised_s
    board.close()
    return first


def text_of(case: str, first: NDArray[np.float64], names: list[str]) -> str:
    """Say what the rules said: alarms in order; for faults with the delay since the fault began."""
    order = [i for i in np.argsort(first) if not np.isnan(first[i])]
    if not order:
        return "none" if case.startswith("healthy") else "not detected"
    if case.startswith("healthy"):
        return ", ".join(f"{names[i]} {first[i]:.0f} s" for i in order)
    early = any(first[i] < FAULT_START_S for i in order)
    said = ", ".join(f"{names[i]} {first[i] - FAULT_START_S:+.0f} s" for i in order)
    return f"{said} (false alarm before the fault)" if early else said


def main() -> None:
    """Run the cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("coefficients", type=Path, nargs="?", default=ROOT / "examples" / "my1016" / "coeffs.json")
    parser.add_argument("--target", choices=("twin", "emulated"), default="twin")
    parser.add_argument("--speeds", type=int, nargs="+", default=SPEEDS, help="percent")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    coefficients = load(options.coefficients)
    names = [rule.name for rule in coefficients.document.alarms]
    runs = [(speed, case) for speed in options.speeds for case in CASES]
    pwm = [round(speed / 100.0 * 255) for speed, _ in runs]
    plants = [plant_of(coefficients, case, options.seed) for _, case in runs]
    console = Console()
    with Console(stderr=True).status("") as status:
        if options.target == "twin":
            first = alarm_times(
                coefficients,
                plants,
                pwm,
                DURATION_S,
                progress=lambda t: status.update(f"{t:.0f} of {DURATION_S:.0f} s"),
            )
        else:
            rows = []
            for number, (plant, value) in enumerate(zip(plants, pwm, strict=True), start=1):
                status.update(f"run {number} of {len(runs)}")
                rows.append(emulated_times(coefficients, plant, value))
            first = np.array(rows)
    table = Table("speed", *CASES, title=f"{coefficients.name}, {options.target}, sensors' seed {options.seed}")
    for index, speed in enumerate(options.speeds):
        cells = first[index * len(CASES) : (index + 1) * len(CASES)]
        table.add_row(f"{speed} %", *(text_of(case, cell, names) for case, cell in zip(CASES, cells, strict=True)))
    console.print(table)
    if options.json is not None:
        found = [
            {"speed_percent": speed, "case": case, "first_s": dict(zip(names, map(_or_none, times), strict=True))}
            for (speed, case), times in zip(runs, first, strict=True)
        ]
        options.json.write_text(json.dumps({"model": coefficients.name, "runs": found}, indent=1) + "\n")


def _or_none(time_s: float) -> float | None:
    return None if np.isnan(time_s) else float(time_s)


if __name__ == "__main__":
    main()
