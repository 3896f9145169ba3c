"""What the rules say of a life, by the reference of the board's own."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.alarm_hours.lives import Life, fault_lives, healthy_lives, load_lives, other_lives
from gen.coefficients import Coefficients, load
from gen.reference.run_alarms import raised_s
from gen.reference.simulate import simulate_run
from gen.rig import Setup, make_run, zeroed
from gen.rig.runs import CHANNELS
from gen.runs import Run

DEFAULT = Path(__file__).parents[2] / "examples" / "my1016_rig" / "coeffs.json"
TABLES = ("healthy", "faults", "lives", "loads")
ROOM_DEGC = 24.0


@dataclass(frozen=True)
class Heard:
    """What the rules said of a run: the time of each rule's first alarm, s."""

    life: str
    fault_s: float | None
    first_s: dict[str, float] = field(default_factory=dict)


@cache
def coefficients_of(path: Path) -> Coefficients:
    """The file, read once."""
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
        """Lives of one of the tables."""
        if name == "healthy":
            return list(healthy_lives(self.hours, self.seed, self.kinds))
        if name == "faults":
            return list(fault_lives(self.seed))
        return list(other_lives(self.seed, self.each) if name == "lives" else load_lives(self.seed, self.each))


@cache
def lives_of(campaign: Campaign, name: str) -> list[Life]:
    """In each process anew: signals over time are functions, which cannot be sent."""
    return campaign.lives(name)


def judge(campaign: Campaign, name: str, number: int) -> Heard:
    """Run the motor, and the rules on what its sensors read."""
    coefficients, life = coefficients_of(campaign.path), lives_of(campaign, name)[number]
    run = make_run(life.profile, setup_of(campaign, life)).run
    first_s: dict[str, float] = {}
    for piece in pieces(run, life.reset_s):
        shown = simulate_run(coefficients, piece, "exact", "auto", life.kind)
        degrees = {part: shown[f"{part}_degC"].astype(np.float64) for part in coefficients.model.component_names}
        first_s = raised_s(coefficients, piece, degrees) | first_s
    return Heard(life.kind, life.fault_s, first_s)


def pieces(run: Run, reset_s: float | None) -> list[Run]:
    """What a board sees of a run as one: all of it, or before and from a reset on, for which it begins anew.

    A board with copies in EEPROM, or one that is reset by its watchdog, goes on instead: this is the worst case.
    """
    if reset_s is None:
        return [run]
    return [_rows(run, run.time_s < reset_s), _rows(run, run.time_s >= reset_s)]


def _rows(run: Run, kept: NDArray[np.bool_]) -> Run:
    return replace(
        run,
        time_s=run.time_s[kept],
        pwm=run.pwm[kept],
        temps={name: values[kept] for name, values in run.temps.items()},
        ambient=None if run.ambient is None else run.ambient[kept],
        extras={name: values[kept] for name, values in run.extras.items()},
    )


def setup_of(campaign: Campaign, life: Life) -> Setup:
    """What surrounds a life, with the columns that the model reads, and sensors as their board has learnt them."""
    setup = replace(life.setup, channels=measured(coefficients_of(campaign.path)))
    if not campaign.zeroed:
        return setup
    return replace(setup, sensors=zeroed(setup.sensors, ROOM_DEGC, setup.seed))


def measured(coefficients: Coefficients) -> tuple[str, ...]:
    """The columns that a model reads beside temperatures and PWM."""
    network = coefficients.model.network
    return () if network is None else tuple(one.column for one in network.channels if one.column in CHANNELS)
