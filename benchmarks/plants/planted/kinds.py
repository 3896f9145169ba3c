"""Everything that can be planted, by name: the library's effects, what is outside of it, and faults."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from benchmarks.plants.cases import Bench
from benchmarks.plants.planted import faults, outside
from benchmarks.plants.planted.draw import LIBRARY, Draft, Drafting, anywhere, between, sensed, sources
from benchmarks.plants.planted.later import follow
from benchmarks.plants.planted.visible import ROW_S, TRIED_IN


def _warm(stand: Bench, node: int, pwm: int) -> float:
    """What a node settles at, degC."""
    return float(stand.plant.steady(pwm, stand.usual)[node])


def _melting(rng: np.random.Generator, stand: Bench) -> Draft:
    node, width = anywhere(rng, stand), float(rng.uniform(1.0, 3.0))
    at = stand.usual + float(rng.uniform(0.3, 0.7)) * (_warm(stand, node, 204) - stand.usual)
    return Draft(lambda strength: outside.Melting(node, at, width, strength), (50.0, 100000.0))


def _duct(rng: np.random.Generator, stand: Bench) -> Draft:
    first, second = (int(node) for node in rng.choice(stand.plant.size, 2, replace=False))
    delay = between(rng, 240.0, 1500.0)
    return Draft(lambda strength: outside.Duct(first, second, delay, strength), (0.01, 1.0))


def _bimetal(rng: np.random.Generator, stand: Bench) -> Draft:
    node = anywhere(rng, stand)
    rise = _warm(stand, node, 204) - stand.usual
    shuts = stand.usual + float(rng.uniform(0.55, 0.75)) * rise
    opens = stand.usual + float(rng.uniform(0.2, 0.45)) * rise
    return Draft(lambda strength: outside.Bimetal(node, shuts, opens, strength), (0.01, 5.0))


def _load_cycle(rng: np.random.Generator, stand: Bench) -> Draft:
    period = between(rng, 900.0, 4800.0)
    return Draft(lambda strength: outside.LoadCycle(strength, period), (0.05, 3.0))


def _warmed_thermometer(rng: np.random.Generator, stand: Bench) -> Draft:
    node, lag = anywhere(rng, stand), between(rng, 120.0, 900.0)
    return Draft(lambda strength: outside.WarmedThermometer(node, strength, lag), (0.01, 0.5))


def _neighbour(rng: np.random.Generator, stand: Bench) -> Draft:
    node, period, on = anywhere(rng, stand), between(rng, 1800.0, 7200.0), float(rng.uniform(0.3, 0.6))
    return Draft(lambda strength: outside.Neighbour(node, strength, period, on), (0.1, 50.0))


def _unlogged_fan(rng: np.random.Generator, stand: Bench) -> Draft:
    nodes, diameter = tuple(surface.node for surface in stand.plant.surfaces), float(rng.uniform(0.03, 0.09))
    return Draft(lambda strength: outside.UnloggedFan(nodes, strength, diameter), (0.0003, 0.1))


def _sun(rng: np.random.Generator, stand: Bench) -> Draft:
    node = int(rng.choice([surface.node for surface in stand.plant.surfaces]))
    return Draft(lambda strength: outside.Sun(node, strength), (0.1, 50.0))


def _stick_slip(rng: np.random.Generator, stand: Bench) -> Draft:
    which, below = tuple(sources(stand, "friction")), float(rng.uniform(0.4, 0.65))
    return Draft(lambda strength: outside.StickSlip(which, below, 1.0 + strength), (0.2, 8.0))


def _ceiling(rng: np.random.Generator, stand: Bench) -> Draft:
    node = sensed(rng, stand)
    column = stand.plant.sensed.index(node)
    top = max(float(np.max(follow(stand, (), name, ROW_S).seen[:, column])) for name in TRIED_IN)
    return Draft(lambda strength: outside.Ceiling(node, top - strength), (1.5, 8.0), attempts=5)


def _fouling(rng: np.random.Generator, stand: Bench) -> Draft:
    return Draft(outside.Fouling, (0.1, 0.8), attempts=3)


def _worn(kind: str) -> Drafting:
    def draft(rng: np.random.Generator, stand: Bench) -> Draft:
        which = (int(rng.choice(sources(stand, kind))),)
        return Draft(lambda strength: faults.Worn(which, 1.0 + strength), (0.1, 6.0))

    return draft


def _wearing_bearing(rng: np.random.Generator, stand: Bench) -> Draft:
    which = (int(rng.choice(sources(stand, "friction"))),)
    return Draft(lambda strength: faults.Wearing(which, strength), (0.1, 8.0))


def _path_change(rng: np.random.Generator, stand: Bench) -> Draft:
    surfaces = [surface.node for surface in stand.plant.surfaces]
    nodes = tuple(surfaces) if rng.random() < 0.6 else (int(rng.choice(surfaces)),)
    kind, link = rng.random(), int(rng.integers(len(stand.plant.links)))
    if kind < 0.4:
        return Draft(lambda strength: faults.Blocked(nodes, strength), (0.3, 0.95))
    if kind < 0.7:
        return Draft(lambda strength: faults.Covered(nodes, strength), (0.3, 0.9))
    return Draft(lambda strength: faults.Loosened(link, strength), (0.4, 0.95))


OUTSIDE: Mapping[str, Drafting] = {
    "melting": _melting,
    "duct": _duct,
    "bimetal": _bimetal,
    "load_cycle": _load_cycle,
    "warmed_thermometer": _warmed_thermometer,
    "neighbour": _neighbour,
    "unlogged_fan": _unlogged_fan,
    "sun": _sun,
    "stick_slip": _stick_slip,
    "ceiling": _ceiling,
    "fouling": _fouling,
}
"""Kinds that the library of effects does not have."""
FAULTS: Mapping[str, Drafting] = {
    "worn_bearing": _worn("friction"),
    "worn_brush": _worn("brush"),
    "wearing_bearing": _wearing_bearing,
    "path_change": _path_change,
}
"""Wear, and ways of heat that were lost, which nobody declared."""
KINDS: Mapping[str, Drafting] = {**LIBRARY, **OUTSIDE, **FAULTS}
