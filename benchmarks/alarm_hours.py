"""False alarms in many hours of a healthy motor, delays over a fault's severity, and faults where life is not steady.

    python -m benchmarks.alarm_hours [COEFFS] [--hours 1000] [--seed 1] [--jobs 2] [--only healthy faults lives] ..

The motor is the simulated one (`gen.rig`), the model the exact solution of COEFFS (`examples/my1016_rig/coeffs.json`),
and the rules are the reference's: `gen verify` proves them the board's on the words that the board is given; those
here differ from the board's by the error that `gen build` guarantees.

`healthy`: hours of each kind of life, with the false alarms of the level rules beside those on missing heat.
A load that comes on is heat like a fault's: its alarms are counted, but no model of PWM alone can tell.
`faults`: delay of the first alarm and the verdict for both faults at every speed, whole and at a half, a quarter and
an eighth of their severity.
`--zeroed`: each set of sensors had its offsets learnt by the board before (`$.wiring.zero`); give it a COEFFS that was
made of such runs (`examples/my1016_rig/make.py --zeroed`).
`lives`: faults in duty cycles, at changing speed, growing over hours, both at once, in a moving room, after a start.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, get_args

import numpy as np
from rich.box import MARKDOWN
from rich.console import Console
from rich.table import Table

from gen.coefficients import Coefficients, load
from gen.lowering.alarms import lower_alarms
from gen.reference.run_alarms import raised_s
from gen.reference.simulate import simulate_run
from gen.rig import Fault, MotorConfig, Profile, Setup, make_run, sensors, warm_start, zeroed
from gen.rig.config import FaultKind
from gen.rig.profiles import counts, random_levels, staircase, step
from gen.rig.signals import Signal, sine, steps, total

DEFAULT = Path(__file__).parent.parent / "examples" / "my1016_rig" / "coeffs.json"
RUN_S, FAULT_S, HOUR_S = 10_800.0, 3600.0, 3600.0
SPEEDS = tuple(range(10, 101, 10))
SEVERITIES = (1.0, 0.5, 0.25, 0.125)
KINDS: tuple[FaultKind, ...] = get_args(FaultKind)
TABLES = ("healthy", "faults", "lives")
ROOM_DEGC = 24.0
TRAINED_LOAD_NM = 0.02
"""Of the healthy runs that the example's thresholds come from."""


Making = Callable[[np.random.Generator], Profile]
Setting = Callable[[np.random.Generator], Setup]


@dataclass(frozen=True)
class Life:
    """One run: what the motor does and what surrounds it.

    Attributes
    ----------
    kind
        What it is counted under.
    profile, setup
        Of the simulated motor.
    fault_s
        When a fault begins, or None.
    """

    kind: str
    profile: Profile
    setup: Setup
    fault_s: float | None = None


@dataclass(frozen=True)
class Heard:
    """What the rules said of a run: the time of each rule's first alarm, s."""

    life: str
    fault_s: float | None
    first_s: dict[str, float] = field(default_factory=dict)


@cache
def _coefficients(path: Path) -> Coefficients:
    return load(path)


@dataclass(frozen=True)
class Campaign:
    """Which lives there are; the same numbers give the same."""

    path: Path
    hours: float
    seed: int
    each: int
    zeroed: bool = False
    kinds: tuple[str, ...] = ()

    def lives(self, name: str) -> list[Life]:
        """Lives of one of the three tables."""
        if name == "healthy":
            return list(healthy_lives(self.hours, self.seed, self.kinds))
        return list(fault_lives(self.seed)) if name == "faults" else list(other_lives(self.seed, self.each))


@cache
def _lives(campaign: Campaign, name: str) -> list[Life]:
    """In each process anew: signals over time are functions, which cannot be sent."""
    return campaign.lives(name)


def judge(campaign: Campaign, name: str, number: int) -> Heard:
    """Run the motor, and the rules on what its sensors read."""
    coefficients, life = _coefficients(campaign.path), _lives(campaign, name)[number]
    setup = life.setup
    if campaign.zeroed:
        setup = replace(setup, sensors=zeroed(setup.sensors, ROOM_DEGC, setup.seed))
    run = make_run(life.profile, setup).run
    shown = simulate_run(coefficients, run, "exact", "auto", life.kind)
    degrees = {part: shown[f"{part}_degC"].astype(np.float64) for part in coefficients.model.component_names}
    return Heard(life.kind, life.fault_s, raised_s(coefficients, run, degrees))


def _random_speed(rng: np.random.Generator) -> int:
    return counts(float(rng.uniform(10.0, 100.0)))


def _duty(rng: np.random.Generator) -> Profile:
    """Nine minutes on, one off, at one speed."""
    level = _random_speed(rng)
    on = float(rng.uniform(300.0, 900.0))
    begins = [k * (on + 60.0) for k in range(int(RUN_S // (on + 60.0)))]
    starts = [start for begin in begins for start in (begin, begin + on)]
    return Profile(tuple(starts), tuple(level * (k % 2 == 0) for k in range(len(starts))), RUN_S)


def _changing(least_s: float, most_s: float) -> Making:
    return lambda rng: random_levels(int(rng.integers(2**31)), RUN_S, hold_s=(least_s, most_s))


def _held(rng: np.random.Generator) -> Profile:
    return step(_random_speed(rng), RUN_S)


def _plain(rng: np.random.Generator, **other: Any) -> Setup:  # noqa: ANN401
    return Setup(seed=int(rng.integers(2**31)), channels=(), **({"sensors": sensors(0)} | other))


def _room(rng: np.random.Generator) -> Signal:
    """Swings by 5 K within two hours, and jumps by 4 K."""
    at, up = float(rng.uniform(2000.0, 9000.0)), float(rng.choice([-4.0, 4.0]))
    return total(sine(28.0, 2.5, 7200.0, float(rng.uniform(0.0, 7200.0))), steps(0.0, [(at, up)]))


def _noisy(rng: np.random.Generator) -> Setup:
    return _plain(rng, sensors=sensors(0, noise_K=0.2))


def _drifting(rng: np.random.Generator) -> Setup:
    plain = sensors(0)
    name = str(rng.choice([part for part in plain if part != "ambient"]))
    return _plain(rng, sensors=plain | {name: replace(plain[name], drift_K_per_h=float(rng.choice([-0.5, 0.5])))})


def _warm(rng: np.random.Generator) -> Setup:
    return _plain(rng, start_degC=warm_start(step(_random_speed(rng), float(rng.uniform(600.0, 7200.0)))))


def _loaded(rng: np.random.Generator) -> Setup:
    at = float(rng.uniform(2000.0, 9000.0))
    return _plain(rng, load_Nm=steps(0.0, [(at, float(rng.uniform(0.0, TRAINED_LOAD_NM)))]))


def _supplied(rng: np.random.Generator) -> Setup:
    nominal = MotorConfig().parameters.electrical.nominal_voltage_V
    return _plain(rng, voltage_V=sine(nominal, 0.01 * nominal, 3600.0, float(rng.uniform(0.0, 3600.0))))


def _draughty(rng: np.random.Generator) -> Setup:
    at = float(rng.uniform(2000.0, 7000.0))
    return _plain(rng, airflow_m_s=steps(0.0, [(at, 0.3), (at + 1800.0, 0.0)]))


HEALTHY: dict[str, tuple[Making, Setting]] = {
    "steady": (_held, _plain),
    "random speeds, 15 to 45 min": (_changing(900.0, 2700.0), _plain),
    "random speeds, 2 to 10 min": (_changing(120.0, 600.0), _plain),
    "duty cycles": (_duty, _plain),
    "staircase": (lambda rng: staircase([_random_speed(rng) for _ in range(6)], RUN_S / 6), _plain),
    "warm starts": (_held, _warm),
    "room: 5 K swing, 4 K jump": (_held, lambda rng: _plain(rng, ambient=_room(rng))),
    "draughts of 0.3 m/s": (_held, _draughty),
    "supply off by 1 %": (_held, _supplied),
    "other thermocouples": (_held, lambda rng: _plain(rng, sensors=sensors(int(rng.integers(1, 10**6))))),
    "noise twice as large": (_held, _noisy),
    "a sensor drifts 0.5 K/h": (_held, _drifting),
    "load steps to 2 %": (_held, _loaded),
}


def healthy_lives(hours: float, seed: int, kinds: Sequence[str] = ()) -> Iterable[Life]:
    """Runs of three hours, as many of each kind; `kinds`: of these alone."""
    kept = {kind: how for kind, how in HEALTHY.items() if not kinds or kind in kinds}
    runs = max(1, round(hours / (RUN_S / HOUR_S) / len(kept)))
    for kind, (making, setting) in kept.items():
        for number in range(runs):
            rng = np.random.default_rng([seed, *kind.encode(), number])
            yield Life(kind, making(rng), setting(rng))


def fault_lives(seed: int) -> Iterable[Life]:
    """Both faults at every speed, at all severities."""
    for severity in SEVERITIES:
        for kind in KINDS:
            for speed in SPEEDS:
                rng = np.random.default_rng([seed, speed, *kind.encode(), round(1000 * severity)])
                motor = MotorConfig(faults=(Fault(kind, FAULT_S, severity),))
                yield Life(f"{kind} {severity:g}", step(counts(speed), RUN_S), _plain(rng, motor=motor), FAULT_S)


LIVES: dict[str, tuple[Making, Setting, dict[str, float]]] = {
    "in duty cycles": (_duty, _plain, {}),
    "at changing speed": (_changing(600.0, 1800.0), _plain, {}),
    "growing over 1 h": (_held, _plain, {"ramp_s": 3600.0}),
    "growing over 10 h": (lambda rng: step(_random_speed(rng), 12 * HOUR_S), _plain, {"ramp_s": 36_000.0}),
    "in a moving room": (_held, lambda rng: _plain(rng, ambient=_room(rng)), {}),
    "ten minutes after a cold start": (_held, _plain, {"start_s": 600.0}),
    "ten minutes after a warm start": (_held, _warm, {"start_s": 600.0}),
}


def other_lives(seed: int, each: int) -> Iterable[Life]:
    """Faults where life is not steady."""
    for name, (making, setting, how) in LIVES.items():
        for number in range(each):
            rng = np.random.default_rng([seed, *name.encode(), number])
            kind = KINDS[number % 2]
            fault = Fault(kind, **({"start_s": FAULT_S} | how))
            setup = replace(setting(rng), motor=MotorConfig(faults=(fault,)))
            yield Life(f"{kind} {name}", making(rng), setup, fault.start_s)


def _is_heat(path: Path) -> dict[str, bool]:
    return {rule.name: rule.heat is not None for rule in lower_alarms(_coefficients(path))}


def healthy_table(path: Path, heard: Sequence[Heard]) -> Table:
    """False alarms per kind of life."""
    heat = _is_heat(path)
    table = Table("healthy motor", "hours", "level rules: runs with an alarm", "missing heat: runs with an alarm",
                  "a verdict among them", box=MARKDOWN)  # fmt: skip
    for kind in dict.fromkeys(item.life for item in heard):
        own = [item for item in heard if item.life == kind]
        levels = sum(any(not heat[name] for name in item.first_s) for item in own)
        heats = sum(any(heat[name] for name in item.first_s) for item in own)
        verdicts = sum(any(name.endswith("_fault") for name in item.first_s) for item in own)
        table.add_row(kind, f"{len(own) * RUN_S / HOUR_S:.0f}", str(levels), str(heats), str(verdicts))
    return table


def _delays(own: Sequence[Heard], names: Sequence[str]) -> tuple[list[float], int]:
    """Delays of the first of these rules' alarms, s, of the runs without one before the fault; and how many had one."""
    delays, early = [], 0
    for item in own:
        times = [item.first_s[name] for name in names if name in item.first_s]
        assert item.fault_s is not None
        if times and min(times) < item.fault_s:
            early += 1
        elif times:
            delays.append(min(times) - item.fault_s)
    return delays, early


def fault_table(path: Path, heard: Sequence[Heard], title: str) -> Table:
    """Delays and verdicts by kind of fault."""
    heat = _is_heat(path)
    table = Table(title, "runs", "level rules: heard", "after (s): median, worst", "missing heat: heard",
                  "after (s): median, worst", "early", "told right", box=MARKDOWN)  # fmt: skip
    for kind in dict.fromkeys(item.life for item in heard):
        own = [item for item in heard if item.life == kind]
        cells = [kind, str(len(own))]
        for wanted in (False, True):
            delays, early = _delays(own, [name for name, is_heat in heat.items() if is_heat == wanted])
            spread = f"{np.median(delays):.0f}, {max(delays):.0f}" if delays else ""
            cells += [str(len(delays)), spread]
        right, wrong = f"{kind.split()[0]}_fault", {"bearing": "brush_fault", "brush": "bearing_fault"}[kind.split()[0]]
        told = sum(right in item.first_s and not item.first_s.get(wrong, np.inf) <= item.first_s[right] for item in own)
        table.add_row(*cells, str(early), str(told))
    return table


def main() -> None:
    """Run the campaign and print its tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("coefficients", type=Path, nargs="?", default=DEFAULT)
    parser.add_argument("--hours", type=float, default=1000.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--each", type=int, default=10, help="runs of each life with a fault")
    parser.add_argument("--only", nargs="+", choices=TABLES, default=TABLES)
    parser.add_argument("--zeroed", action="store_true", help="the board has learnt its sensors' offsets before")
    parser.add_argument("--kinds", nargs="+", choices=[*HEALTHY], default=[], help="of healthy hours; without it all")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    kinds = tuple(options.kinds)
    campaign = Campaign(options.coefficients, options.hours, options.seed, options.each, options.zeroed, kinds)
    console, found = Console(width=250), {}
    with ProcessPoolExecutor(options.jobs) as pool:
        for name in options.only:
            numbers = range(len(campaign.lives(name)))
            heard = list(pool.map(judge, [campaign] * len(numbers), [name] * len(numbers), numbers, chunksize=4))
            found[name] = [{"kind": item.life, "fault_s": item.fault_s, "first_s": item.first_s} for item in heard]
            table = (
                healthy_table(options.coefficients, heard)
                if name == "healthy"
                else fault_table(options.coefficients, heard, "fault")
            )
            console.print(table, highlight=False)
    if options.json is not None:
        options.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
