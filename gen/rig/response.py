"""Steps of PWM from cold and settled temperatures at a held speed, solved exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.rig.losses import HEALTHY, Condition, Heat, Operation, heat, resistance
from gen.rig.network import Network, steady
from gen.rig.parameters import NODES, MotorParameters


def network(motor: MotorParameters) -> Network:
    """Make the plain motor's thermal network."""
    return Network({name: motor.capacities_J_per_K[name] for name in NODES}, motor.paths)


@dataclass(frozen=True)
class Held:
    """A motor held at one operating point.

    Attributes
    ----------
    rates
        ``[-G, g] / C``, 1/s, shape (6, 7).
    settled
        Temperatures at which nothing changes, degC, shape (6,), in the order of `NODES`.
    heat
        Heat and current; the copper loss is in `copper_W`.
    copper_W
        Copper loss at the settled winding temperature.
    """

    rates: FloatArray
    settled: FloatArray
    heat: Heat
    copper_W: float

    def rise_from(self, start_degC: FloatArray, time_s: FloatArray) -> FloatArray:
        """Temperatures at some times, degC, shape (times, 6).

        The copper loss is taken at its settled resistance all the time, which at no load is some hundredths of a watt.
        """
        values, vectors = np.linalg.eig(self.rates[:, :-1])
        # A passive network's eigenvalues are real: C^1/2 A C^-1/2 is symmetric.
        weights = np.linalg.solve(vectors.real, start_degC - self.settled)
        modes: FloatArray = np.exp(np.outer(time_s, values.real)) * weights
        return np.asarray(self.settled + modes @ vectors.real.T)


def held(
    motor: MotorParameters,
    now: Operation,
    *,
    ambient_degC: float = 30.0,
    condition: Condition = HEALTHY,
    net: Network | None = None,
) -> Held:
    """Solve for the operating point; the resistance follows the winding's temperature."""
    net = net or network(motor)
    conductances = net.conductances(now.speed)
    flows = net.flows(conductances)
    sources = heat(motor, now, condition)
    watts = np.array(sources.nodes)
    settled = steady(flows, watts, ambient_degC)
    copper = 0.0
    for _ in range(50):
        before, copper = copper, sources.current_A**2 * resistance(motor, float(settled[0]))
        settled = steady(flows, watts + np.array([copper, 0.0, 0.0, 0.0, 0.0, 0.0]), ambient_degC)
        if abs(copper - before) < 1e-9:
            break
    return Held(net.rates(conductances), settled, sources, copper)


def no_load(speed: float) -> Operation:
    """Operating point without load at a speed as a fraction of the rated one, nominal supply."""
    return Operation(speed=speed, duty=speed)
