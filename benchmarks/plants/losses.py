"""What a brushed motor turns into heat, by the share of full PWM: friction, windage, iron, ripple, copper, brushes.

The friction torque is Stribeck's with a viscous part (Armstrong-Helouvry, Dupont, Canudas de Wit, "A survey of models,
analysis tools and compensation methods for the control of machines with friction", Automatica 30, 1994); iron losses
are Steinmetz's with an exponent of their own for hysteresis and eddy currents; the current of a chopped winding ripples
with D (1 - D) (any text on buck converters), and its losses with a power of that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

COPPER_PER_K = 0.0039
"""Temperature coefficient of copper's resistance at 25 degC, 1/K."""
COPPER_REFERENCE = 25.0
"""degC"""


@dataclass(frozen=True)
class Losses:
    """A motor's losses by the share of full PWM, relative to each other; a plant scales them to watts.

    Parameters
    ----------
    droop
        Share of its speed that the motor loses to its resistance at full PWM.
    coulomb, breakaway, stribeck, viscous
        Friction torque: sliding, at the start, the speed over which one goes over into the other, and what full speed
        adds.
    air
        Windage at full speed.
    hysteresis, eddy, iron_exponent
        Iron losses at full speed, and the exponent of the eddy currents' ones.
    load
        Torque of what the motor drives, whatever its speed.
    resistance, ripple, ripple_exponent
        Copper loss at a current of one, its ripple's at D = 1/2, and the exponent of D (1 - D) in it.
    drop
        Brush voltage at a current of one; it hardly grows above it.
    supply
        Voltage, as a share of the rated one: speed follows it, and what the chopped winding's ripple loses its square.
    """

    droop: float
    coulomb: float
    breakaway: float
    stribeck: float
    viscous: float
    air: float
    hysteresis: float
    eddy: float
    iron_exponent: float
    load: float
    resistance: float
    ripple: float
    ripple_exponent: float
    drop: float
    supply: float = 1.0

    def speed(self, duty: float) -> float:
        """Share of full speed."""
        mean = duty * self.supply
        return mean * (1.0 - self.droop * mean) / (1.0 - self.droop)

    def torque(self, speed: float) -> float:
        """Friction torque while turning, relative."""
        start = (self.breakaway - self.coulomb) * np.exp(-((speed / self.stribeck) ** 1.5))
        return float(self.coulomb + start + self.viscous * speed)

    def current(self, duty: float) -> float:
        """Mean current, relative; none at rest."""
        if duty == 0.0:
            return 0.0
        speed = self.speed(duty)
        iron = self.hysteresis + self.eddy * speed ** (self.iron_exponent - 1.0)
        return float(self.load + self.torque(speed) + self.air * speed**2 + iron)

    def friction(self, duty: float) -> float:
        """Heat of the bearings and of the brushes' rubbing."""
        speed = self.speed(duty)
        return self.torque(speed) * speed

    def windage(self, duty: float) -> float:
        """Heat of the air that the rotor stirs."""
        return self.air * self.speed(duty) ** 3

    def iron(self, duty: float) -> float:
        """Heat of the laminations."""
        speed = self.speed(duty)
        return float(self.hysteresis * speed + self.eddy * speed**self.iron_exponent)

    def copper(self, duty: float) -> float:
        """Heat of the winding at 25 degC."""
        chopped = (4.0 * duty * (1.0 - duty)) ** self.ripple_exponent
        return float(self.resistance * self.current(duty) ** 2 + self.ripple * chopped * self.supply**2)

    def brush(self, duty: float) -> float:
        """Heat of the current's way through the brushes."""
        current = self.current(duty)
        return float(self.drop * current * (1.0 - np.exp(-3.0 * current)))
