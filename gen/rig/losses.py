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
    stalled
        The load holds the rotor at rest against the drive.
    """

    speed: float
    duty: float
    voltage: float = 1.0
    load_Nm: float = 0.0
    stalled: bool = False


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
    """Heat at every node but the winding's copper loss, and the mean armature current.

    The current supplies the torque that friction, iron and load take; ripple and arcs are paid for by the supply beside
    that mean current.
    """
    losses, electrical, fault, s = motor.losses, motor.electrical, motor.faults, now.speed
    omega = s * electrical.rated_speed_rpm * RPM
    kept = 1.0 - condition.brush_fault * _contact_lost(fault.brush, s)
    arc = condition.brush_fault * fault.brush.arc_W * s**fault.brush.arc_exponent
    edge = condition.brush_fault * fault.brush.edge_W * s**fault.brush.edge_exponent
    brush = (
        condition.losses * condition.friction * kept * losses.brush_friction_Nm / (1.0 + s / losses.brush_friction_s0)
    )
    bearing = condition.losses * (
        losses.bearing_dry_Nm
        + losses.bearing_viscous_Nm * s
        + condition.bearing_fault * _bearing_fault(fault.bearing, s)
    )
    iron = condition.losses * (losses.iron_hysteresis_Nm + losses.iron_eddy_Nm * s)
    windage = losses.windage_W * s**3
    if now.stalled:
        current = now.duty * now.voltage * electrical.nominal_voltage_V / electrical.resistance_ohm
    elif now.duty > 0.0 and s > 0.0:
        drag = brush + bearing + iron + (windage + edge) / omega
        current = (drag + now.load_Nm) / electrical.torque_constant_Nm_per_A
    else:
        # Without drive the rotor's own energy pays for friction, for the fraction of a second that it takes.
        current = 0.0
    swing = 4.0 * now.duty * (1.0 - now.duty)
    ripple = (losses.ripple_eddy_W * swing + losses.ripple_current_W * swing**2) * now.voltage**2
    mean_V = now.duty * now.voltage * electrical.nominal_voltage_V
    # The contacts cannot take more voltage than there is.
    contact = current * losses.contact_drop_V * mean_V / (mean_V + losses.contact_drop_V) if mean_V > 0.0 else 0.0
    face = brush * omega + contact * kept
    return Heat(
        winding=(1.0 - losses.brush_keeps) * face
        + contact * (1.0 - kept)
        + iron * omega
        + (1.0 - losses.ripple_in_brush * kept - losses.ripple_in_magnet - losses.ripple_in_casing) * ripple
        + (1.0 - fault.brush.arc_in_casing) * arc,
        brush=losses.brush_keeps * face + losses.ripple_in_brush * kept * ripple + edge,
        bearing=bearing * omega,
        magnet=losses.ripple_in_magnet * ripple,
        casing=losses.ripple_in_casing * ripple + fault.brush.arc_in_casing * arc,
        air=windage,
        current_A=current,
    )


def resistance(motor: MotorParameters, winding_degC: float) -> float:
    """Resistance of the armature circuit, ohm, at the winding's temperature."""
    electrical = motor.electrical
    return electrical.resistance_ohm * (1.0 + electrical.resistance_per_K * (winding_degC - 25.0))


def settled_speed(motor: MotorParameters, duty: float, voltage: float, load_Nm: float) -> float:
    """Speed over rated speed that the drive settles at.

    In proportion to the mean voltage without load; a load torque makes it sag by R T / k**2, at most to rest.
    """
    electrical = motor.electrical
    slope = electrical.resistance_ohm / electrical.torque_constant_Nm_per_A**2 / (electrical.rated_speed_rpm * RPM)
    return max(0.0, duty * voltage - slope * load_Nm)


def _bearing_fault(fault: BearingFault, s: float) -> float:
    """Extra torque, Nm."""
    return fault.dry_Nm * (fault.rough + (1.0 - fault.rough) * math.exp(-s / fault.s0)) + fault.skid_Nm * s**2


def _contact_lost(fault: BrushFault, s: float) -> float:
    """Share of the brushes' contact and friction that is lost."""
    bounce = fault.bounce * math.exp(-(((s - fault.bounce_s) / fault.bounce_width) ** 2))
    return 1.0 - (1.0 - fault.lost) * (1.0 - bounce)
