"""A wider generator: motors whose physics is of the library's kind, but not of the library's form.

Nothing here is a formula of ``gen/model/effects``: hidden parts are two nodes that exchange heat both ways, a wrong
schedule is a triangle, a step, a slope or a single level instead of a Gaussian bump, a fan spins up, convection is a
power law, a drift levels off. The name is still the right one, the form is not. Profiles come from five families, and
readings miss rows.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.refinement.plant import AMBIENT, NAMES, STEP, Array, Baseline, Physics, Plan, pieces, plan

Part = Callable[..., Array]
SHAPES = ("triangle", "step", "slope", "level", "two_bumps")


def profiles(random: np.random.Generator, runs: int, hours: float, ambient_moves: bool) -> Plan:
    """Each run of a family of its own: held levels off the usual grid, ramps, duty cycles, staircases, long holds."""
    made = plan(random, runs, hours, ambient_moves)
    steps = made.pwm.shape[0]
    for r in range(runs):
        family = str(random.choice(["held", "ramps", "duty", "staircase", "long"]))
        made.pwm[:, r] = _FAMILIES[family](random, steps)
        made.current[:, r] = np.where(made.pwm[:, r] == 0, 0.0, pieces(random, steps, 700, 0.3, 7.0))
        made.vibration[:, r] = np.abs(made.pwm[:, r]) / 255 + random.normal(0.0, 0.05, steps)
        if ambient_moves and random.random() < 0.5:  # doors and heaters, not waves
            walk = pieces(random, steps, 3000, AMBIENT - 5.0, AMBIENT + 5.0)
            made.ambient[:, r] = _lowpass(walk, 600.0)
    return made


def _held(random: np.random.Generator, steps: int) -> Array:
    out = np.zeros(steps, dtype=int)
    at = 0
    while at < steps:
        length = int(random.uniform(900, 3600) / STEP)
        level = 0 if at and random.random() < 0.3 else int(random.integers(40, 256))
        out[at : at + length] = level * (-1 if random.random() < 0.3 else 1)
        at += length
    return out


def _ramps(random: np.random.Generator, steps: int) -> Array:
    knots = np.sort(random.integers(0, steps, 6))
    values = random.uniform(45, 255, 8)
    out = np.rint(np.interp(np.arange(steps), [0, *knots, steps], values)).astype(int)
    stop = int(random.uniform(0.5, 0.85) * steps)
    out[stop : stop + int(1500 / STEP)] = 0
    return out * (-1 if random.random() < 0.3 else 1)


def _duty(random: np.random.Generator, steps: int) -> Array:
    period, share = int(random.uniform(240, 1500) / STEP), random.uniform(0.3, 0.8)
    level = np.repeat(random.integers(90, 256, steps // period + 1), period)[:steps]
    out = np.where(np.arange(steps) % period < share * period, level, 0)
    out[-int(1800 / STEP) :] = 0
    return np.asarray(out) * (-1 if random.random() < 0.3 else 1)


def _staircase(random: np.random.Generator, steps: int) -> Array:
    levels = np.linspace(51, 255, 6).astype(int)
    levels = levels if random.random() < 0.5 else levels[::-1]
    out = np.repeat(levels, steps // 8)
    back = np.repeat(-levels[:1] if random.random() < 0.5 else levels[2:3], steps // 8)
    return np.concatenate([out, back, np.zeros(steps, dtype=int)])[:steps]


def _long(random: np.random.Generator, steps: int) -> Array:
    out = np.full(steps, int(random.integers(60, 256)) * (-1 if random.random() < 0.3 else 1))
    out[int(random.uniform(0.55, 0.8) * steps) :] = 0
    return out


_FAMILIES: dict[str, Callable[[np.random.Generator, int], Array]] = {
    "held": _held,
    "ramps": _ramps,
    "duty": _duty,
    "staircase": _staircase,
    "long": _long,
}


def _lowpass(values: Array, tau_s: float) -> Array:
    out = np.empty_like(values)
    state = values[0]
    for k, value in enumerate(values):
        state += (value - state) * STEP / tau_s
        out[k] = state
    return out


def shape(kind: str, random: np.random.Generator) -> Array:
    """Relative error of a schedule at |PWM| 0..255, 12 to 35 % at its largest."""
    x = np.arange(256.0)
    g = float(random.choice([-1.0, 1.0])) * random.uniform(0.12, 0.35)
    centre, width = random.uniform(80, 230), random.uniform(30, 60)
    if kind == "triangle":
        form = np.clip(1.0 - np.abs(x - centre) / width, 0.0, None)
    elif kind == "step":  # another regime from some speed on
        form = (x > random.uniform(90, 200)).astype(float)
    elif kind == "slope":
        form = (x - 128.0) / 128.0
    elif kind == "level":  # one speed was identified badly, straight lines to the next
        level = int(random.choice([102, 153, 204]))
        form = np.interp(x, [level - 51, level, level + 51], [0.0, 1.0, 0.0])
    else:
        form = np.exp(-(((x - 90.0) / 25.0) ** 2)) - 0.8 * np.exp(-(((x - 210.0) / 25.0) ** 2))
    return np.asarray(g * form)


def add(name: str, physics: Physics, random: np.random.Generator, base: Baseline, runs: int, start: Array) -> str:
    """Plant one effect of random size and form; give the component ("all" for several)."""
    at = str(random.choice(NAMES))
    mean = float(np.median(base.rate[at][51:]))
    sign = float(random.choice([-1.0, 1.0]))
    size = random.uniform(4.0, 12.0)

    def heats(function: Part) -> None:
        physics.heat.append(
            lambda n, rises, k, plan, h: function(rises[n], rises, k, plan, h) if n == at else 0.0 * rises[n]
        )

    def shows(function: Part) -> None:
        physics.reading.append(lambda n, value, time, plan: function(value, time) if n == at else value)

    def state(initial: Array, slope: Part) -> int:
        physics.hidden.append(initial)
        physics.inner.append(slope)
        return len(physics.hidden) - 1

    def driven(k: int, plan: Plan) -> Array:
        return np.asarray(base.gain[at][np.abs(plan.pwm[k])])

    if name == "ambient":
        physics.ambient_matters = True
        return "all"
    if name == "hidden_node":  # two nodes inside; the outer one exchanges heat with the component, both ways
        inner_tau, tau, warm = random.uniform(200.0, 900.0), random.uniform(900.0, 3000.0), random.uniform(1.0, 2.0)
        first = state(
            np.zeros(runs),
            lambda rises, k, plan, h: (warm * 60.0 * (np.abs(plan.pwm[k]) / 255.0) ** 1.5 - h[first]) / inner_tau,
        )
        second = state(np.zeros(runs), lambda rises, k, plan, h: (0.7 * h[first] + 0.3 * rises[at] - h[second]) / tau)
        k_ = size / 60.0 * mean
        heats(lambda own, rises, k, plan, h: k_ * (2.0 * h[second] - own))
    elif name == "standstill_cooling":  # the air comes to rest within a minute
        f = float(random.choice([random.uniform(0.2, 0.5), random.uniform(2.0, 4.0)]))
        rest = state(np.zeros(runs), lambda rises, k, plan, h: ((plan.pwm[k] == 0).astype(float) - h[rest]) / 40.0)
        heats(lambda own, rises, k, plan, h: (1.0 - f) * base.rate[at][0] * own * h[rest] * (plan.pwm[k] == 0))
    elif name == "load_heating":  # copper warms, so its losses do
        heats(lambda own, rises, k, plan, h: size / 14.0 * mean * plan.current[k] ** 2 * (1.0 + 0.0015 * own))
    elif name == "coupling":  # through a wall with a mass of its own
        other = str(random.choice([n for n in NAMES if n != at]))
        k_ = random.uniform(0.3, 1.0) * mean * (2.0 if "brush" in (at, other) else 6.0)
        wall = state(start.copy(), lambda rises, k, plan, h: (rises[other] - h[wall]) / 60.0)
        heats(lambda own, rises, k, plan, h: k_ * (h[wall] - own))
    elif name == "radiation":  # natural convection, a power law, beside radiation
        exponent = random.uniform(1.4, 2.2)
        heats(lambda own, rises, k, plan, h: -2.0 * size * mean * np.clip(own / 40.0, 0.0, None) ** exponent)
    elif name == "temperature_dependent_loss":
        alpha = random.uniform(0.0025, 0.006) * sign
        heats(lambda own, rises, k, plan, h: driven(k, plan) * alpha * own * (1.0 - own / 400.0))
    elif name == "airflow":  # a fan that spins up
        k_ = random.uniform(0.25, 0.8) * mean
        spin = state(np.zeros(runs), lambda rises, k, plan, h: (plan.fan[k] - h[spin]) / 30.0)
        heats(lambda own, rises, k, plan, h: -k_ * h[spin] * own)
    elif name == "sensor_offset":
        off = sign * random.uniform(2.0, 6.0)
        shows(lambda value, time: value + off * (1.0 + 0.001 * (value - AMBIENT)))
    elif name == "sensor_gain":  # about 0 degC or the room's, and slightly bent
        g, zero = sign * random.uniform(0.06, 0.2), float(random.choice([0.0, AMBIENT]))
        shows(lambda value, time: value + g * (value - zero) * (1.0 - 0.0005 * (value - zero)))
    elif name == "sensor_lag":
        physics.lag[at] = random.uniform(150.0, 600.0)
    elif name == "schedule_error":
        error = shape(str(random.choice(SHAPES)), random)
        heats(lambda own, rises, k, plan, h: error[np.abs(plan.pwm[k])] * driven(k, plan))
    elif name == "drift":  # levels off slowly
        d, tau = sign * random.uniform(1.5, 4.0), random.uniform(4.0, 12.0) * 3600.0
        shows(lambda value, time: value + d * tau / 3600.0 * (1.0 - np.exp(-time[:, None] / tau)))
    elif name == "direction":  # more heat and a little other cooling
        d = sign * random.uniform(0.15, 0.4)
        heats(
            lambda own, rises, k, plan, h: np.where(
                plan.pwm[k] < 0, d * driven(k, plan) - 0.03 * d * base.rate[at][np.abs(plan.pwm[k])] * own, 0.0
            )
        )
    elif name == "supply_voltage":  # part of the loss goes with the voltage, part with its square
        v0 = random.uniform(23.0, 25.0)
        power = random.uniform(1.5, 2.3)
        heats(lambda own, rises, k, plan, h: ((plan.voltage[k] / v0) ** power - 1.0) * driven(k, plan))
    elif name == "initial_state":  # two stores inside
        fast, slow, g = random.uniform(150.0, 400.0), random.uniform(600.0, 1800.0), random.uniform(0.3, 0.8)
        one = state(start.copy(), lambda rises, k, plan, h: -h[one] / fast)
        two = state(start.copy(), lambda rises, k, plan, h: -h[two] / slow)
        heats(lambda own, rises, k, plan, h: g * (0.3 * h[one] / fast + 0.7 * h[two] / slow))
    else:
        raise KeyError(name)
    return at
