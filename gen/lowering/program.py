"""What the board holds: the one description that the templates print and the reference simulators execute."""

from __future__ import annotations

from dataclasses import dataclass

from gen.lowering.effects import EffectsProgram
from gen.lowering.effects.channels import channels
from gen.lowering.effects.program import Channel
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.float32 import FloatComponent
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.network.program import NetworkProgram, NodeComponent
from gen.lowering.onboard import OnboardComponent
from gen.model import ThermalModel
from gen.model.effects.channel_ranges import channel_ranges

AnyComponent = FixedComponent | FloatComponent


@dataclass(frozen=True)
class Shape:
    """Components that the same code advances: they differ in their coefficients only.

    Attributes
    ----------
    identifier
        A capital letter, or the only member's name.
    members
        Indices into the program's components.
    """

    identifier: str
    members: tuple[int, ...]

    @property
    def place(self) -> str:
        """Name of the array in the board's state."""
        return self.identifier.lower()


@dataclass(frozen=True)
class Program:
    """What the board holds, all of it.

    Attributes
    ----------
    arithmetic, schedule
        Which of the four combinations.
    model
        What was lowered.
    components
        In the order of the coefficient file.
    shapes
        In the order of the board's state.
    onboard
        How the board computes each component's coefficients; empty for a table.
    effects
        What runs after the baseline's step; None without effects.
    network
        The whole model, where it is a network; then there are no components and no shapes.
    """

    arithmetic: Arithmetic
    schedule: ScheduleKind
    model: ThermalModel
    components: tuple[AnyComponent, ...]
    shapes: tuple[Shape, ...]
    onboard: tuple[OnboardComponent, ...] = ()
    effects: EffectsProgram | None = None
    network: NetworkProgram | None = None

    @property
    def parts(self) -> tuple[AnyComponent | NodeComponent, ...]:
        """What temperatures are given out of: components, or a network's sensed nodes."""
        return self.components if self.network is None else self.network.components()

    @property
    def channels(self) -> tuple[Channel, ...]:
        """What the board is told beside the PWM, the ambient first; empty where it is told nothing."""
        if self.network is not None:
            return self.network.channels
        if self.effects is not None:
            return self.effects.channels
        return channels(channel_ranges(self.model, (), {})) if self.model.ambient_passes else ()

    @property
    def ambient(self) -> Channel | None:
        """The ambient whose changes pass the components' dynamics; its neutral value is what their rises count from."""
        return self.channels[0] if self.model.ambient_passes else None

    @property
    def label(self) -> str:
        """The combination for people."""
        return f"{self.arithmetic}/{self.schedule}"

    @property
    def saturates(self) -> bool:
        """Whether any component has no proof and saturates."""
        return any(component.saturates for component in self.components)
