"""A coefficient file's network while it is changed: curves scaled, factors, nodes, paths and heats added."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients.checks.model_checks import FASTEST
from gen.coefficients.network import (
    ChannelEntry,
    CurveEntry,
    FactorEntry,
    HeatEntry,
    NetworkEntry,
    NodeEntry,
    PathEntry,
    PolyCurve,
    RadiationEntry,
    SensorEntry,
)
from gen.coefficients.network_curves import points_of, six_digits, tabulated, values_of
from gen.errors import InputError
from gen.model.laws import ZERO_C
from gen.model.network_parts import AMBIENT, PWM

MARGIN = 0.1
"""A channel's range is wider than what was measured by this share of it on both sides."""
LEAST_SHARE = 1e-4
"""Of a heat that is divided, what is left out."""
FASTEST_SHARE = 0.8
"""Of the fastest that a file may hold, for what factors and rounding add. Nodes so close are one to every sensor."""

Scale = Callable[[FloatArray], FloatArray]
"""A factor by |PWM| over full scale, any shape."""


class PathAt(NamedTuple):
    """Which path of a file: of those that conduct without a law between two ends, in the file's order.

    Attributes
    ----------
    first, second
        Its ends.
    place
        0 for the first of them.
    """

    first: str
    second: str
    place: int = 0


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
    sample_time
        Of the board, s.
    margin
        How far beyond that a file lets channels be, as a share of what lies between.
    """

    def __init__(
        self,
        entry: NetworkEntry,
        full_scale: int,
        ranges: dict[str, tuple[float, float]],
        sample_time: float,
        margin: float = MARGIN,
    ) -> None:
        self.entry = entry
        self.full_scale = full_scale
        self._ranges = ranges
        self._sample_time = sample_time
        self._margin = margin
        #: What is found lies before the gains that the entry began with.
        self._through = {node.name: 1.0 + node.sensor.gain_error for node in entry.nodes if node.sensor is not None}

    def _replace(self, **parts: object) -> None:
        self.entry = self.entry.model_copy(update=parts)

    def _path(self, at: PathAt, change: Callable[[PathEntry], PathEntry]) -> None:
        """Change one path; nothing where there is no such path."""
        ends = {at.first, at.second}
        there = [k for k, path in enumerate(self.entry.paths) if set(path.between) == ends and path.law is None]
        if at.place < len(there):
            paths = list(self.entry.paths)
            paths[there[at.place]] = change(paths[there[at.place]])
            self._replace(paths=tuple(paths))

    def _heats(self, node: str, change: Callable[[HeatEntry], HeatEntry]) -> None:
        """Change all heats of a node."""
        self._replace(heats=tuple(change(h) if h.node == node else h for h in self.entry.heats))

    def scale_path(self, at: PathAt, scale: Scale, at_rest: float) -> None:
        """Multiply a path's conductance, while the motor turns and at rest; nothing where there is no such path."""
        self._path(at, lambda path: self._scaled_path(path, scale, at_rest))

    def scale_heat(self, node: str, scale: Scale) -> None:
        """Multiply all heat of a node; at rest as at the slowest speed."""
        self._heats(node, lambda heat: self._scaled_heat(heat, scale))

    def scale_path_number(self, number: int, scale: Scale, at_rest: float) -> None:
        """Multiply one path's conductance, by its place in the file."""
        scaled = self._scaled_path(self.entry.paths[number], scale, at_rest)
        self._replace(paths=(*self.entry.paths[:number], scaled, *self.entry.paths[number + 1 :]))

    def scale_heat_number(self, number: int, scale: Scale) -> None:
        """Multiply one heat, by its place in the file; at rest as at the slowest speed."""
        scaled = self._scaled_heat(self.entry.heats[number], scale)
        self._replace(heats=(*self.entry.heats[:number], scaled, *self.entry.heats[number + 1 :]))

    def _scaled_path(self, path: PathEntry, scale: Scale, at_rest: float) -> PathEntry:
        return path.model_copy(update={"conductance_W_per_K": self._scaled(path.conductance_W_per_K, scale, at_rest)})

    def _scaled_heat(self, heat: HeatEntry, scale: Scale) -> HeatEntry:
        return heat.model_copy(update={"power_W": self._scaled(heat.power_W, scale, float(scale(np.zeros(1))[0]))})

    def _scaled(self, curve: CurveEntry, scale: Scale, at_rest: float) -> CurveEntry:
        pwm = points_of(self.full_scale)
        turning, still = values_of(curve, pwm, self.full_scale)
        return tabulated(pwm, turning * scale(pwm / self.full_scale), still * at_rest)

    def factor_on_path(self, at: PathAt, factor: FactorEntry) -> None:
        """Let a channel multiply a path's conductance."""
        self._channel(factor.channel)
        self._path(at, lambda path: path.model_copy(update={"factors": (*path.factors, factor)}))

    def path_by_channel(self, at: PathAt, conductance: float, factor: FactorEntry) -> None:
        """Add a path beside one that is there, whose conductance a channel makes; no more than the board can follow."""
        self._channel(factor.channel)
        curve = PolyCurve(poly=(six_digits(min(conductance, self._most(at.first))),))
        path = PathEntry(between=(at.first, at.second), conductance_W_per_K=curve, factors=(factor,))
        self._replace(paths=(*self.entry.paths, path))

    def factor_on_heats(self, node: str, factor: FactorEntry) -> None:
        """Let a channel multiply all heat of a node."""
        self._channel(factor.channel)
        self._heats(node, lambda heat: heat.model_copy(update={"factors": (*heat.factors, factor)}))

    def split_heat(self, node: str, parts: Sequence[tuple[Scale, FactorEntry | None]]) -> None:
        """Divide all heat of a node, by speed, into shares that channels multiply; a share that is none is left out."""
        pwm = points_of(self.full_scale)
        heats: list[HeatEntry] = []
        for heat in self.entry.heats:
            if heat.node != node:
                heats.append(heat)
                continue
            for share, factor in parts:
                if float(np.max(share(pwm / self.full_scale))) < LEAST_SHARE:
                    continue
                part = self._scaled_heat(heat, share)
                if factor is not None:
                    self._channel(factor.channel)
                    part = part.model_copy(update={"factors": (*part.factors, factor)})
                heats.append(part)
        self._replace(heats=tuple(heats))

    def heat_by_channel(self, node: str, watts: float, factor: FactorEntry) -> None:
        """Add a heat that a channel makes."""
        self._channel(factor.channel)
        heat = HeatEntry(node=node, power_W=PolyCurve(poly=(six_digits(watts),)), factors=(factor,))
        self._replace(heats=(*self.entry.heats, heat))

    def heat_over_speed(self, node: str, watts: Scale) -> None:
        """Add a heat by |PWM|, none at rest, where a power of speed may have no value."""
        pwm = points_of(self.full_scale)
        heat = np.zeros(pwm.size)
        heat[pwm > 0] = watts(pwm[pwm > 0] / self.full_scale)
        curve = tabulated(pwm, heat, 0.0)
        self._replace(heats=(*self.entry.heats, HeatEntry(node=node, power_W=curve)))

    def grows(self, node: str, per_K: float, reference: float) -> None:
        """Let all heat of a node grow with its temperature, by a share of what it is at 0 degC (see `Draft.grow`)."""
        self._heats(node, lambda heat: self._grown(heat, per_K, reference))

    def _grown(self, heat: HeatEntry, per_K: float, reference: float) -> HeatEntry:
        # P (1 + j (T - s)) and k P (1 - j s) (T - r) together, told from r on.
        at_zero = 1.0 - heat.per_K * heat.reference_degC
        at_reference = 1.0 + heat.per_K * (reference - heat.reference_degC)
        scaled = self._scaled_heat(heat, lambda speed: np.full(speed.shape, at_reference)) if heat.per_K else heat
        growth = six_digits((heat.per_K + per_K * at_zero) / at_reference)
        return scaled.model_copy(update={"per_K": growth, "reference_degC": reference})

    def node(self, capacity: float) -> str:
        """Add a hidden node; its name is new."""
        taken = {node.name.lower() for node in self.entry.nodes}
        name = next(f"hidden{k}" for k in range(1, len(taken) + 2) if f"hidden{k}" not in taken)
        self._replace(nodes=(*self.entry.nodes, NodeEntry(name=name, capacity_J_per_K=six_digits(capacity))))
        return name

    def capacity(self, name: str, capacity: float) -> None:
        """Give a node another capacity, J/K."""
        self._nodes(name, capacity_J_per_K=six_digits(capacity))

    def start_factor(self, name: str, factor: float) -> None:
        """Let a hidden node start at another multiple of where it would rest."""
        self._nodes(name, start_factor=six_digits(factor))

    def sensor(self, name: str, *, offset_K: float = 0.0, lag_s: float = 0.0) -> None:
        """Add to what stands between a node and its reading; an offset is one of readings with a right gain."""
        old = self._sensor(name)
        offset_K = six_digits(old.offset_K + offset_K * self._through.get(name, 1.0))
        lag_s = six_digits(old.lag_s + lag_s)
        self._change(name, offset_K=offset_K, lag_s=lag_s)

    def drift(self, name: str, rate_K_per_h: float, settles_h: float) -> None:
        """Let a reading move since the start: at first by so much an hour, with a time constant until it stands.

        Raises
        ------
        InputError
            If the file lets it do so already: of two drifts it holds one.
        """
        old = self._sensor(name)
        if old.drift_K:
            raise InputError(
                f'"{name}" drifts by {old.drift_K:g} K in the file, and otherwise in these runs: mend the sensor'
            )
        drift_K = rate_K_per_h * settles_h * self._through.get(name, 1.0)
        self._change(name, drift_K=six_digits(drift_K), drift_h=six_digits(settles_h))

    def wrong_gain(self, name: str, error: float, about: Literal["ambient", "zero_degC"]) -> None:
        """Multiply what a sensor shows over a base.

        Raises
        ------
        InputError
            If its gain is wrong about another base already: the file holds one of them.
        """
        old = self._sensor(name)
        if old.gain_error and old.gain_about != about:
            place = {"ambient": "the ambient", "zero_degC": "0 degC"}
            raise InputError(
                f'the gain of "{name}" is wrong about {place[old.gain_about]} in the file, and was found to be wrong '
                f"about {place[about]} beside that; a file holds one of them"
            )
        error = six_digits((1.0 + old.gain_error) * (1.0 + error) - 1.0)
        self._change(name, gain_error=error, gain_about=about)

    def _change(self, name: str, **parts: float | str) -> None:
        """Change some of a sensor's numbers; what it never had is not written."""
        told = self._sensor(name).model_dump(exclude_unset=True)
        self._nodes(name, sensor=SensorEntry(**{**told, **parts}))

    def _sensor(self, name: str) -> SensorEntry:
        return next(node for node in self.entry.nodes if node.name == name).sensor or SensorEntry()

    def _nodes(self, name: str, **parts: object) -> None:
        self._replace(
            nodes=tuple(node.model_copy(update=parts) if node.name == name else node for node in self.entry.nodes)
        )

    def path(self, first: str, second: str, conductance: float) -> None:
        """Add a path, or add to the one that is there and no channel multiplies; no more than the board can follow."""
        conductance = min(conductance, *(self._most(end) for end in (first, second) if end != AMBIENT))
        for number, path in enumerate(self.entry.paths):
            if set(path.between) == {first, second} and path.law is None and not path.factors:
                more = self._with_more(path, conductance)
                self._replace(paths=(*self.entry.paths[:number], more, *self.entry.paths[number + 1 :]))
                return
        curve = PolyCurve(poly=(six_digits(conductance),))
        path = PathEntry(between=(first, second), conductance_W_per_K=curve)
        self._replace(paths=(*self.entry.paths, path))

    def lead_away(self, node: str, other: str, share: float) -> None:
        """Let a share of what a node's paths conduct to the ambient, laws apart, go to another node instead."""
        kept: list[PathEntry] = []
        for path in self.entry.paths:
            if set(path.between) != {node, AMBIENT} or path.law is not None:
                kept.append(path)
                continue
            part = self._scaled_path(path, lambda w: np.full_like(w, share), share)
            kept.append(self._scaled_path(path, lambda w: np.full_like(w, 1.0 - share), 1.0 - share))
            kept.append(part.model_copy(update={"between": (node, other)}))
        self._replace(paths=tuple(kept))

    def _most(self, name: str) -> float:
        """Give the conductance, W/K, that may be added to a node until it follows its neighbours too fast."""
        capacity = next(node.capacity_J_per_K for node in self.entry.nodes if node.name == name)
        pwm = points_of(self.full_scale)
        there = 0.0
        for path in self.entry.paths:
            if name in path.between:
                turning, still = values_of(path.conductance_W_per_K, pwm, self.full_scale)
                there += max(float(turning.max()), still)
        return max(FASTEST_SHARE * FASTEST * capacity / self._sample_time - there, 1e-6)

    def radiates(self, name: str, conductance: float, reference: float) -> None:
        """Add a radiation to the ambient, or add to the one that is there, at whose reference it is then."""
        conductance = min(conductance, self._most(name))
        for number, path in enumerate(self.entry.paths):
            if set(path.between) == {name, AMBIENT} and path.radiation is not None:
                same = ((path.radiation.reference_degC + ZERO_C) / (reference + ZERO_C)) ** 3
                more = self._with_more(path, conductance * same)
                self._replace(paths=(*self.entry.paths[:number], more, *self.entry.paths[number + 1 :]))
                return
        curve = PolyCurve(poly=(six_digits(conductance),))
        law = RadiationEntry(reference_degC=reference)
        path = PathEntry(between=(name, AMBIENT), conductance_W_per_K=curve, radiation=law)
        self._replace(paths=(*self.entry.paths, path))

    def _with_more(self, path: PathEntry, conductance: float) -> PathEntry:
        pwm = points_of(self.full_scale)
        turning, still = values_of(path.conductance_W_per_K, pwm, self.full_scale)
        curve = tabulated(pwm, turning + conductance, still + conductance)
        return path.model_copy(update={"conductance_W_per_K": curve})

    def _channel(self, column: str) -> None:
        if any(channel.column == column for channel in self.entry.channels):
            return
        if column == PWM:
            full = float(self.full_scale)
            channel = ChannelEntry(column=column, range=(-full, full), neutral=0.0)
            self._replace(channels=(*self.entry.channels, channel))
            return
        low, high = self._ranges[column]
        wider = self._margin * (high - low)
        low, high = (0.0 if low == 0.0 else low - wider), high + wider
        low, high = six_digits(low), six_digits(high)
        neutral = 0.0 if low <= 0.0 <= high else six_digits(0.5 * (low + high))
        self._replace(channels=(*self.entry.channels, ChannelEntry(column=column, range=(low, high), neutral=neutral)))


def ends(path: tuple[int, int], names: tuple[str, ...]) -> tuple[str, str]:
    """Name a path's ends as a coefficient file does."""
    return names[path[0]], AMBIENT if path[1] < 0 else names[path[1]]
