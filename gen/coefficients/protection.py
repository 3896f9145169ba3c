"""What the board does when something is wrong: causes, actions, and how each of them ends."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from gen.coefficients.base import Celsius, Name, Note, NotNegative, Part, fault
from gen.model.dynamics import MAX_PWM

Cause = Literal[
    "alarm",
    "sensor_lost",
    "sensor_unseen",
    "ambient_lost",
    "too_few_sensors",
    "stall",
    "overspeed",
    "turning_without_command",
    "limit_near",
    "late_loop",
    "command_timeout",
    "flash_check",
    "ram_check",
    "cpu_check",
    "clock_check",
    "eeprom_check",
    "not_commissioned",
    "supply_low",
]
"""An alarm rule that is raised; thermocouples whose samples are not believed, or were not since the start; what the
encoder says; what the model says of the time to come; the sketch's own time, line and self tests; nobody has
commissioned this wiring; the board's own supply."""

Action = Literal["log", "led", "derate", "stop", "open_relay"]
"""An event on the serial line; the LED; a lower PWM; PWM 0; the relay's opening: each beside those before it."""

Until = Literal["itself", "command", "cool"]
"""An action ends when its cause has ended; or then, by command; or then, by command, once the part has cooled down."""

Derating = Annotated[
    Annotated[int, Field(ge=0, le=MAX_PWM), Tag("tag:counts")] | Annotated[Literal["holdable"], Tag("tag:word")],
    Discriminator(lambda value: "tag:word" if isinstance(value, str) else "tag:counts"),
]
"""Counts; or the PWM that the forecast says can be held."""

#: The board keeps a bit for each entry.
MOST_PROTECTIONS = 32

_ONLY = {
    "rule": ("alarm",),
    "channel": ("sensor_lost",),
    "least": ("too_few_sensors",),
}
"""Keys that belong to one cause each."""


class Protection(Part):
    """A cause, and what the board does about it."""

    cause: Cause
    name: Annotated[
        Name | None, Field(description="What the serial line calls it; without it made of the cause and what it is of.")
    ] = None
    rule: Annotated[str | None, Field(description="Of an alarm: the rule's name.")] = None
    channel: Annotated[
        str | None,
        Field(description="Of a lost sensor: its channel; without it any part that a stopping rule watches."),
    ] = None
    least: Annotated[
        int | None, Field(ge=1, le=17, description="Of too few sensors: fewer parts believed than this.")
    ] = None
    delay_s: Annotated[NotNegative, Field(le=1e5, description="The cause must hold this long, in s.")] = 0.0
    action: Action
    derate_pwm: Annotated[
        Derating | None,
        Field(description='The largest |PWM| while derated, in counts; "holdable": what $.forecast says can be held.'),
    ] = None
    until: Until = "itself"
    component: Annotated[
        str | None, Field(description="Whose cooling is waited for; without it that of the alarm's rule.")
    ] = None
    restart_below_degC: Annotated[
        Celsius | None, Field(description="The part has cooled down once it is measured below this.")
    ] = None
    pause_s: Annotated[
        NotNegative,
        Field(
            le=1e5,
            description="No command ends what comes again soon before this long, in s; each time twice as long.",
        ),
    ] = 0.0
    note: Note | None = None

    @property
    def stops(self) -> bool:
        """Whether the motor stands while it acts."""
        return self.action in ("stop", "open_relay")

    @property
    def holds(self) -> bool:
        """Whether the motor is held at what the forecast says can be held while it acts."""
        return self.derate_pwm == "holdable"

    @property
    def label(self) -> str:
        """Its name, as given or as made of the cause."""
        if self.name is not None:
            return self.name
        of = self.rule or self.channel
        if self.cause == "alarm":
            return str(of)
        return self.cause if of is None else f"{self.cause}_{of}"

    @model_validator(mode="after")
    def _check(self) -> Protection:
        for key, causes in _ONLY.items():
            given = getattr(self, key) is not None
            if given and self.cause not in causes:
                raise fault(f'only "{causes[0]}" has it, and this is "{self.cause}"', key)
            if not given and self.cause in causes and key != "channel":
                raise fault(f'missing key "{key}", which the cause "{self.cause}" needs')
        if (self.action == "derate") != (self.derate_pwm is not None):
            raise fault('expected "derate_pwm" with the action "derate", and with no other', "derate_pwm")
        if (self.until == "cool") != (self.restart_below_degC is not None):
            raise fault('expected "restart_below_degC" with "until": "cool", and with no other', "restart_below_degC")
        if self.pause_s and self.until == "itself":
            raise fault('expected only with "until": "command" or "cool"', "pause_s")
        if self.component is not None and self.until != "cool":
            raise fault('expected only with "until": "cool"', "component")
        if self.cause == "not_commissioned" and self.until != "itself":
            raise fault(f'found "{self.until}": what ends it is a commissioning; expected "itself"', "until")
        if self.until == "cool" and self.component is None and self.cause != "alarm":
            raise fault('missing key "component": of which part is the cooling?')
        return self
