"""Drawing motors at random: topology, laws, heats, sensors; scaled to the rises and times of a small brushed motor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.plants.laws import Form, Law
from benchmarks.plants.losses import Losses
from benchmarks.plants.plant import Link, Plant, Source, Surface, copper

NAMES = ("rotor", "winding", "brush", "bearing", "magnet", "casing", "endcap", "mount", "gearbox", "shaft")
ROOM = 25.0
"""At which rises are scaled, degC."""
LEVELS = (51, 102, 153, 204, 255)
COOLEST_K, HOTTEST_K = 10.0, 70.0
"""Between these lies the largest steady rise of every sensed node."""
FASTEST_S, SLOWEST_S = 15.0, 7200.0
"""Between these lie the time constants at rest and at full speed."""
MOST_GROWTH = 0.4
"""Share of a node's conductance that the growth of its own heat with temperature may take away."""
ATTEMPTS = 2000


def random_plant(seed: int) -> Plant:
    """Draw a plant.

    Parameters
    ----------
    seed
        The same gives the same plant.

    Raises
    ------
    RuntimeError
        If no plant within the limits was found.
    """
    rng = np.random.default_rng([20271, seed])
    size = int(rng.integers(3, 11))  # before the attempts: small networks pass more often
    for _ in range(ATTEMPTS):
        plant = _scaled(rng, _draft(rng, size))
        if plant is not None:
            return plant
    raise RuntimeError(f"seed {seed}: no plant of {size} nodes within the limits")


def _draft(rng: np.random.Generator, size: int) -> Plant:
    """A plant with a random tree of paths, some more beside it, and relative heats."""
    pairs = [(int(rng.integers(max(0, node - 3), node)), node) for node in range(1, size)]
    others = [(a, b) for b in range(size) for a in range(b) if (a, b) not in pairs]
    pairs += [pair for pair in others if rng.random() < 0.6 / size]
    links = tuple(Link(a, b, _law(rng, _between(rng, 0.15, 4.0), 1.5, calm=0.5)) for a, b in pairs)
    outer = rng.choice(size, int(rng.integers(1, max(2, size // 2 + 1))), replace=False)
    return Plant(
        names=tuple(rng.permutation(NAMES)[:size].tolist()),
        capacity=tuple(_between(rng, 30.0, 500.0) for _ in range(size)),
        links=links,
        surfaces=tuple(_surface(rng, int(node)) for node in np.sort(outer)),
        sources=_sources(rng, size),
        losses=_losses(rng),
        sensed=tuple(sorted(rng.choice(size, min(size, int(rng.integers(3, 6))), replace=False).tolist())),
    )


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number between two, even in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _law(rng: np.random.Generator, rest: float, most: float, calm: float) -> Law:
    """A conductance: constant with a probability, else of a random form that rises."""
    if rng.random() < calm:
        return Law(rest)
    form = Form(rng.choice([Form.LINEAR, Form.POWER, Form.SATURATING, Form.TRANSITION]))
    shapes = {Form.POWER: (0.5, 1.1), Form.SATURATING: (0.15, 0.8), Form.TRANSITION: (0.3, 0.7), Form.LINEAR: (1, 1)}
    return Law(rest, float(rng.uniform(0.3, most)), form, float(rng.uniform(*shapes[form])))


def _surface(rng: np.random.Generator, node: int) -> Surface:
    rest = _between(rng, 0.05, 0.6)
    natural = rest * float(rng.uniform(0.2, 0.7)) if rng.random() < 0.4 else 0.0
    radiating = float(rng.uniform(0.003, 0.03)) if rng.random() < 0.3 else 0.0
    return Surface(node, _law(rng, rest, 4.0, calm=0.25), natural, radiating)


def _sources(rng: np.random.Generator, size: int) -> tuple[Source, ...]:
    def somewhere() -> int:
        return int(rng.integers(size))

    winding, share = somewhere(), _between(rng, 0.5, 2.0)
    return (
        copper(winding, share) if rng.random() < 0.5 else Source(winding, "copper", share),
        *(Source(somewhere(), "friction", _between(rng, 0.5, 2.0)) for _ in range(int(rng.integers(1, 3)))),
        Source(somewhere(), "windage", _between(rng, 0.5, 2.0)),
        Source(somewhere(), "iron", _between(rng, 0.5, 2.0)),
        Source(somewhere(), "brush", _between(rng, 0.3, 1.5)),
    )


def _losses(rng: np.random.Generator) -> Losses:
    coulomb = float(rng.uniform(0.15, 0.4))
    return Losses(
        droop=float(rng.uniform(0.0, 0.2)),
        coulomb=coulomb,
        breakaway=coulomb * float(rng.uniform(1.1, 2.5)),
        stribeck=float(rng.uniform(0.05, 0.3)),
        viscous=float(rng.uniform(0.0, 0.5)),
        air=float(rng.uniform(0.05, 0.5)),
        hysteresis=float(rng.uniform(0.02, 0.2)),
        eddy=float(rng.uniform(0.02, 0.2)),
        iron_exponent=float(rng.uniform(1.6, 2.1)),
        load=float(rng.uniform(0.0, 0.6)),
        resistance=float(rng.uniform(0.2, 0.8)),
        ripple=float(rng.uniform(0.0, 0.4)),
        ripple_exponent=float(rng.uniform(1.0, 2.0)),
        drop=float(rng.uniform(0.05, 0.3)),
    )


def _scaled(rng: np.random.Generator, draft: Plant) -> Plant | None:
    """The draft with its heats and capacities scaled; None where it cannot be brought within the limits."""
    plant = _heated(draft, float(rng.uniform(25.0, HOTTEST_K)))
    if plant is None or min(_peaks(plant)) < COOLEST_K:
        return None
    slowest = max(plant.slowest(0)[1], plant.slowest(255)[1])
    factor = _between(rng, 1500.0, SLOWEST_S) / slowest
    plant = replace(plant, capacity=tuple(c * factor for c in plant.capacity))
    return plant if min(plant.slowest(0)[0], plant.slowest(255)[0]) >= FASTEST_S else None


def _peaks(plant: Plant) -> list[float]:
    """The largest steady rise of each sensed node over the speeds, K."""
    rises = np.max([plant.steady(pwm, ROOM) - ROOM for pwm in LEVELS], axis=0)
    return [float(rises[node]) for node in plant.sensed]


def _heated(draft: Plant, hottest: float) -> Plant | None:
    """The draft with heats at which the hottest sensed node settles at this rise, to a thousandth."""
    plant = draft
    for _ in range(40):
        try:
            peak = max(_peaks(plant))
        except ValueError:
            return None
        if peak <= 0.0 or not _calm(plant):
            return None
        if abs(peak / hottest - 1.0) < 1e-3:
            return plant
        factor = hottest / peak
        plant = replace(plant, sources=tuple(replace(s, share=s.share * factor) for s in plant.sources))
    return None


def _calm(plant: Plant) -> bool:
    """Whether no node's heat grows by more with its temperature than a share of what carries heat away from it."""
    for pwm in LEVELS:
        running = plant.at(pwm)
        if np.any(running.growth > MOST_GROWTH * -np.diag(running.matrix)):
            return False
    return True
