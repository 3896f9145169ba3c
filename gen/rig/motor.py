"""The simulated motor, step by step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from gen.arrays import FloatArray
from gen.rig.config import MotorConfig
from gen.rig.losses import Condition, Heat, Operation, heat, resistance, settled_speed
from gen.rig.network import Network, propagator
from gen.rig.parameters import AMBIENT, HIDDEN, NODES, HeatPath
from gen.rig.profiles import FULL_SCALE

STEFAN_BOLTZMANN = 5.670374419e-8  #: W/(m2 K4)
KELVIN = 273.15
_REFERENCE_DEGC = 30.0  #: Where `MotorConfig.loss_per_K` changes nothing: the study's ambient.
_WINDING, _BEARING, _CASING = (NODES.index(name) for name in ("winding", "bearing", "casing"))
_KEPT = 4096  #: Propagators to keep; each PWM change makes some thirty until the speed has settled.


class Drive(NamedTuple):
    """What the drive's own instruments show at the end of a step."""

    time_s: float
    #: With the sign of the rotation.
    speed_rpm: float
    #: Mean armature current; the inrush at a start, over in a fraction of a second, is left out.
    current_A: float
    voltage_V: float


class Motor:
    """A motor that runs in time.

    In each step speed-dependent conductances and heat are those of the step's mean speed, and the linear system is
    then solved exactly; copper loss, radiation and temperature-dependent friction take the temperatures at its start,
    which is off by less than 5 mK at the default step.

    Parameters
    ----------
    config
        The motor.
    start_degC
        Temperatures at the start by node; nodes not named, and all by default, start at ambient.
    ambient_degC
        Ambient temperature until a step says otherwise.
    """

    def __init__(
        self,
        config: MotorConfig | None = None,
        *,
        start_degC: Mapping[str, float] | None = None,
        ambient_degC: float = 30.0,
    ) -> None:
        self.config = config or MotorConfig()
        self.nodes = self.config.nodes
        self.time_s = 0.0
        #: Turns since the start, whichever way: what an encoder with one channel counts.
        self.revolutions = 0.0
        start = dict(start_degC or {})
        unknown = set(start) - set(self.nodes)
        if unknown:
            raise ValueError(f"no node is called {sorted(unknown)[0]!r}; expected some of {self.nodes}")
        if HIDDEN in self.nodes and HIDDEN not in start and self.config.hidden is not None:
            start[HIDDEN] = start.get(self.config.hidden.node, ambient_degC)
        #: Temperatures, degC, in the order of `nodes`.
        self.state: FloatArray = np.array([start.get(name, ambient_degC) for name in self.nodes])
        self.ambient_degC = ambient_degC
        self._speed = 0.0  # signed, over rated speed
        self._current = 0.0
        self._network = _network(self.config)
        self._propagators: dict[tuple[float, float, float], tuple[FloatArray, FloatArray]] = {}
        self._heat_key: tuple[Operation, Condition] | None = None
        self._heat: Heat | None = None
        self._base = np.zeros(len(self.nodes))
        self._hours_run = 0.0

    @property
    def temperatures(self) -> dict[str, float]:
        """Temperatures now, degC, by node."""
        return dict(zip(self.nodes, self.state.tolist(), strict=True))

    @property
    def speed_rpm(self) -> float:
        """Speed now, with the sign of the rotation."""
        return self._speed * self.config.parameters.electrical.rated_speed_rpm

    def step(
        self,
        pwm: float,
        dt_s: float,
        *,
        load_Nm: float = 0.0,
        ambient_degC: float | None = None,
        voltage_V: float | None = None,
        airflow_m_s: float = 0.0,
    ) -> Drive:
        """Run for a while with constant inputs.

        Parameters
        ----------
        pwm
            Counts, -255..255; the sign is the direction.
        dt_s
            How long, s; cut into equal steps of at most `MotorConfig.max_step_s`.
        load_Nm
            Torque that the shaft drives, whichever way it turns.
        ambient_degC
            Ambient from now on; None: as before.
        voltage_V
            Supply; None: nominal.
        airflow_m_s
            Speed of air blown over the casing.

        Raises
        ------
        ValueError
            For a PWM, time, load, voltage or airflow outside its range.
        """
        if not -FULL_SCALE <= pwm <= FULL_SCALE:
            raise ValueError(f"pwm is {pwm}; expected -{FULL_SCALE}..{FULL_SCALE}")
        if not dt_s > 0.0 or load_Nm < 0.0 or airflow_m_s < 0.0:
            raise ValueError("expected a time above 0 and neither load nor airflow below 0")
        if ambient_degC is not None:
            self.ambient_degC = ambient_degC
        nominal = self.config.parameters.electrical.nominal_voltage_V
        voltage = 1.0 if voltage_V is None else voltage_V / nominal
        if not voltage >= 0.0:
            raise ValueError(f"voltage_V is {voltage_V}; expected at least 0")
        count = max(1, math.ceil(dt_s / self.config.max_step_s - 1e-9))
        duty = abs(pwm) / FULL_SCALE
        settled = settled_speed(self.config.parameters, duty, voltage, load_Nm)
        goal = math.copysign(settled, pwm) if pwm else 0.0
        stalled = duty * voltage > 0.0 and settled == 0.0
        for _ in range(count):
            self._advance(
                dt_s / count, goal, Operation(0.0, duty, voltage, load_Nm if duty else 0.0, stalled), airflow_m_s
            )
        return Drive(self.time_s, self.speed_rpm, self._current, voltage * nominal)

    def _advance(self, h: float, goal: float, now: Operation, airflow: float) -> None:
        mean = self._spin(h, goal)
        speed = abs(mean)
        now = Operation(speed, now.duty, now.voltage, now.load_Nm, now.stalled)
        sources = self._sources(now, self._condition(mean < 0.0))
        key = (speed, airflow, h)
        advance = self._propagators.get(key)
        if advance is None:
            advance = self._propagator(*key)
        free, forced = advance
        watts = self._base
        copper = sources.current_A**2 * resistance(self.config.parameters, float(self.state[_WINDING]))
        if copper or self.config.radiating_area_m2:
            watts = watts.copy()
            hidden = self.config.hidden
            if hidden is not None and hidden.heat_from == NODES[_WINDING]:
                watts[-1] += hidden.share * copper
                copper -= hidden.share * copper
            watts[_WINDING] += copper
            watts[_CASING] -= self._radiation()
        state = self.state
        self.state = state + free[:, :-1] @ state + free[:, -1] * self.ambient_degC + forced @ watts
        self.time_s += h
        if speed > 0.0:
            self._hours_run += h / 3600.0
        self._current = sources.current_A

    def _spin(self, h: float, goal: float) -> float:
        """Move the rotor on; its signed mean speed during the step, over rated speed."""
        electrical = self.config.parameters.electrical
        off = self._speed - goal
        if abs(off) < 1e-7:
            off, mean = 0.0, goal
        else:
            lag = electrical.spin_time_constant_s
            decay = math.exp(-h / lag)
            mean = goal + off * (1.0 - decay) * lag / h
            off *= decay
        self._speed = goal + off
        self.revolutions += abs(mean) * electrical.rated_speed_rpm / 60.0 * h
        return mean

    def _condition(self, backwards: bool) -> Condition:
        config = self.config
        losses = config.reverse_losses if backwards else 1.0
        if config.loss_per_K:
            losses *= max(0.0, 1.0 + config.loss_per_K * (float(self.state[_BEARING]) - _REFERENCE_DEGC))
        if not config.faults:
            return Condition(friction=1.0 + config.wear_per_hour * self._hours_run, losses=losses)
        return Condition(
            bearing_fault=config.severity("bearing", self.time_s),
            brush_fault=config.severity("brush", self.time_s),
            friction=1.0 + config.wear_per_hour * self._hours_run,
            losses=losses,
        )

    def _sources(self, now: Operation, condition: Condition) -> Heat:
        """Heat but copper loss and radiation, also in `_base`; computed anew when anything changed."""
        if self._heat is None or self._heat_key != (now, condition):
            self._heat = heat(self.config.parameters, now, condition)
            self._heat_key = (now, condition)
            base = np.zeros(len(self.nodes))
            base[: len(NODES)] = self._heat.nodes
            hidden = self.config.hidden
            if hidden is not None:
                moved = hidden.share * base[NODES.index(hidden.heat_from)]
                base[NODES.index(hidden.heat_from)] -= moved
                base[-1] = moved
            self._base = base
        return self._heat

    def _radiation(self) -> float:
        """Net heat that the casing radiates beyond the linear heat path, W."""
        casing, ambient = float(self.state[_CASING]) + KELVIN, self.ambient_degC + KELVIN
        return self.config.radiating_area_m2 * STEFAN_BOLTZMANN * (casing**4 - ambient**4)

    def _propagator(self, speed: float, airflow: float, h: float) -> tuple[FloatArray, FloatArray]:
        """Make what a step multiplies state, ambient and heat with, and keep it."""
        rates = self._network.rates(conductances(self.config, self._network, speed, airflow))
        grow = propagator(rates, h)
        made = (grow @ rates, grow / self._network.capacities)
        if len(self._propagators) >= _KEPT:
            self._propagators.clear()
        self._propagators[speed, airflow, h] = made
        return made


def conductances(config: MotorConfig, network: Network, speed: float, airflow_m_s: float = 0.0) -> FloatArray:
    """W/K of each heat path at a speed over rated speed and an airflow over the casing, shape (paths,)."""
    made = network.conductances(speed)
    rest = 1.0 + (config.standstill_cooling - 1.0) * math.exp(-speed / 0.02)
    blown = 1.0 + config.airflow_per_m_s * airflow_m_s
    if rest != 1.0 or blown != 1.0:
        for k, path in enumerate(network.paths):
            ends = {path.a, path.b}
            made[k] *= (rest if AMBIENT in ends else 1.0) * (blown if ends == {"casing", AMBIENT} else 1.0)
    return made


def _network(config: MotorConfig) -> Network:
    capacities = {name: config.parameters.capacities_J_per_K[name] for name in NODES}
    paths = [*config.parameters.paths, *config.coupling]
    if config.hidden is not None:
        capacities[HIDDEN] = config.hidden.capacity_J_per_K
        paths.append(HeatPath(a=HIDDEN, b=config.hidden.node, still_W_per_K=config.hidden.conductance_W_per_K))
    return Network(capacities, paths)
