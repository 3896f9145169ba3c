"""One simulated motor's settings: its parameters, its faults, and what makes it differ from the identified one.

Each deviation is a parameter of the physics whose default leaves the motor as calibrated; they combine freely.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from gen.rig.parameters import AMBIENT, HIDDEN, NODES, HeatPath, MotorParameters, my1016

FaultKind = Literal["bearing", "brush"]


@dataclass(frozen=True)
class Fault:
    """A degreased bearing or a chipped brush.

    Attributes
    ----------
    kind
        ``bearing`` or ``brush``.
    start_s
        Time at which it begins.
    severity
        0 (none) to 1 (as in the study).
    ramp_s
        Time over which it grows to `severity`; 0: at once.
    """

    kind: FaultKind
    start_s: float = 0.0
    severity: float = 1.0
    ramp_s: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in ("bearing", "brush"):
            raise ValueError(f"unknown fault {self.kind!r}; expected bearing or brush")
        if not 0.0 <= self.severity <= 1.0 or self.ramp_s < 0.0:
            raise ValueError("expected a severity of 0..1 and a ramp of at least 0 s")

    def at(self, time_s: float) -> float:
        """Severity at a time."""
        if time_s < self.start_s:
            return 0.0
        if time_s >= self.start_s + self.ramp_s:
            return self.severity
        return self.severity * (time_s - self.start_s) / self.ramp_s


@dataclass(frozen=True)
class HiddenPart:
    """A hot part that carries no sensor: it takes over a share of one node's heat and passes it on later.

    Settled temperatures stay as they are when it passes the heat to the very node that it took it from; after cut-off
    that node then goes on being heated.

    Attributes
    ----------
    heat_from
        Whose heat it takes.
    share
        Part of that heat that is made in the hidden part instead, 0..1.
    node
        The neighbour that it passes heat to.
    capacity_J_per_K, conductance_W_per_K
        Its heat capacity, and the heat path to the neighbour.
    """

    heat_from: str = "brush"
    share: float = 0.9
    node: str = "brush"
    capacity_J_per_K: float = 30.0
    conductance_W_per_K: float = 0.05


@dataclass(frozen=True)
class MotorConfig:
    """A motor to simulate.

    Attributes
    ----------
    parameters
        Masses, heat paths, losses.
    faults
        Any number; severities of one kind add up, to 1 at most.
    hidden
        A hot part without a sensor.
    coupling
        Further heat paths between nodes, or from a node to ambient.
    standstill_cooling
        Factor on the heat paths to ambient at rest; its influence fades with exp(-s / 0.02) as the rotor turns.
    radiating_area_m2
        Emissivity times area of casing that radiates beyond what the linear heat path holds, m2.
    loss_per_K
        Relative growth of friction and iron losses per kelvin of the bearing over 30 degC (negative: thinner grease).
    reverse_losses
        Factor on friction and iron losses when the rotor turns backwards (brushes off the neutral axis).
    wear_per_hour
        Relative growth of the brushes' friction per hour of running.
    airflow_per_m_s
        Relative growth of the casing's heat path to ambient per m/s of air blown over it.
    max_step_s
        Longest step of integration, s.
    """

    parameters: MotorParameters = field(default_factory=my1016)
    faults: tuple[Fault, ...] = ()
    hidden: HiddenPart | None = None
    coupling: tuple[HeatPath, ...] = ()
    standstill_cooling: float = 1.0
    radiating_area_m2: float = 0.0
    loss_per_K: float = 0.0
    reverse_losses: float = 1.0
    wear_per_hour: float = 0.0
    airflow_per_m_s: float = 0.5
    max_step_s: float = 0.25

    def __post_init__(self) -> None:
        if not 0.0 < self.max_step_s <= 5.0:
            raise ValueError(f"max_step_s is {self.max_step_s}; expected more than 0 and at most 5 s")
        for name in ("standstill_cooling", "radiating_area_m2", "reverse_losses", "wear_per_hour", "airflow_per_m_s"):
            value = getattr(self, name)
            if not math.isfinite(value) or value < 0.0:
                raise ValueError(f"{name} is {value}; expected a number that is not negative")
        known = {*self.nodes, AMBIENT}
        for path in self.coupling:
            if not {path.a, path.b} <= known or path.a == path.b:
                raise ValueError(f"no heat path can join {path.a!r} and {path.b!r}; expected two of {sorted(known)}")
        hidden = self.hidden
        if hidden is not None and not ({hidden.node, hidden.heat_from} <= set(NODES) and 0.0 <= hidden.share <= 1.0):
            raise ValueError(f"expected nodes among {NODES} and a share of 0..1 for the hidden part")

    @property
    def nodes(self) -> tuple[str, ...]:
        """Names of the state vector's entries."""
        return (*NODES, HIDDEN) if self.hidden is not None else NODES

    def severity(self, kind: FaultKind, time_s: float) -> float:
        """Severity of one kind of fault at a time."""
        return min(1.0, sum(fault.at(time_s) for fault in self.faults if fault.kind == kind))
