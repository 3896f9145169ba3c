"""The curves of a file's network at the inputs of a fit, and what effects need to know of such a network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.model.network import Network
from gen.model.network_parts import Curve, Factor, Heat, Path
from gen.refinement.network.changing import excess
from gen.refinement.network.changing.columns import Columns
from gen.refinement.network.effects import Motor
from gen.refinement.network.effects.base import SPEEDS
from gen.refinement.network.fitting.anchors import USUAL_AMBIENT

LEAST_W_PER_K = 1e-9


@dataclass(frozen=True, eq=False)
class FileCurves:
    """Conductances and heats as the file has them.

    Attributes
    ----------
    network
        The file's.
    full_scale
        The count that is 100 %.
    columns
        What else drives the motor.
    """

    network: Network
    full_scale: int
    columns: Columns
    _kept: dict[tuple[str, int, Levels], tuple[FloatArray, FloatArray]] = field(default_factory=dict, repr=False)

    def path(self, number: int, levels: Levels) -> tuple[FloatArray, FloatArray]:
        """Give a path's conductance while turning and at rest, factors included, shape (L,) each, W/K."""
        return self._once("path", number, levels, self.network.paths[number])

    def heat(self, number: int, levels: Levels) -> tuple[FloatArray, FloatArray]:
        """Give a heat likewise, W."""
        return self._once("heat", number, levels, self.network.heats[number])

    def _once(self, kind: str, number: int, levels: Levels, own: Path | Heat) -> tuple[FloatArray, FloatArray]:
        """A search asks for the same inputs many hundred times."""
        key = (kind, number, levels)
        if key not in self._kept:
            self._kept[key] = self._at(own.curve, own.factors, levels)
        return self._kept[key]

    def _at(self, curve: Curve, factors: Sequence[Factor], levels: Levels) -> tuple[FloatArray, FloatArray]:
        """What a curve of the file gives while turning and at rest, factors included, shape (L,) each."""
        pwm = levels.speed * self.full_scale
        held = pwm if self.network.held is None else np.clip(pwm, *self.network.held)
        still = curve.at_rest
        if still is None:
            still = float(curve.turning(np.array([float(self.network.held[0]) if self.network.held else 0.0]))[0])
        told = self._told(factors, levels)
        return np.maximum(curve.turning(held), 0.0) * told, still * told

    def _told(self, factors: Sequence[Factor], levels: Levels) -> FloatArray:
        made = np.ones(levels.count)
        for factor in factors:
            channel = self.network.channel(factor.channel)
            value = self.columns.power(levels, factor.channel, 1)
            made = made * factor(np.clip(value, channel.low, channel.high))
        return made

    def conductance_at(self, path: int, speed: FloatArray) -> FloatArray:
        """Give a path's conductance while the motor turns at speeds, channels neutral, shape (L,), W/K."""
        own = self.network.paths[path]
        return self._at(own.curve, own.factors, self._levels(speed))[0]

    def with_speed(self, path: int, speed: FloatArray) -> FloatArray:
        """Give what share of a path's conductance has come with speed, at speeds, channels neutral, shape (L,).

        None of what conducts nothing then: all that it conducts a channel makes.
        """
        own = self.network.paths[path]
        turning, still = self._at(own.curve, own.factors, self._levels(speed))
        share = np.clip(1.0 - still / np.maximum(turning, LEAST_W_PER_K), 0.0, 1.0)
        return np.asarray(np.where(turning > LEAST_W_PER_K, share, 0.0))

    def heat_at(self, heat: int, speed: FloatArray) -> FloatArray:
        """Give one heat of the file likewise, shape (L,), W."""
        own = self.network.heats[heat]
        return self._at(own.curve, own.factors, self._levels(speed))[0]

    def _levels(self, speed: FloatArray) -> Levels:
        """The inputs of speeds that are held, channels neutral, shape (L,)."""
        neutral = self.network.neutral()
        usual = {name: np.full(speed.size, neutral.get(name, 0.0)) for name in self.columns.channels}
        none = [np.zeros(speed.size)] * self.columns.excesses
        further = np.column_stack(self.columns.of_run(speed, usual, none, later=False))
        return Levels(np.ones_like(speed), np.zeros_like(speed), speed, speed**2, further)


def motor_of(
    curves: FileCurves, order: Sequence[int], paths: tuple[tuple[int, int], ...], heats: Sequence[int]
) -> Motor:
    """Say what effects need to know of a file's network.

    Parameters
    ----------
    curves
        Its curves.
    order
        The file's nodes, the sensed ones first; paths and heats count so.
    paths
        Its paths; the ambient is -1 and stands second.
    heats
        Nodes of its heats.
    """
    network, full = curves.network, np.ones(1)
    conductance = np.array([curves.conductance_at(q, full)[0] for q in range(len(network.paths))])
    outer = tuple(q for q, path in enumerate(network.paths) if path.second is None and path.law is None)
    heated = tuple(dict.fromkeys(heats))
    own = {node: [h for h, other in enumerate(heats) if other == node] for node in heated}
    heat_W = tuple(sum((curves.heat_at(h, SPEEDS) for h in own[node]), np.zeros(SPEEDS.size)) for node in heated)
    total = sum(float(curves.heat_at(h, full)[0]) for h in range(len(network.heats)))
    return Motor(
        names=tuple(network.nodes[k].name for k in order),
        sensed=len(network.sensed),
        outer=outer,
        paths=paths,
        heated=heated,
        heat_W=heat_W,
        heat_powers=tuple(_powers(watts) for watts in heat_W),
        outer_powers=tuple(float(np.mean(_powers(curves.conductance_at(q, SPEEDS)))) for q in outer),
        with_speed=tuple(curves.with_speed(q, SPEEDS) for q in range(len(network.paths))),
        lawless=tuple(q for q, path in enumerate(network.paths) if path.law is None),
        multiplied=tuple(frozenset(factor.channel for factor in path.factors) for path in network.paths),
        columns=curves.columns,
        typical_W=max(total, 1e-6),
        typical_W_per_K=float(np.median(conductance[conductance > 0.0])),
        typical_J_per_K=float(np.median(network.capacities)),
        whole_J_per_K=float(np.sum(network.capacities)),
        usual_degC=_usual(network, curves.full_scale, order),
        radiates=tuple(excess.radiation_of(network, node) for node in range(len(order))),
    )


def _usual(network: Network, full_scale: int, order: Sequence[int]) -> tuple[float, ...]:
    """Where the nodes settle at half speed, degC."""
    m, a, f = network.matrices(np.array([full_scale // 2]))
    settled = np.linalg.solve(-m[0], a[0] * USUAL_AMBIENT + f[0])
    return tuple(float(settled[k]) for k in order)


def _powers(value: FloatArray) -> FloatArray:
    """Give the power of speed that a curve over `SPEEDS` goes with, shape (speeds,); 1 where it is not above 0."""
    if not np.all(value > 0.0):
        return np.ones(SPEEDS.size)
    return np.asarray(np.gradient(np.log(value), np.log(SPEEDS)))
