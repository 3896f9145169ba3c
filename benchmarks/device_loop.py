"""The loop on the device, from one command: what the board's alarms are worth before and after `gen refine`.

    python benchmarks/device_loop.py [--effect schedule_error] [--logs rig|emulated] [--judge twin|emulated]
    python benchmarks/device_loop.py --logs emulated --judge emulated --hold 900 --speeds 70 --judged 3600
    python benchmarks/device_loop.py --model network --effect together --logs emulated --judge emulated --hold 900 \
        --speeds 70 --judged 3600

1. `gen identify` on steps from cold of the simulated motor as it was commissioned: the baseline, with rules of alarm;
   with ``--model network`` it is a network, the steps end with an hour at rest, and thresholds come later (5.).
2. The motor at work has an effect that this model lacks. By default the lack is real: the motor was commissioned at
   three speeds only, and works at those between (`schedule_error`); with ``--baseline
   examples/my1016/coeffs.json`` the study's own model, its schedules and its rules. Others change the motor's physics.
   ``together``: a hot part without a sensor beside the brush, and surroundings that were not there before, in the logs
   and while alarms are judged: a fan that is on and off, a room that swings by 6 K within 90 minutes, a load that
   changes. The board measures fan, room and current.
3. Its logs: from the rig at once (`rig`), or printed by the baseline's firmware on the emulated Mega (`emulated`, some
   60 s of this machine for an hour).
4. `gen refine` on the logs, `gen build` of the refined file.
5. With ``--model network``: `gen thresholds` gives either file the rules of `examples/my1016_rig/rules.json`, from
   twelve more hours of the healthy motor at work.
6. Healthy, with a degreased bearing and with a chipped brush, at held speeds: the rules' alarms before and after, by
   the bit-exact references of the board (`twin`), or by both firmwares on the emulated Mega (`emulated`). The faults
   are there from the start on; with derived thresholds they begin after a third of the time.

The second and the third line run the firmware itself wherever it can, on few hours of the motor: some 15 minutes.

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
from dataclasses import dataclass, replace
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
from gen.emulate.plants.rig import RigPlant  # noqa: E402
from gen.emulate.plants.twin import alarm_times  # noqa: E402
from gen.emulate.session import run_session  # noqa: E402
from gen.record.port import write_parts  # noqa: E402
from gen.refinement.run_errors import run_errors, total  # noqa: E402
from gen.rig import Fault, MotorConfig, Profile, Setup, make_run, sensors  # noqa: E402
from gen.rig.config import FaultKind, HiddenPart  # noqa: E402
from gen.rig.parameters import HeatPath  # noqa: E402
from gen.rig.profiles import counts, cut_off, staircase, step  # noqa: E402
from gen.rig.signals import Signal, sine, steps  # noqa: E402

EFFECTS: dict[str, MotorConfig] = {
    "schedule_error": MotorConfig(),
    "standstill_cooling": MotorConfig(standstill_cooling=0.4),
    "hidden_node": MotorConfig(hidden=HiddenPart()),
    "radiation": MotorConfig(radiating_area_m2=0.1),
    "direction": MotorConfig(reverse_losses=1.4),
    "temperature_dependent_loss": MotorConfig(loss_per_K=-0.006),
    "coupling": MotorConfig(coupling=(HeatPath(a="brush", b="casing", still_W_per_K=0.05),)),
    "together": MotorConfig(hidden=HiddenPart(capacity_J_per_K=300.0, conductance_W_per_K=0.3)),
}
SURROUNDED = ("together",)
"""Effects with which fan, room and load change, too."""
CHANNELS = [
    {"column": "current_A", "analog_pin": 54, "per_V": 4.0},
    {"column": "airflow_m_s", "analog_pin": 55, "per_V": 2.0},
]
"""What the board measures beside temperatures, where they do."""
COMMISSIONED = {"schedule_error": (20, 60, 100)}
ALL_SPEEDS = (20, 40, 60, 80, 100)
HOLD_S = 2700.0
STEADY = ((30, 80, 50, 90), (70, 40, 100, 60), (90, 30, 80, 70), (50, 100, 40, 90), (80, 60, 30, 50), (60, 90, 70, 40))
STEADY_TESTS = ((40, 80, 60, 30), (70, 50, 90, 80))
"""Speeds in percent, held one after the other; one log each."""
WORK = ((30, 80, 50, 90), (70, 40, 100, 0), (90, 30, 0, 70), (50, -80, 40, 0), (80, 0, 60, 30), (-60, 90, 0, 50))
TESTS = ((40, 80, 0, 30), (70, 50, 90, -40))
"""The same with stops and reversals, for effects that show there."""
HEALTHY = ((60, 0, 30, 90), (80, 40, -70, 50), (0, 100, 60, 20), (30, -50, 0, 80), (90, 70, 0, 40), (50, 20, 100, 0))
HEALTHY_HOLD_S = 1800.0
"""Of further logs, from which thresholds come: a rate of false alarms wants ten hours and more."""
SPEEDS = (30, 40, 50, 60, 70, 80, 90, 100)
KINDS: tuple[FaultKind | None, ...] = (None, "bearing", "brush")
"""The motors that are judged; None is healthy."""
JUDGED_S, BEGINS_AT = 9000.0, 1.0 / 3.0
"""How long motors are judged, s, and at which share of it faults begin where thresholds are derived."""


@dataclass(frozen=True)
class Surroundings:
    """What is around the motor over time: air blown at it in m/s, the room in degC, torque at the shaft in Nm."""

    airflow_m_s: Signal = 0.0
    ambient_degC: Signal = 30.0
    load_Nm: Signal = 0.0


def surroundings(effect: str, seed: int) -> Surroundings:
    """Those of one log or one judged run."""
    if effect not in SURROUNDED:
        return Surroundings()
    random = np.random.default_rng(seed)
    changes = np.cumsum(random.uniform(600.0, 1800.0, 12)).tolist()
    fan = steps(0.0, [(at, 4.0 * (k % 2 == 0)) for k, at in enumerate(changes)])
    loads = np.cumsum(random.uniform(600.0, 1800.0, 12)).tolist()
    load = steps(0.05, [(at, float(random.uniform(0.0, 0.3))) for at in loads])
    return Surroundings(fan, sine(28.0, 3.0, 5400.0, float(random.uniform(0.0, 5400.0))), load)


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
    """Run a command of `gen`; what it said, warnings last."""
    command = [sys.executable, "-m", "gen", *map(str, arguments)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"gen {arguments[0]}: {done.stderr}")
    return done.stdout + done.stderr


def commissioned(folder: Path, effect: str, kind: str, seed: int, given: Path | None) -> Path:
    """The baseline: `gen identify` on steps from cold, with the board's wiring and the rules; or the file given."""
    out = folder / "baseline.json"
    if given is not None or out.exists():
        return given or out
    runs = []
    for speed in COMMISSIONED.get(effect, ALL_SPEEDS):
        setup = Setup(sensors=sensors(seed), seed=seed + speed)
        runs.append(folder / f"cold{speed}.csv")
        profile = step(counts(speed)) if kind == "parts" else cut_off(counts(speed), 10_800.0, 3600.0)
        make_run(profile, setup).write(runs[-1])
    gen("identify", *runs, "--out", out, "--name", "as_commissioned", "--model", kind)
    document = json.loads(out.read_text(encoding="utf-8"))
    example = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    wiring = example["wiring"] | ({"channels": CHANNELS} if effect in SURROUNDED else {})
    document |= {"wiring": wiring, "alarms": RULES if kind == "parts" else []}
    out.write_text(json.dumps(document, indent=1), encoding="utf-8")
    return out


def with_thresholds(model: Path, healthy: Sequence[Path]) -> Path:
    """The file with the rules of the simulated motor's example, their numbers derived from healthy logs."""
    example = json.loads((ROOT / "examples" / "my1016_rig" / "rules.json").read_text(encoding="utf-8"))
    rules = model.with_name("rules.json")
    rules.write_text(json.dumps({"alarms": example["alarms"]}, indent=1), encoding="utf-8")
    out = model.with_name(f"{model.stem}-alarms.json")
    gen("thresholds", model, "--rules", rules, *healthy, "--out", out)
    return out


def plant(coefficients: Coefficients, motor: MotorConfig, around: Surroundings, seed: int, noise: int) -> RigPlant:
    """A motor on the board; `seed` gives the sensors their offsets, `noise` their noise."""
    wiring = coefficients.document.wiring
    assert wiring is not None
    channels = [chip.channel for chip in wiring.thermocouples]
    pulses = wiring.encoder.pulses_per_revolution if wiring.encoder else 0
    return RigPlant(
        channels,
        motor=motor,
        sensors=sensors(seed),
        ambient_degC=around.ambient_degC,
        load_Nm=around.load_Nm,
        airflow_m_s=around.airflow_m_s,
        pulses_per_revolution=pulses,
        seed=noise,
    )


def logged(
    path: Path,
    speeds: Sequence[int],
    hold_s: float,
    baseline: Coefficients,
    effect: str,
    seed: int,
    emulated: bool,
) -> Path:
    """A log of the motor at work; one that is there already is taken."""
    if path.exists():
        return path
    profile: Profile = staircase([counts(speed) for speed in speeds], hold_s)
    noise = seed + sum(speeds)
    motor, around = EFFECTS[effect], surroundings(effect, noise)
    if not emulated:
        setup = Setup(
            motor=motor,
            sensors=sensors(seed),
            channels=("speed_rpm", "current_A"),
            ambient=around.ambient_degC,
            load_Nm=around.load_Nm,
            airflow_m_s=around.airflow_m_s,
            decoys={"airflow_m_s": around.airflow_m_s},
            seed=noise,
        )
        plain = replace(setup, channels=("speed_rpm",), decoys={})
        make_run(profile, setup if effect in SURROUNDED else plain).write(path)
        return path
    firmware = build_firmware(baseline, "fixed", "table", "baseline.json", cache_folder())
    assert baseline.document.wiring is not None
    own = plant(baseline, motor, around, seed, noise)
    board = Board(firmware.elf, firmware.cache, baseline.document.wiring, own, encoder="batched")
    session = run_session(board, profile.duration_s, profile=tuple(zip(profile.starts_s, profile.levels, strict=True)))
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
    if "network" in document:
        raise SystemExit(f"gen build: {trial.stderr}")
    document["effects"] = [e for e in document["effects"] if (e["name"], e["component"]) not in held]
    out = refined.with_name("board.json")
    out.write_text(json.dumps(document, indent=1), encoding="utf-8")
    gen("build", out, "--out", refined.parent / "firmware")
    return out, sorted(f"{name} of {component}" for name, component in held)


def judged(
    coefficients: Coefficients,
    effect: str,
    seed: int,
    speeds: Sequence[int],
    duration_s: float,
    begins_s: float,
    emulated: bool,
) -> np.ndarray:
    """Time of each rule's first alarm, s since the fault began, NaN without; shape (speeds, kinds, rules)."""
    runs = [(speed, () if kind is None else (Fault(kind, begins_s),)) for speed in speeds for kind in KINDS]
    plants = [
        plant(
            coefficients,
            replace(EFFECTS[effect], faults=faults),
            surroundings(effect, 1000 + speed),
            seed,
            1000 + speed,
        )
        for speed, faults in runs
    ]
    pwm = [counts(speed) for speed, _ in runs]
    if emulated:
        rows = [
            emulated_times(coefficients, own, step(value, duration_s)) for own, value in zip(plants, pwm, strict=True)
        ]
        first = np.array(rows)
    else:
        first = alarm_times(coefficients, plants, pwm, duration_s)
    return first.reshape(len(speeds), len(KINDS), -1) - begins_s


def test_errors(
    model: Coefficients, files: Sequence[Path], test: Sequence[Path], found: Path
) -> list[dict[str, float]]:
    """`rmse_K` and `max_abs_K` on the test logs, of baseline and refined file: as `gen refine` says of a network.

    What the board cannot hold of transfer functions' effects has been left out of the refined file, and counts.
    """
    if any(load(held).model.network is not None for held in files):
        summary = json.loads(found.read_text(encoding="utf-8"))
        return [summary[when]["test"] for when in ("before", "after")]
    return [
        total(one for path in test for one in run_errors(model, load(held), path)[0].values()).summary()
        for held in files
    ]


def lines(
    before: np.ndarray,
    after: np.ndarray,
    errors: Sequence[dict[str, float]],
    names: Sequence[str],
    speeds: Sequence[int],
) -> list[tuple[str, str, str]]:
    """The table: what, before, after.

    `errors` are on test logs before and after, `names` are the rules', `speeds` those at which they were judged.
    """
    made = [
        ("RMSE of test logs", *(f"{error['rmse_K']:.2f} K" for error in errors)),
        ("worst error of test logs", *(f"{error['max_abs_K']:.2f} K" for error in errors)),
    ]
    called_at = min(speeds, key=lambda speed: abs(speed - 70))
    row = speeds.index(called_at)
    false = [[_false_at(first, c) for c in range(len(KINDS))] for first in (before, after)]
    made.append(("false alarms", *(_at({s for own in each for s in own}, speeds) for each in false)))
    for c, kind in enumerate(KINDS):
        called = [
            ", ".join(n for n, t in zip(names, first[row, c], strict=True) if not np.isnan(t))
            for first in (before, after)
        ]
        made.append((f"said at {called_at} %, {kind or 'healthy'}", *(text or "nothing" for text in called)))
        if kind is None:
            continue
        told = []
        for first, wrong in zip((before, after), false, strict=True):
            earliest = np.min(np.where(np.isnan(first[:, c]), np.inf, first[:, c]), axis=-1)
            heard = np.isfinite(earliest) & ~np.isin(np.arange(len(speeds)), list(wrong[c]))
            text = f"at {heard.sum()} of {len(speeds)} speeds"
            told.append(text + (f", after {np.median(earliest[heard]):.0f} s" if heard.any() else ""))
        made.append((f"{kind} fault detected", *told))
    return [(a, b, c) for a, b, c in made]


def _false_at(first: np.ndarray, case: int) -> set[int]:
    """Places of the speeds with an alarm of a healthy motor, or before the fault."""
    limit = np.inf if KINDS[case] is None else 0.0
    return {int(place) for place in np.flatnonzero(np.any(first[:, case] < limit, axis=-1))}


def _at(places: set[int], speeds: Sequence[int]) -> str:
    which = f" ({', '.join(f'{speeds[place]} %' for place in sorted(places))})" if places else ""
    return f"at {len(places)} of {len(speeds)} speeds{which}"


def main() -> None:
    """Go round the loop once."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--effect", choices=list(EFFECTS), default="schedule_error")
    parser.add_argument("--model", choices=("parts", "network"), default="parts")
    parser.add_argument("--logs", choices=("rig", "emulated"), default="rig")
    parser.add_argument("--judge", choices=("twin", "emulated"), default="twin")
    parser.add_argument("--baseline", type=Path, help="instead of identifying one: a coefficient file with rules")
    parser.add_argument("--scale", type=float, default=1.0, help="share of the eight logs, at least one of each kind")
    parser.add_argument("--hold", type=float, default=HOLD_S, help="how long the logs hold a speed, s")
    parser.add_argument("--accept-change", action="store_true", help="refine with it")
    parser.add_argument("--speeds", type=int, nargs="+", default=SPEEDS, help="at which alarms are judged, percent")
    parser.add_argument("--judged", type=float, default=JUDGED_S, help="for how long, s")
    parser.add_argument("--seed", type=int, default=0, help="of the board's sensors")
    parser.add_argument("--keep", type=Path, help="keep all files in this folder, and take those that are there")
    options = parser.parse_args()
    emulated = options.logs == "emulated"
    work = (STEADY, STEADY_TESTS) if options.effect == "schedule_error" else (WORK, TESTS)
    derived = options.model == "network"
    begins_s = BEGINS_AT * options.judged if derived else 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = options.keep or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        baseline = commissioned(folder, options.effect, options.model, options.seed, options.baseline)
        model = load(baseline)
        groups = [
            (key, group[: max(1, round(options.scale * len(group)))], options.hold)
            for key, group in zip(("fit", "test"), work, strict=True)
        ]
        fit, test, healthy = (
            [
                logged(folder / f"{key}{i}.csv", speeds, hold, model, options.effect, options.seed, emulated)
                for i, speeds in enumerate(group)
            ]
            for key, group, hold in (*groups, ("healthy", HEALTHY if derived else (), HEALTHY_HOLD_S))
        )
        runs: list[str | Path] = ["--fit", *fit, "--test", *test, "--out", folder / "refined.json"]
        runs += ["--accept-change"] if options.accept_change else []
        said = gen(
            "refine", baseline, *runs, "--report", folder / "report.html", "--json", folder / "refined-found.json"
        )
        print(said)
        board, dropped = for_the_board(folder / "refined.json")
        if dropped:
            print(f"not in the firmware: {', '.join(dropped)}")
        errors = test_errors(model, [baseline, board], test, folder / "refined-found.json")
        files = [with_thresholds(path, healthy) if derived else path for path in (baseline, board)]
        judges = [load(path) for path in files]
        before, after = (
            judged(
                one,
                options.effect,
                options.seed,
                options.speeds,
                options.judged,
                begins_s,
                emulated=options.judge == "emulated",
            )
            for one in judges
        )
    table = Table(options.effect, "baseline", "refined", title=f"logs: {options.logs}; alarms: {options.judge}")
    for line in lines(before, after, errors, [rule.name for rule in judges[0].document.alarms], options.speeds):
        table.add_row(*line)
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
