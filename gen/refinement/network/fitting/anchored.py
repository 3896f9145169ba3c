"""A file's network with everything in it free within what is known of it, and effects on top."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray, IntArray
from gen.identification.network.fitting.at_start import begun_from
from gen.identification.network.fitting.inputs import Inputs, Levels
from gen.identification.network.fitting.physics import Begun, Physical, incidence_of, outer_of
from gen.model.network import Network
from gen.refinement.network.changing import excess
from gen.refinement.network.changing.columns import Columns
from gen.refinement.network.changing.draft import Draft, Slope
from gen.refinement.network.changing.lagged import Lagged
from gen.refinement.network.changing.writer import NetworkWriter, Scale
from gen.refinement.network.effects import Motor, NetworkEffect
from gen.refinement.network.effects.base import OWN, Place, Seen
from gen.refinement.network.fitting.file_curves import LEAST_W_PER_K, FileCurves, motor_of
from gen.refinement.network.fitting.forms import HEAT, OUTSIDE, WITHIN, Form, turning_at

CAPACITY, LEVEL, LEVEL_WITHIN, BEND_SHARE, AT_REST, SLOPE_OVER_SPEED, OFFSET_K = 0.15, 0.15, 0.4, 0.15, 0.05, 0.2, 0.15
"""Standard deviations of what the file may be off by: logarithms of capacities, of levels, of those of paths within
the motor, of bends over speed (as a share of what identification allows), of conductances at rest
(`standstill_cooling` is what they may be off by), of what changes within the motor with speed; offsets.

Runs tell some paths within the motor to a percent and others hardly. Which, the runs that stand for the file tell
(`anchors.py`); held to 15 %, one of those that are hardly known makes a right effect pay for it."""


@dataclass(frozen=True, eq=False)
class Anchored:
    """Parameters: logarithms of capacities; of each path and heat how far it is off the file's curve, by logarithms;
    changes of the sensors' offsets, K; then each effect's numbers.

    Attributes
    ----------
    curves
        Conductances and heats as the file has them.
    effects
        On top.
    """

    curves: FileCurves
    effects: tuple[NetworkEffect, ...] = ()

    @classmethod
    def of(cls, network: Network, full_scale: int, columns: Columns) -> Anchored:
        """Without any effect: the file's network, the count that is 100 %, and what else drives the motor."""
        return cls(FileCurves(network, full_scale, columns))

    def with_effects(self, *effects: NetworkEffect) -> Anchored:
        """The same with these effects alone."""
        return Anchored(self.curves, effects)

    @property
    def network(self) -> Network:
        """The file's."""
        return self.curves.network

    @property
    def full_scale(self) -> int:
        """The count that is 100 %."""
        return self.curves.full_scale

    @property
    def columns(self) -> Columns:
        """What else drives the motor."""
        return self.curves.columns

    # Nodes and paths.

    @cached_property
    def order(self) -> tuple[int, ...]:
        """The file's nodes, the sensed ones first."""
        return tuple(excess.sensed_first(self.network))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of all nodes; the effects' own have none."""
        own = [self.network.nodes[k].name for k in self.order]
        return (*own, *(f"{effect.name} of {effect.component}" for effect in self.effects if effect.nodes))

    @property
    def base_nodes(self) -> int:
        """How many the file has."""
        return len(self.network.nodes)

    @property
    def nodes(self) -> int:
        """How many."""
        return self.base_nodes + sum(effect.nodes for effect in self.effects)

    @property
    def sensors(self) -> int:
        """How many are sensed."""
        return len(self.network.sensed)

    @cached_property
    def base_paths(self) -> tuple[tuple[int, int], ...]:
        """The file's paths."""
        place = {self.network.nodes[k].name: i for i, k in enumerate(self.order)}
        return tuple(
            (place[path.first], -1 if path.second is None else place[path.second]) for path in self.network.paths
        )

    @cached_property
    def base_heats(self) -> tuple[int, ...]:
        """Nodes of the file's heats."""
        place = {self.network.nodes[k].name: i for i, k in enumerate(self.order)}
        return tuple(place[heat.node] for heat in self.network.heats)

    @cached_property
    def paths(self) -> tuple[tuple[int, int], ...]:
        """All paths."""
        made = list(self.base_paths)
        for effect, place in zip(self.effects, self.places, strict=True):
            made += [(place.node if i == OWN else i, j) for i, j in effect.paths]
        return tuple(made)

    @cached_property
    def incidence(self) -> FloatArray:
        """For each path +1 at its first and -1 at its second node, shape (Q, n)."""
        return incidence_of(self.paths, self.nodes)

    @cached_property
    def outer(self) -> FloatArray:
        """1 for each path to the ambient, shape (Q,)."""
        return outer_of(self.paths)

    def motor(self) -> Motor:
        """What effects need to know of the file's network."""
        return motor_of(self.curves, self.order, self.base_paths, self.base_heats)

    # Places in the vector.

    @cached_property
    def forms(self) -> tuple[Form, ...]:
        """How each path of the file may be off."""
        return tuple(OUTSIDE if j < 0 else WITHIN for _, j in self.base_paths)

    @cached_property
    def _firsts(self) -> tuple[IntArray, IntArray, int]:
        """Where each path's and each heat's numbers begin, and where the offsets do."""
        sizes = np.array([form.size for form in self.forms] + [HEAT.size] * len(self.base_heats))
        firsts = self.nodes + np.concatenate([[0], np.cumsum(sizes)])
        count = len(self.forms)
        return firsts[:count], firsts[count:-1], int(firsts[-1])

    @property
    def levels_at(self) -> tuple[IntArray, IntArray]:
        """Places of the levels of the file's paths and heats."""
        paths, heats, _ = self._firsts
        return paths + np.array([form.level for form in self.forms], dtype=np.int64), heats + HEAT.level

    @property
    def offsets(self) -> IntArray:
        """Places of the changes of offsets, shape (S,)."""
        return self._firsts[2] + np.arange(self.sensors)

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """Of the effects."""
        first, node, path = self._firsts[2] + self.sensors, self.base_nodes, len(self.base_paths)
        made = []
        for effect in self.effects:
            count = len(effect.numbers) - effect.nodes
            columns = np.concatenate([np.arange(node, node + effect.nodes), np.arange(first, first + count)])
            made.append(Place(columns.astype(np.int64), node, path))
            first, node, path = first + count, node + effect.nodes, path + len(effect.paths)
        return tuple(made)

    @property
    def size(self) -> int:
        """Parameters that all runs share."""
        return self._firsts[2] + self.sensors + sum(len(e.numbers) - e.nodes for e in self.effects)

    # What is known before.

    def prior(self) -> tuple[FloatArray, FloatArray]:
        """Mean, shape (size,), and precision, shape (size, size)."""
        mean, deviation = np.zeros(self.size), np.full(self.size, LEVEL)
        mean[: self.base_nodes] = np.log(self.network.capacities[list(self.order)])
        deviation[: self.base_nodes] = CAPACITY
        paths, heats, _ = self._firsts
        precision = np.zeros((self.size, self.size))
        for form, first in zip((*self.forms, *[HEAT] * heats.size), (*paths, *heats), strict=True):
            at = slice(first + form.level, first + form.level + 1)
            deviation[at] = LEVEL_WITHIN if form is WITHIN else LEVEL
            if form is OUTSIDE:
                deviation[first] = AT_REST
            if form is WITHIN:
                deviation[first + 1] = SLOPE_OVER_SPEED
        deviation[self.offsets] = OFFSET_K
        for effect, place in zip(self.effects, self.places, strict=True):
            mean[place.columns] = [number.mean for number in effect.numbers]
            deviation[place.columns] = [number.deviation for number in effect.numbers]
        precision[np.diag_indices(self.size)] = deviation**-2
        for form, first in zip((*self.forms, *[HEAT] * heats.size), (*paths, *heats), strict=True):
            if form is not WITHIN:
                bends = slice(first + form.level + 1, first + form.size)
                precision[bends, bends] = form.precision[form.level + 1 :, form.level + 1 :] / BEND_SHARE**2
        for effect, place in zip(self.effects, self.places, strict=True):
            if effect.precision is not None:
                precision[np.ix_(place.columns, place.columns)] = effect.precision
        return mean, precision

    def start(self) -> FloatArray:
        """Where the search begins: at the file, with the effects' own starts."""
        vector = self.prior()[0]
        for effect, place in zip(self.effects, self.places, strict=True):
            vector[place.columns] = [number.fitted(number.start) for number in effect.numbers]
        return vector

    def values(self, vector: FloatArray) -> list[tuple[float, ...]]:
        """Give each effect's numbers."""
        return [
            tuple(number.value(float(x)) for number, x in zip(effect.numbers, vector[place.columns], strict=True))
            for effect, place in zip(self.effects, self.places, strict=True)
        ]

    @cached_property
    def _shares(self) -> FloatArray | None:
        """Of the sensed nodes' rises, what nodes without a sensor have at the start: what the file expects of its own,
        the average of an effect's own node; shape (h, S)."""
        if not self.network.hidden or any(node.start_from is None for node in self.network.hidden):
            return None
        place = [self.names.index(node.name) for node in self.network.sensed]
        named = {node.name: row for node, row in zip(self.network.hidden, self.network.hidden_at_start, strict=True)}
        shares = np.full((self.nodes - self.sensors, self.sensors), 1.0 / self.sensors)
        for row, name in enumerate(self.names[self.sensors : self.base_nodes]):
            shares[row, place] = named[name][:-1]
        return shares

    def begun(self, vector: FloatArray, sensed: FloatArray, ambient: FloatArray) -> Begun | None:
        """Where a file lets nodes start that tells what share of the sensed ones' rises they have.

        Of others each run's starts are its own (see `tracing.warm_start`).
        """
        return None if self._shares is None else begun_from(self._shares, self.size, sensed, ambient)

    # The network at distinct inputs.

    def physical(self, levels: Levels, vector: FloatArray) -> Physical:
        """Evaluate capacities, conductances and heats at each distinct input."""
        draft = Draft(np.exp(np.clip(vector[: self.nodes], -60.0, 60.0)), levels.count, len(self.paths))
        rest, turn = levels.rest, 1.0 - levels.rest
        paths, heats, _ = self._firsts
        for q, (form, first) in enumerate(zip(self.forms, paths, strict=True)):
            turning, still = self.curves.path(q, levels)
            value, slopes = _off(form, int(first), turn * turning, rest * still, levels, vector)
            draft.conductance.add(q, value, slopes)
        for k, (q, _) in enumerate(self.network.laws):
            draft.law(q, self.base_paths[q], self.columns.excess(levels, k))
        for h, (node, heat, first) in enumerate(zip(self.base_heats, self.network.heats, heats, strict=True)):
            turning, still = self.curves.heat(h, levels)
            value, slopes = _off(
                HEAT, int(first), turn * turning + rest * still, np.zeros(levels.count), levels, vector
            )
            draft.warm(node, value, heat.per_K, heat.reference, slopes)
        for effect, place in zip(self.effects, self.places, strict=True):
            effect.act(draft, levels, vector[place.columns], place)
        # The modes need conductances above 0.
        np.maximum(draft.conductance.value, LEAST_W_PER_K, out=draft.conductance.value)
        return draft.physical()

    def shown(self, inputs: Inputs, vector: FloatArray, temperature: FloatArray, change: FloatArray) -> FloatArray:
        """Give what sensors show, shape (N, S), degC."""
        own = [node.sensor.offset for node in self.network.sensed if node.sensor is not None]
        made = temperature + vector[self.offsets] + np.array(own)
        for one in self._lagged(inputs, vector):
            made[:, one.sensor] += one.behind(change[:, one.sensor])
        later = self.columns.later(inputs.levels)[inputs.level]
        seen = Seen(temperature, inputs.ambient, inputs.begins / 3600.0)
        for effect, place in zip(self.effects, self.places, strict=True):
            for read in effect.read(seen, vector[place.columns]):
                made[:, read.sensor] += later * read.kelvin
        return np.asarray(made)

    @cached_property
    def lagging(self) -> tuple[int, ...]:
        """Sensors that lag as the file says, or as an effect on top does."""
        lags = {s for s, node in enumerate(self.network.sensed) if node.sensor is not None and node.sensor.lag}
        return tuple(sorted(lags | {effect.lagging for effect in self.effects if effect.lagging is not None}))

    def _lagged(self, inputs: Inputs, vector: FloatArray) -> list[Lagged]:
        """The lagging sensors, with the lag in each bin: effects act in later runs alone."""
        if not self.lagging:
            return []
        later = self.columns.later(inputs.levels)[inputs.level]
        made = []
        for s in self.lagging:
            sensor = self.network.sensed[s].sensor
            lag = np.full(inputs.level.size, 0.0 if sensor is None else sensor.lag)
            for effect, place in zip(self.effects, self.places, strict=True):
                if effect.lagging == s:
                    lag += later * vector[place.columns[0]]
            made.append(Lagged(inputs, s, lag))
        return made

    def through_sensors(self, inputs: Inputs, vector: FloatArray, slopes: NDArray[Any], changes: NDArray[Any]) -> None:
        """Turn derivatives of temperatures into those of readings, where sensors lag or show a share too much."""
        shares = [
            share
            for effect, place in zip(self.effects, self.places, strict=True)
            for share in effect.by_temperature(vector[place.columns])
        ]
        if shares:
            later = self.columns.later(inputs.levels)[inputs.level][:, None]
            added = [(sensor, later * share * slopes[:, node]) for sensor, node, share in shares]
            for sensor, kelvin in added:
                slopes[:, sensor] += kelvin
        for one, change in zip(self._lagged(inputs, vector), np.swapaxes(changes, 0, 1), strict=True):
            slopes[:, one.sensor] += one.behind(change)

    def by_reading(
        self, inputs: Inputs, vector: FloatArray, temperature: FloatArray, change: FloatArray
    ) -> list[tuple[int, int, FloatArray | float]]:
        """Derivatives of what sensors show by offsets and by effects on readings."""
        made: list[tuple[int, int, FloatArray | float]] = [(s, int(at), 1.0) for s, at in enumerate(self.offsets)]
        later = self.columns.later(inputs.levels)[inputs.level]
        seen = Seen(temperature, inputs.ambient, inputs.begins / 3600.0)
        for effect, place in zip(self.effects, self.places, strict=True):
            for read in effect.read(seen, vector[place.columns]):
                by_number = zip(place.columns, read.slopes, strict=True)
                made += [(read.sensor, int(column), later * slope) for column, slope in by_number]
        lags = {one.sensor: one for one in self._lagged(inputs, vector)}
        for effect, place in zip(self.effects, self.places, strict=True):
            if effect.lagging is not None:
                by_lag = lags[effect.lagging].by_lag(change[:, effect.lagging])
                made.append((effect.lagging, int(place.columns[0]), later * by_lag))
        return made

    def implausible(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nothing: what a node may be, the file says."""
        return np.zeros(0), np.zeros((0, self.size))

    # Writing.

    def write(self, entry: NetworkWriter, vector: FloatArray, kept: Sequence[NetworkEffect]) -> None:
        """Write what was fitted into a file's network, and last those effects that are kept."""
        names = self.names
        for i in range(self.base_nodes):
            entry.capacity(names[i], float(np.exp(vector[i])))
        paths, heats, _ = self._firsts
        for q, (form, first) in enumerate(zip(self.forms, paths, strict=True)):
            own = vector[first : first + form.size]
            entry.scale_path_number(q, _scale(form, own), float(np.exp(form.at_rest @ own)))
        for h, first in enumerate(heats):
            entry.scale_heat_number(h, _scale(HEAT, vector[first : first + HEAT.size]))
        for s, at in enumerate(self.offsets):
            entry.sensor(names[s], offset_K=float(vector[at]))
        for effect, values in zip(self.effects, self.values(vector), strict=True):
            if effect in kept:
                effect.write(entry, values)


def _scale(form: Form, own: FloatArray) -> Scale:
    """How far a curve is off, by speed."""
    return lambda w: np.asarray(np.exp(form.turning(w) @ own))


def _off(
    form: Form, first: int, turning: FloatArray, still: FloatArray, levels: Levels, vector: FloatArray
) -> tuple[FloatArray, list[Slope]]:
    """A curve of the file, off by what its numbers say, and derivatives by them."""
    own = vector[first : first + form.size]
    functions = turning_at(form, levels)
    moved = turning * np.exp(np.clip(functions @ own, -60.0, 60.0))
    made, slopes = moved, [moved * functions[:, k] for k in range(form.size)]
    if form is not HEAT:
        held = still * np.exp(np.clip(form.at_rest @ own, -60.0, 60.0))
        made = moved + held
        slopes = [slope + held * form.at_rest[k] for k, slope in enumerate(slopes)]
    return made, [(first + k, slope) for k, slope in enumerate(slopes)]
