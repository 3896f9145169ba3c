"""What a simulated motor does, and what surrounds it: healthy lives of all kinds, and faults at any time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

import numpy as np

from examples.my1016_rig.make import loads
from gen.rig import Fault, MotorConfig, Profile, Setup, sensors, warm_start
from gen.rig.config import FaultKind
from gen.rig.profiles import counts, random_levels, staircase, step
from gen.rig.signals import Signal, sine, steps, total

RUN_S, FAULT_S, HOUR_S = 10_800.0, 3600.0, 3600.0
SPEEDS = tuple(range(10, 101, 10))
SEVERITIES = (1.0, 0.5, 0.25, 0.125)
KINDS: tuple[FaultKind, ...] = get_args(FaultKind)
TRAINED_LOAD_NM = 0.02
"""Of the healthy runs that the example's thresholds come from."""
LOADS_NM = (0.02, 0.05, 0.1, 0.2)
"""A fault of the bearing takes 0.04 Nm."""


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
    reset_s
        When the board loses its power for a moment, or None: it knows nothing of before, and the motor runs on.
    """

    kind: str
    profile: Profile
    setup: Setup
    fault_s: float | None = None
    reset_s: float | None = None


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
    "resets at one speed": (_held, _plain),
    "resets, speeds of 15 to 45 min": (_changing(900.0, 2700.0), _plain),
}


def _reset(kind: str, rng: np.random.Generator) -> float | None:
    return float(rng.uniform(1800.0, 9000.0)) if kind.startswith("resets") else None


def healthy_lives(hours: float, seed: int, kinds: Sequence[str] = ()) -> Iterable[Life]:
    """Runs of three hours, as many of each kind; `kinds`: of these alone."""
    kept = {kind: how for kind, how in HEALTHY.items() if not kinds or kind in kinds}
    runs = max(1, round(hours / (RUN_S / HOUR_S) / len(kept)))
    for kind, (making, setting) in kept.items():
        for number in range(runs):
            rng = np.random.default_rng([seed, *kind.encode(), number])
            yield Life(kind, making(rng), setting(rng), reset_s=_reset(kind, rng))


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
    "half an hour after a reset": (_held, _plain, {}),
}
RESET_S = FAULT_S - 1800.0


def other_lives(seed: int, each: int) -> Iterable[Life]:
    """Faults where life is not steady."""
    for name, (making, setting, how) in LIVES.items():
        for number in range(each):
            rng = np.random.default_rng([seed, *name.encode(), number])
            kind = KINDS[number % 2]
            fault = Fault(kind, **({"start_s": FAULT_S} | how))
            setup = replace(setting(rng), motor=MotorConfig(faults=(fault,)))
            reset_s = RESET_S if name.endswith("reset") else None
            yield Life(f"{kind} {name}", making(rng), setup, fault.start_s, reset_s)


def load_lives(seed: int, each: int) -> Iterable[Life]:
    """Loads that come and go, at a speed that is held, alone and with both faults; the largest load first."""
    for load in sorted(LOADS_NM, reverse=True):
        for name, kind in (("healthy", None), *((str(kind), kind) for kind in KINDS)):
            for number in range(each):
                rng = np.random.default_rng([seed, round(1000 * load), *name.encode(), number])
                motor = MotorConfig() if kind is None else MotorConfig(faults=(Fault(kind, FAULT_S),))
                setup = _plain(rng, motor=motor, load_Nm=loads(rng, load))
                yield Life(f"{name}, loads to {load:g} Nm", _held(rng), setup, None if kind is None else FAULT_S)
