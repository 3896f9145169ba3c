"""A coefficient file's network while it is changed: curves scaled, factors, nodes, paths and heats added."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gen.coefficients.network import (
    ChannelEntry,
    CurveEntry,
    FactorEntry,
    HeatEntry,
    NetworkEntry,
    NodeEntry,
    PathEntry,
    PolyCurve,
    PowerCurve,
    SensorEntry,
    TableCurve,
)
from gen.coefficients.schedule import Points
from gen.identification.network.bins import FloatArray
from gen.model.network import AMBIENT, PWM, PowerLaw

POINT = 5
"""Distance of a table's points, counts: pchip through them is within 1e-4 of the curve."""
MARGIN = 0.1
"""A channel's range is wider than what was measured by this share of it on both sides."""

Scale = Callable[[FloatArray], FloatArray]
"""A factor by |PWM| over full scale, any shape."""


class NetworkWriter:
    """Changes a network's entry.

    Parameters
    ----------
    entry
        To begin with.
    full_scale
        The count that is 100 %.
    ranges
        Least and greatest measured value of each channel.
    """

    def __init__(self, entry: NetworkEntry, full_scale: int, ranges: dict[str, tuple[float, float]]) -> None:
        self.entry = entry
        self.full_scale = full_scale
        self._ranges = ranges

    def _replace(self, **parts: object) -> None:
        self.entry = self.entry.model_copy(update=parts)

    def scale_path(self, between: tuple[str, str], scale: Scale, at_rest: float) -> None:
        """Multiply a path's conductance, while the motor turns and at rest; nothing where there is no such path."""
        self._replace(
            paths=tuple(
                path.model_copy(update={"conductance_W_per_K": self._scaled(path.conductance_W_per_K, scale, at_rest)})
                if set(path.between) == set(between)
                else path
                for path in self.entry.paths
            )
        )

    def scale_path_number(self, number: int, scale: Scale, at_rest: float) -> None:
        """Multiply one path's conductance, while the motor turns and at rest."""
        paths = list(self.entry.paths)
        curve = self._scaled(paths[number].conductance_W_per_K, scale, at_rest)
        paths[number] = paths[number].model_copy(update={"conductance_W_per_K": curve})
        self._replace(paths=tuple(paths))

    def scale_heat_number(self, number: int, scale: Scale) -> None:
        """Multiply one heat; at rest as at the slowest speed."""
        heats = list(self.entry.heats)
        curve = self._scaled(heats[number].power_W, scale, float(scale(np.zeros(1))[0]))
        heats[number] = heats[number].model_copy(update={"power_W": curve})
        self._replace(heats=tuple(heats))

    def scale_heat(self, node: str, scale: Scale) -> None:
        """Multiply all heat of a node."""
        self._replace(
            heats=tuple(
                heat.model_copy(update={"power_W": self._scaled(heat.power_W, scale, float(scale(np.zeros(1))[0]))})
                if heat.node == node
                else heat
                for heat in self.entry.heats
            )
        )

    def _scaled(self, curve: CurveEntry, scale: Scale, at_rest: float) -> CurveEntry:
        pwm = np.unique([*range(0, self.full_scale, POINT), self.full_scale])
        value = self._values(curve, pwm) * scale(pwm / self.full_scale)
        still = curve.at_rest if curve.at_rest is not None else float(self._values(curve, np.zeros(1))[0])
        points = Points(
            pwm=tuple(int(x) for x in pwm), value=tuple(short(float(y)) for y in value), interpolation="pchip"
        )
        return TableCurve(table=points, at_rest=short(still * at_rest))

    def _values(self, curve: CurveEntry, pwm: FloatArray) -> FloatArray:
        if isinstance(curve, PowerCurve):
            power = curve.power
            return PowerLaw(power.constant, power.forced, power.exponent, self.full_scale)(pwm)
        return curve.schedule()(np.asarray(pwm, dtype=np.float64))

    def factor_on_path(self, between: tuple[str, str], factor: FactorEntry) -> None:
        """Let a channel multiply a path's conductance."""
        self._channel(factor.channel)
        self._replace(
            paths=tuple(
                path.model_copy(update={"factors": (*path.factors, factor)})
                if set(path.between) == set(between)
                else path
                for path in self.entry.paths
            )
        )

    def factor_on_heats(self, node: str, factor: FactorEntry) -> None:
        """Let a channel multiply all heat of a node."""
        self._channel(factor.channel)
        self._replace(
            heats=tuple(
                heat.model_copy(update={"factors": (*heat.factors, factor)}) if heat.node == node else heat
                for heat in self.entry.heats
            )
        )

    def heat_by_channel(self, node: str, watts: float, factor: FactorEntry) -> None:
        """Add a heat that a channel makes."""
        self._channel(factor.channel)
        heat = HeatEntry(node=node, power_W=PolyCurve(poly=(short(watts),)), factors=(factor,))
        self._replace(heats=(*self.entry.heats, heat))

    def heat_over_speed(self, node: str, watts: Scale) -> None:
        """Add a heat by |PWM|, none at rest."""
        pwm = np.unique([*range(0, self.full_scale, POINT), self.full_scale])
        value = np.where(pwm > 0, watts(pwm / self.full_scale), 0.0)
        points = Points(
            pwm=tuple(int(x) for x in pwm), value=tuple(short(float(y)) for y in value), interpolation="pchip"
        )
        self._replace(heats=(*self.entry.heats, HeatEntry(node=node, power_W=TableCurve(table=points, at_rest=0.0))))

    def grows(self, node: str, per_K: float, reference: float) -> None:
        """Let all heat of a node grow with its temperature."""
        self._replace(
            heats=tuple(
                heat.model_copy(update={"per_K": short(per_K), "reference_degC": reference})
                if heat.node == node
                else heat
                for heat in self.entry.heats
            )
        )

    def node(self, capacity: float) -> str:
        """Add a hidden node; its name is new."""
        taken = {node.name.lower() for node in self.entry.nodes}
        name = next(f"hidden{k}" for k in range(1, len(taken) + 2) if f"hidden{k}" not in taken)
        self._replace(nodes=(*self.entry.nodes, NodeEntry(name=name, capacity_J_per_K=short(capacity))))
        return name

    def capacity(self, name: str, capacity: float) -> None:
        """Give a node another capacity, J/K."""
        self._nodes(name, capacity_J_per_K=short(capacity))

    def sensor(self, name: str, *, offset_K: float = 0.0, lag_s: float = 0.0) -> None:
        """Add to what stands between a node and its reading."""
        node = next(node for node in self.entry.nodes if node.name == name)
        old = node.sensor or SensorEntry()
        sensor = SensorEntry(offset_K=short(old.offset_K + offset_K), lag_s=short(old.lag_s + lag_s))
        self._nodes(name, sensor=sensor)

    def _nodes(self, name: str, **parts: object) -> None:
        self._replace(
            nodes=tuple(node.model_copy(update=parts) if node.name == name else node for node in self.entry.nodes)
        )

    def path(self, first: str, second: str, conductance: float) -> None:
        """Add a path, or add to the one that is there."""
        between = (first, second)
        for path in self.entry.paths:
            if set(path.between) == set(between):
                own = path.conductance_W_per_K
                still = own.at_rest if own.at_rest is not None else float(self._values(own, np.zeros(1))[0])

                def more(share: FloatArray, own: CurveEntry = own) -> FloatArray:
                    return 1.0 + conductance / self._values(own, share * self.full_scale)

                self.scale_path(between, more, 1.0 + conductance / still)
                return
        path = PathEntry(between=between, conductance_W_per_K=PolyCurve(poly=(short(conductance),)))
        self._replace(paths=(*self.entry.paths, path))

    def _channel(self, column: str) -> None:
        if any(channel.column == column for channel in self.entry.channels):
            return
        if column == PWM:
            full = float(self.full_scale)
            channel = ChannelEntry(column=column, range=(-full, full), neutral=0.0)
            self._replace(channels=(*self.entry.channels, channel))
            return
        low, high = self._ranges[column]
        wider = MARGIN * (high - low)
        low, high = (0.0 if low == 0.0 else low - wider), high + wider
        low, high = short(low), short(high)
        neutral = min(max(0.0, low), high) if low <= 0.0 <= high else short(0.5 * (low + high))
        self._replace(channels=(*self.entry.channels, ChannelEntry(column=column, range=(low, high), neutral=neutral)))


def ends(path: tuple[int, int], names: tuple[str, ...]) -> tuple[str, str]:
    """Name a path's ends as a coefficient file does."""
    return names[path[0]], AMBIENT if path[1] < 0 else names[path[1]]


def short(value: float) -> float:
    """Round to six digits."""
    return float(f"{value:.6g}")
