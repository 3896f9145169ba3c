"""Friction, iron, ripple and copper: which node gets how much heat, and how much torque it takes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gen.rig.parameters import BearingFault, BrushFault, MotorParameters

RPM = math.pi / 30.0  #: rad/s per rpm


@dataclass(frozen=True)
class Operation:
    """What the motor is doing.

    Attributes
    ----------
    speed
        Mean speed over rated speed, >= 0.
    duty
        PWM duty, 0..1.
    voltage
        Supply over nominal voltage.
    load_Nm
        Torque at the shaft.
    """

    speed: float
    duty: float
    voltage: float = 1.0
    load_Nm: float = 0.0


@dataclass(frozen=True)
class Condition:
    """What is unusual about the motor now.

    Attributes
    ----------
    bearing_fault, brush_fault
        Severity, 0..1.
    friction
        Factor on brush friction (direction of rotation, wear).
    losses
        Factor on every mechanical and iron loss (temperature).
    """

    bearing_fault: float = 0.0
    brush_fault: float = 0.0
    friction: float = 1.0
    losses: float = 1.0


HEALTHY = Condition()


@dataclass(frozen=True)
class Heat:
    """Heat that does not depend on the winding's temperature, W, and the current, A."""

    winding: float
    brush: float
    bearing: float
    magnet: float
    casing: float
    air: float
    current_A: float

    @property
    def nodes(self) -> tuple[float, float, float, float, float, float]:
        """In the order of `gen.rig.parameters.NODES`."""
        return (self.winding, self.brush, self.bearing, self.magnet, self.casing, self.air)


def heat(motor: MotorParameters, now: Operation, condition: Condition = HEALTHY) -> Heat:
    """Heat at every node but the winding's copper loss (`copper`), and the mean armature current.

    What friction and iron take as torque at the shaft the current supplies, so that the heat here and in `copper`,
    and the shaft's power, add up to the electrical power.
    """
    losses, electrical, s = motor.losses, motor.electrical, now.speed
    omega = s * electrical.rated_speed_rpm * RPM
    lost, arc, edge = _brush_fault(motor.faults.brush, s)
    kept = 1.0 - condition.brush_fault * lost
    brush = condition.losses * condition.friction * kept * losses.brush_friction_Nm / (1.0 + s / losses.brush_friction_s0)
    bearing = condition.losses * (
        losses.bearing_dry_Nm
        + losses.bearing_viscous_Nm * s
        + condition.bearing_fault * _bearing_fault(motor.faults.bearing, s)
    )
    iron = condition.losses * (losses.iron_hysteresis_Nm + losses.iron_eddy_Nm * s)
    windage = losses.windage_W * s**3
    arc *= condition.brush_fault
    edge *= condition.brush_fault
    drag = brush + bearing + iron + ((windage + arc + edge) / omega if omega > 0.0 else 0.0)
    if omega > 0.0:
        current = (drag + now.load_Nm) / electrical.torque_constant_Nm_per_A
    else:
        # At rest, friction and load hold the rotor; the current is what drives against them, limited by the winding.
        current = now.duty * now.voltage * electrical.nominal_voltage_V / electrical.resistance_ohm
    swing = 4.0 * now.duty * (1.0 - now.duty)
    ripple = (losses.ripple_eddy_W * swing + losses.ripple_current_W * swing**2) * now.voltage**2
    face = brush * omega + losses.contact_drop_V * current * kept
    return Heat(
        winding=(1.0 - losses.brush_keeps) * face
        + losses.contact_drop_V * current * (1.0 - kept)
        + iron * omega
        + (1.0 - losses.ripple_in_brush * kept - losses.ripple_in_magnet - losses.ripple_in_casing) * ripple
        + (1.0 - motor.faults.brush.arc_in_casing) * arc,
        brush=losses.brush_keeps * face + losses.ripple_in_brush * kept * ripple + edge,
        bearing=bearing * omega,
        magnet=losses.ripple_in_magnet * ripple,
        casing=losses.ripple_in_casing * ripple + motor.faults.brush.arc_in_casing * arc,
        air=windage,
        current_A=current,
    )


def resistance(motor: MotorParameters, winding_degC: float) -> float:
    """Resistance of the armature circuit, ohm, at the winding's temperature."""
    electrical = motor.electrical
    return electrical.resistance_ohm * (1.0 + electrical.resistance_per_K * (winding_degC - 25.0))


def no_load_speed(motor: MotorParameters, duty: float, voltage: float) -> float:
    """Speed over rated speed that the drive settles at without load: in proportion to the mean voltage."""
    return duty * voltage


def settled_speed(motor: MotorParameters, duty: float, voltage: float, load_Nm: float) -> float:
    """Speed over rated speed that the drive settles at; a load torque makes it sag by R T / k**2, at most to rest."""
    electrical = motor.electrical
    slope = electrical.resistance_ohm / electrical.torque_constant_Nm_per_A**2 / (electrical.rated_speed_rpm * RPM)
    return max(0.0, duty * voltage - slope * load_Nm)


def _bearing_fault(fault: BearingFault, s: float) -> float:
    """Extra torque, Nm."""
    return fault.dry_Nm * (fault.rough + (1.0 - fault.rough) * math.exp(-s / fault.s0)) + fault.skid_Nm * s**2


def _brush_fault(fault: BrushFault, s: float) -> tuple[float, float, float]:
    """Share of contact lost, heat of arcs and heat of the rubbing edge, W."""
    bounce = fault.bounce * math.exp(-(((s - fault.bounce_s) / fault.bounce_width) ** 2))
    return 1.0 - (1.0 - fault.lost) * (1.0 - bounce), fault.arc_W * s**fault.arc_exponent, fault.edge_W * s**fault.edge_exponent
