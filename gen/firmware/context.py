"""The contexts of the model's library, group by group."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gen.coefficients import Coefficients
from gen.firmware.contexts.alarms import AlarmsContext, alarms_context
from gen.firmware.contexts.effects import EffectsContext, effects_context
from gen.firmware.contexts.forecast import ForecastContext, forecast_context
from gen.firmware.contexts.identity import Identity, identity
from gen.firmware.contexts.model import ModelContext, model_context
from gen.firmware.contexts.network import NetworkContext, network_context
from gen.firmware.contexts.protection import ProtectionContext, protection_context
from gen.firmware.contexts.schedule import ScheduleContext, schedule_context
from gen.lowering.alarms import lower_alarms
from gen.lowering.forecast import lower_forecast
from gen.lowering.program import Program
from gen.lowering.protection import lower_protection

#: What one template is told.
Names = Mapping[str, object]


@dataclass(frozen=True)
class LibraryContext:
    """What the library's templates are told, each group of them its own part beside the identity.

    Attributes
    ----------
    identity
        For every template.
    model, schedule, alarms, effects
        For the group of that name; `effects` is None without any, which the model's own templates ask for, too.
    protection
        Causes and actions; without entries nothing of it is emitted.
    forecast
        The model run ahead; None where the file does not ask for it.
    network
        A network's own; None with transfer functions, whose schedule is then None.
    """

    identity: Identity
    model: ModelContext
    schedule: ScheduleContext | None
    alarms: AlarmsContext
    effects: EffectsContext | None
    protection: ProtectionContext
    forecast: ForecastContext | None
    network: NetworkContext | None = None

    @property
    def name(self) -> str:
        """The model's name."""
        return self.identity["name"]

    def of_model(self) -> Names:
        """For interface, state and recursion."""
        own: Names = self.network if self.network is not None else {}
        hidden = self.forecast is not None and self.forecast["hidden"]
        return {**self.identity, **self.model, **own, "effects": self.effects, "reads_hidden": hidden}

    def of_schedule(self) -> Names:
        """For the schedule."""
        return {**self.identity, **(self.schedule or {})}

    def of_alarms(self) -> Names:
        """For the alarm rules, and for what follows from them."""
        return {**self.identity, **self.alarms, **self.protection, "forecast": self.forecast}

    @property
    def protects(self) -> bool:
        """Whether the board acts on anything."""
        return self.protection["protections"] > 0

    def of_effects(self) -> Names:
        """For the effects."""
        told = {"channels": self.model["channels"], "ambient_drive": self.model["ambient_drive"]}
        return {**self.identity, **told, "effects": self.effects}


def project_context(coefficients: Coefficients, program: Program, source_name: str) -> LibraryContext:
    """What the templates of one project's library need.

    Parameters
    ----------
    coefficients, program
        What is emitted.
    source_name
        The coefficient file's name as comments show it.

    Raises
    ------
    CheckFailed
        If the table of coefficients is larger than the board's compiler takes.
    """
    return LibraryContext(
        identity(coefficients, program, source_name),
        model_context(program),
        schedule_context(program) if program.network is None else None,
        alarms_context(lower_alarms(coefficients), program.model),
        effects_context(program),
        protection_context(coefficients.document, lower_protection(coefficients)),
        forecast_context(program, lower_forecast(coefficients, program)),
        network_context(program) if program.network is not None else None,
    )
