"""What the simulated motor is made of: masses, heat paths, losses, winding and faults, with units in the names.

The values of the MY1016 stand in ``my1016.json`` beside this module; ``python -m gen.rig.calibrate`` writes it.
"""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from gen.errors import InputError

#: Nodes of the network, in the order of every state vector; `HIDDEN` comes behind them when it is configured.
NODES = ("winding", "brush", "bearing", "magnet", "casing", "air")
HIDDEN = "hidden"
AMBIENT = "ambient"

#: The nodes that the study fitted thermocouples to.
MEASURED = ("brush", "bearing", "magnet", "casing")

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class HeatPath(_Part):
    """Heat conducted or convected between two nodes: ``still + forced * s**exponent``, s = speed / rated speed.

    Forced convection's Nusselt number grows with the Reynolds number to a power of 0.5 (laminar) to 0.8 (turbulent).
    """

    a: str
    b: str
    still_W_per_K: NotNegative
    forced_W_per_K: NotNegative = 0.0
    exponent: Positive = 0.8


class Losses(_Part):
    """Where heat comes from. s is speed / rated speed, d the PWM's duty, v the supply / nominal voltage."""

    #: Brush friction torque: falls with speed as ``torque / (1 + s / s0)``, since carbon glides on an air film.
    brush_friction_Nm: Positive
    brush_friction_s0: Positive
    #: Voltage across the sliding contacts, ``u * drop / (u + drop)`` at mean voltage u; times the current it is heat.
    contact_drop_V: Positive
    #: What the brushes keep of the heat made at their faces; the commutator (winding) takes the rest.
    brush_keeps: Share
    #: Bearing friction torque ``dry + viscous * s``.
    bearing_dry_Nm: NotNegative
    bearing_viscous_Nm: NotNegative
    #: Armature iron: hysteresis torque and eddy current torque ``hysteresis + eddy * s``.
    iron_hysteresis_Nm: NotNegative
    iron_eddy_Nm: NotNegative
    #: Stirring the inner air, W at rated speed, grows with the cube of speed.
    windage_W: NotNegative
    #: Losses by the PWM's alternating part, with ``w = 4 d (1 - d)``. Its mean square voltage is V**2 d (1 - d) and
    #: drives eddy currents: ``eddy * w * v**2``. The current's ripple V d (1 - d) / (L f) heats by its square:
    #: ``current * w**2 * v**2``. Shares of brush contacts, magnet and yoke (casing); the armature has the rest.
    ripple_eddy_W: NotNegative
    ripple_current_W: NotNegative
    ripple_in_brush: Share
    ripple_in_magnet: Share
    ripple_in_casing: Share


class Electrical(_Part):
    """Winding and drive."""

    nominal_voltage_V: Positive
    rated_speed_rpm: Positive
    torque_constant_Nm_per_A: Positive
    #: Armature, leads and driver at 25 degC.
    resistance_ohm: Positive
    resistance_per_K: NotNegative
    #: Rotor and driver together follow a step of PWM with this time constant.
    spin_time_constant_s: Positive


class BearingFault(_Part):
    """A degreased, corroded bearing: extra friction torque at full severity.

    ``dry * (rough + (1 - rough) * exp(-s / s0)) + wet * s**2``: without grease the contact is dry at low speed, partly
    carried by what film is left at higher speed, and the rollers' skidding grows from there.
    """

    dry_Nm: NotNegative
    rough: Share
    s0: Positive
    skid_Nm: NotNegative


class BrushFault(_Part):
    """One chipped brush of four, at full severity.

    Part of contact and friction is `lost` at any speed; around `bounce_s` the chipped brush resonates on its spring
    and lifts off more. Where its contact breaks, heat moves from the brushes into the commutator (arcs, in the
    winding's node) and, by the current's ripple, into the yoke. At high speed its edge and debris rub.
    """

    lost: Share
    bounce: Share
    bounce_s: Positive
    bounce_width: Positive
    arc_W: NotNegative
    arc_exponent: Positive
    arc_in_casing: Share
    edge_W: NotNegative
    edge_exponent: Positive


class Faults(_Part):
    """Both faults of the study."""

    bearing: BearingFault
    brush: BrushFault


class MotorParameters(_Part):
    """One motor."""

    about: str = ""
    capacities_J_per_K: dict[str, Positive]
    paths: tuple[HeatPath, ...]
    losses: Losses
    electrical: Electrical
    faults: Faults

    def path(self, a: str, b: str) -> HeatPath:
        """Look up the heat path between two nodes; KeyError when there is none."""
        for path in self.paths:
            if {path.a, path.b} == {a, b}:
                return path
        raise KeyError(f"{a}-{b}")


def parse(text: str, file: str | None = None) -> MotorParameters:
    """Read parameters from JSON text.

    Raises
    ------
    InputError
        With the place of the first fault.
    """
    try:
        return MotorParameters.model_validate(json.loads(text))
    except ValueError as error:
        raise InputError(f"not a motor's parameters: {error}", file=file) from error


@cache
def my1016() -> MotorParameters:
    """The motor of the study, as calibrated."""
    return parse((resources.files("gen.rig") / "my1016.json").read_text(encoding="utf-8"), "my1016.json")
