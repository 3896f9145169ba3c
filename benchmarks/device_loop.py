"""The loop on the device, from one command: what the board's alarms are worth before and after `gen refine`.

    python benchmarks/device_loop.py [--effect schedule_error] [--logs rig|emulated] [--judge twin|emulated]
    python benchmarks/device_loop.py --logs emulated --judge emulated --hold 900 --speeds 70 --judged 3600

1. `gen identify` on steps from cold of the simulated motor as it was commissioned: the baseline, with rules of alarm.
2. The motor at work has an effect that this model lacks. By default the lack is real: the motor was commissioned at
   three speeds only, and works at those between (`schedule_error`); with ``--baseline
   examples/my1016/coeffs.json`` the study's own model, its schedules and its rules. Others change the motor's physics.
3. Its logs: from the rig at once (`rig`), or printed by the baseline's firmware on the emulated Mega (`emulated`, some
   60 s of this machine for an hour).
4. `gen refine` on the logs, `gen build` of the refined file.
5. Healthy, with a degreased bearing and with a chipped brush, at held speeds: the rules' alarms before and after, by
   the bit-exact references of the board (`twin`), or by both firmwares on the emulated Mega (`emulated`).

The second line runs the firmware itself wherever it can, on few hours of the motor: some 15 minutes.

Board and sensors are the same throughout. Effects that the firmware cannot hold are left out of it and named; "refined"
is what it holds.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.alarms_table import emulated_times  # noqa: E402
from gen.coefficients import Coefficients, load  # noqa: E402
from gen.emulate.board import Board  # noqa: E402
from gen.emulate.firmware import build_firmware, cache_folder  # noqa: E402
from gen.emulate.rig import RigPlant  # noqa: E402
from gen.emulate.session import run_session  # noqa: E402
from gen.emulate.twin import alarm_times  # noqa: E402
from gen.record.port import write_parts  # noqa: E402
from gen.refinement.run_errors import Score, run_errors, total  # noqa: E402
from gen.rig import Fault, MotorConfig, Profile, Setup, make_run, sensors  # noqa: E402
from gen.rig.config import HiddenPart  # noqa: E402
from gen.rig.parameters import HeatPath  # noqa: E402
from gen.rig.profiles import counts, staircase, step  # noqa: E402

EFFECTS: dict[str, MotorConfig] = {
    "schedule_error": MotorConfig(),
    "standstill_cooling": MotorConfig(standstill_cooling=0.4),
    "hidden_node": MotorConfig(hidden=HiddenPart()),
    "radiation": MotorConfig(radiating_area_m2=0.1),
    "direction": MotorConfig(reverse_losses=1.4),
    "temperature_dependent_loss": MotorConfig(loss_per_K=-0.006),
    "coupling": MotorConfig(coupling=(HeatPath(a="brush", b="casing", still_W_per_K=0.05),)),
}
COMMISSIONED = {"schedule_error": (20, 60, 100)}
ALL_SPEEDS = (20, 40, 60, 80, 100)
HOLD_S = 2700.0
STEADY = ((30, 80, 50, 90), (70, 40, 100, 60), (90, 30, 80, 70), (50, 100, 40, 90), (80, 60, 30, 50), (60, 90, 70, 40))
STEADY_TESTS = ((40, 80, 60, 30), (70, 50, 90, 80))
"""Speeds in percent, held one after the other; one log each."""
WORK = ((30, 80, 50, 90), (70, 40, 100, 0), (90, 30, 0, 70), (50, -80, 40, 0), (80, 0, 60, 30), (-60, 90, 0, 50))
TESTS = ((40, 80, 0, 30), (70, 50, 90, -40))
"""The same with stops and reversals, for effects that show there."""
SPEEDS = (30, 40, 50, 60, 70, 80, 90, 100)
CASES: dict[str, tuple[Fault, ...]] = {"healthy": (), "bearing": (Fault("bearing"),), "brush": (Fault("brush"),)}
JUDGED_S = 9000.0


def _rule(name: str, component: str, threshold: float, speeds: tuple[int, int], **more: str) -> dict[str, Any]:
    kind = more.pop("kind", "above_model")
    times = {"hysteresis_K": 1.0, "persistence_s": 60, "settle_s": 600}
    where = {"component": component, "threshold_K": threshold, "speed_percent": list(speeds)}
    return {"name": name, "kind": kind, **where, **times, **more}


RULES = [
    _rule("fault", "casing", 3.0, (30, 100)),
    _rule("bearing_fault", "brush", 2.0, (69, 71), requires="fault"),
    _rule("brush_fault", "brush", 0.0, (69, 71), kind="below_model", requires="fault"),
]
"""The casing of either fault is 5 K and more over a healthy one's from 30 %; 3 K are the sensors' two tolerances of
1.1 K and as much again for the model. At 70 % the brush says which fault it is."""


def gen(*arguments: str | Path) -> str:
    """Run a command of `gen`."""
    command = [sys.executable, "-m", "gen", *map(str, arguments)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"gen {arguments[0]}: {done.stderr}")
    return done.stdout


def commissioned(folder: Path, effect: str, seed: int, given: Path | None) -> Path:
    """The baseline: `gen identify` on steps from cold, with the board's wiring and the rules; or the file given."""
    if given is not None:
        return given
    runs = []
    for speed in COMMISSIONED.get(effect, ALL_SPEEDS):
        setup = Setup(sensors=sensors(seed), seed=seed + speed)
        runs.append(folder / f"cold{speed}.csv")
        make_run(step(counts(speed)), setup).write(runs[-1])
    out = folder / "baseline.json"
    gen("identify", *runs, "--out", out, "--name", "commissioned")
    document = json.loads(out.read_text(encoding="utf-8"))
    example = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    document |= {"wiring": example["wiring"], "alarms": RULES}
    out.write_text(json.dumps(document, indent=1), encoding="utf-8")
    return out


def plant(coefficients: Coefficients, motor: MotorConfig, seed: int, noise: int) -> RigPlant:
    """A motor on the board; `seed` gives the sensors their offsets, `noise` their noise."""
    wiring = coefficients.document.wiring
    assert wiring is not None
    channels = [chip.channel for chip in wiring.thermocouples]
    pulses = wiring.encoder.pulses_per_revolution if wiring.encoder else 0
    return RigPlant(channels, motor=motor, sensors=sensors(seed), pulses_per_revolution=pulses, seed=noise)


def logged(
    path: Path,
    speeds: Sequence[int],
    hold_s: float,
    baseline: Coefficients,
    motor: MotorConfig,
    seed: int,
    emulated: bool,
) -> Path:
    """A log of the motor at work."""
    profile: Profile = staircase([counts(speed) for speed in speeds], hold_s)
    noise = seed + sum(speeds)
    if not emulated:
        make_run(profile, Setup(motor=motor, sensors=sensors(seed), channels=("speed_rpm",), seed=noise)).write(path)
        return path
    firmware = build_firmware(baseline, "fixed", "table", "baseline.json", cache_folder())
    assert baseline.document.wiring is not None
    board = Board(firmware.elf, firmware.cache, baseline.document.wiring, plant(baseline, motor, seed, noise))
    steps = tuple(zip(profile.starts_s, profile.levels, strict=True))
    session = run_session(board, profile.duration_s, profile=steps)
    board.close()
    write_parts(session.recorder, path)
    return path


def for_the_board(refined: Path) -> tuple[Path, list[str]]:
    """The refined file without the effects that `gen build` cannot hold, and their names."""
    held = {(a.effect.name, a.component) for a in load(refined).effects}
    document = json.loads(refined.read_text(encoding="utf-8"))
    trial = subprocess.run(
        [sys.executable, "-m", "gen", "build", str(refined), "--out", str(refined.parent / "firmware")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if trial.returncode == 0:
        return refined, []
    document["effects"] = [e for e in document["effects"] if (e["name"], e["component"]) not in held]
    out = refined.with_name("board.json")
    out.write_text(json.dumps(document, indent=1), encoding="utf-8")
    gen("build", out, "--out", refined.parent / "firmware")
    return out, sorted(f"{name} of {component}" for name, component in held)


def judged(
    coefficients: Coefficients, motor: MotorConfig, seed: int, speeds: Sequence[int], duration_s: float, emulated: bool
) -> np.ndarray:
    """Time of each rule's first alarm, s, NaN without; shape (speeds, cases, rules)."""
    runs = [(speed, faults) for speed in speeds for faults in CASES.values()]
    plants = [plant(coefficients, replace(motor, faults=faults), seed, 1000 + speed) for speed, faults in runs]
    pwm = [counts(speed) for speed, _ in runs]
    if emulated:
        rows = [
            emulated_times(coefficients, own, step(value, duration_s)) for own, value in zip(plants, pwm, strict=True)
        ]
        first = np.array(rows)
    else:
        first = alarm_times(coefficients, plants, pwm, duration_s)
    return first.reshape(len(speeds), len(CASES), -1)


def lines(
    before: np.ndarray, after: np.ndarray, errors: Sequence[Score], names: Sequence[str], speeds: Sequence[int]
) -> list[tuple[str, str, str]]:
    """The table: what, before, after.

    `errors` are on test logs before and after, `names` are the rules', `speeds` those at which they were judged.
    """
    made = [
        ("RMSE of test logs", *(f"{error.rmse_K:.2f} K" for error in errors)),
        ("worst error of test logs", *(f"{error.max_abs_K:.2f} K" for error in errors)),
    ]
    called_at = min(speeds, key=lambda speed: abs(speed - 70))
    row = speeds.index(called_at)
    for c, case in enumerate(CASES):
        told = []
        for first in (before, after):
            earliest = np.min(np.where(np.isnan(first[:, c]), np.inf, first[:, c]), axis=-1)
            raised = np.isfinite(earliest)
            text = f"at {raised.sum()} of {len(speeds)} speeds"
            if case == "healthy" and raised.any():
                text += f" ({', '.join(f'{s} %' for s, r in zip(speeds, raised, strict=True) if r)})"
            if case != "healthy" and raised.any():
                text += f", after {np.median(earliest[raised]):.0f} s"
            told.append(text)
        made.append(("false alarms" if case == "healthy" else f"{case} fault detected", *told))
        called = [
            ", ".join(n for n, t in zip(names, first[row, c], strict=True) if not np.isnan(t)) or "nothing"
            for first in (before, after)
        ]
        made.append((f"said at {called_at} %, {case}", *called))
    return [(a, b, c) for a, b, c in made]


def main() -> None:
    """Go round the loop once."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--effect", choices=list(EFFECTS), default="schedule_error")
    parser.add_argument("--logs", choices=("rig", "emulated"), default="rig")
    parser.add_argument("--judge", choices=("twin", "emulated"), default="twin")
    parser.add_argument("--baseline", type=Path, help="instead of identifying one: a coefficient file with rules")
    parser.add_argument("--hold", type=float, default=HOLD_S, help="how long the logs hold a speed, s")
    parser.add_argument("--speeds", type=int, nargs="+", default=SPEEDS, help="at which alarms are judged, percent")
    parser.add_argument("--judged", type=float, default=JUDGED_S, help="for how long, s")
    parser.add_argument("--seed", type=int, default=0, help="of the board's sensors")
    parser.add_argument("--keep", type=Path, help="keep all files in this folder")
    options = parser.parse_args()
    motor = EFFECTS[options.effect]
    emulated = options.logs == "emulated"
    work = (STEADY, STEADY_TESTS) if options.effect == "schedule_error" else (WORK, TESTS)
    with tempfile.TemporaryDirectory() as name:
        folder = options.keep or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        baseline = commissioned(folder, options.effect, options.seed, options.baseline)
        model = load(baseline)
        fit, test = (
            [
                logged(folder / f"{key}{i}.csv", speeds, options.hold, model, motor, options.seed, emulated)
                for i, speeds in enumerate(group)
            ]
            for key, group in zip(("fit", "test"), work, strict=True)
        )
        files: list[str | Path] = ["--fit", *fit, "--test", *test, "--out", folder / "refined.json"]
        said = gen("refine", baseline, *files, "--report", folder / "report.html")
        print(said)
        board, dropped = for_the_board(folder / "refined.json")
        if dropped:
            print(f"not in the firmware: {', '.join(dropped)}")
        errors = [
            total(one for path in test for one in run_errors(model, load(held), path)[0].values())
            for held in (baseline, board)
        ]
        before, after = (
            judged(load(p), motor, options.seed, options.speeds, options.judged, options.judge == "emulated")
            for p in (baseline, board)
        )
    table = Table(options.effect, "baseline", "refined", title=f"logs: {options.logs}; alarms: {options.judge}")
    for line in lines(before, after, errors, [rule.name for rule in model.document.alarms], options.speeds):
        table.add_row(*line)
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
