"""What is known before any run: wide, physical, and written down.

Every logarithm is within a factor of e^2 (standard deviation) of a typical value: a sensor's bead and a casing are
parts of one motor. Typical are: a capacity of 100 J/K (a few hundred grams of metal); conductances that make the
capacities settle within the time that the runs show; heats that make the rises that the runs show. Temperatures alone
do not determine the scale of all capacities, conductances and heats together: it is the prior's. How they go with
speed, and what they are at rest, stands in `speed_laws`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.driven import known
from gen.identification.network.fitting.growing import UNSURE_PER_K, USUAL_PER_K
from gen.identification.network.fitting.inputs import ROOM_S, START_K, Inputs
from gen.identification.network.fitting.rooms import places_of, share_level, unsure_K
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.speed_laws import ALL_AT_REST, CONSTANT, HEAT, OUTSIDE, WITHIN
from gen.identification.network.fitting.structure import Structure

FACTOR = 2.0
"""Standard deviation of a logarithm. Narrower ones cost a motor of others' logs a factor of three in its error."""
FARTHEST = 8.0
"""Standard deviations from its mean beyond which no parameter is tried."""
CAPACITY = 100.0
"""J/K."""
OFFSET_K = 0.7
"""Standard deviation of a sensor's offset, K."""
START_FACTOR = 1.0
"""Standard deviation of the logarithm by which hidden nodes start warmer than they would rest."""
NATURAL = (0.0, 1.0)
"""Logit of natural convection's share of the loss at rest: painted metal loses about as much by radiation."""
ROOM_K = 1.5
"""Of the level of an unmeasured ambient about what is assumed, K."""
COLD_ROOM_K = 0.3
"""The same where a run begins as warm as its room: its sensors read that, each a little off."""
ROOM_STEP_K = 0.5
"""Of its change in an hour, K."""


@dataclass(frozen=True, eq=False)
class Prior:
    """A normal distribution.

    Attributes
    ----------
    mean
        Shape (P,).
    precision
        Shape (P, P).
    """

    mean: FloatArray
    precision: FloatArray

    @cached_property
    def deviation(self) -> FloatArray:
        """Standard deviations, shape (P,)."""
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(self.precision))), dtype=np.float64)

    def within(self, vector: FloatArray) -> FloatArray:
        """Hold parameters to where numbers stay finite: no search has to go further than this."""
        return np.clip(vector, self.mean - FARTHEST * self.deviation, self.mean + FARTHEST * self.deviation)


def prior_of(structure: Structure, inputs: Inputs, scale: Scale) -> Prior:
    """Write the prior down."""
    nodes, shared = structure.nodes, structure.size
    own = nodes + inputs.room.shape[-1]
    size = shared + len(inputs.runs) * own
    mean, deviation = np.zeros(size), np.full(size, FACTOR)
    mean[structure.capacities], deviation[structure.capacities] = np.log(CAPACITY), FACTOR
    loss = CAPACITY / scale.settling_s
    inner = np.log(2.0 * loss / max(nodes - 1, 1))
    levels = {OUTSIDE: np.log(loss), WITHIN: inner, CONSTANT: inner}
    blocks: list[tuple[slice, FloatArray]] = []
    for law, at in zip(structure.laws, structure.conductances, strict=True):
        mean[at] = law.mean
        mean[at.start + law.level] = levels[law]
        blocks.append((at, law.bending(structure.bend)))
    for at in structure.heats:
        mean[at] = HEAT.mean
        mean[at.start + HEAT.level] = np.log(loss * scale.rise_K / 2.0)
        blocks.append((at, HEAT.bending(structure.bend)))
    mean[structure.feeds] = np.log(loss * scale.rise_K / 2.0)
    mean[structure.still], deviation[structure.still] = NATURAL
    mean[structure.growing], deviation[structure.growing] = USUAL_PER_K, UNSURE_PER_K
    mean[structure.offsets], deviation[structure.offsets] = 0.0, OFFSET_K
    mean[structure.factors], deviation[structure.factors] = 0.0, START_FACTOR
    precision = np.zeros((size, size))
    for r in range(len(inputs.runs)):
        first = shared + r * own
        sensed, hidden = inputs.loose[r]
        if structure.apart and inputs.warm[r]:
            hidden = START_K + structure.apart * inputs.warm[r]
        deviation[first : first + len(structure.sensed)] = sensed
        deviation[first + len(structure.sensed) : first + nodes] = hidden
        deviation[first + nodes : first + own] = ROOM_K if not inputs.runs[r].ambient_known else 1e-3
        if inputs.runs[r].cold:
            deviation[first + nodes] = COLD_ROOM_K
    precision[np.diag_indices(size)] = 1.0 / deviation**2
    for at, block in blocks:
        level = np.diag(block) == 0.0
        precision[at, at] = block + np.diag(np.where(level, FACTOR**-2, 0.0))
    for place, middle, apart in known(structure):
        mean[place], precision[place, place] = middle, apart**-2
    _join_at_rest(structure, precision)
    for r in range(len(inputs.runs)):
        at, hats = shared + r * own + nodes, own - nodes
        # A walk: the variance grows with the time between two hats, and a short run has them close together.
        apart_K = ROOM_STEP_K * np.sqrt(inputs.runs[r].duration / max(hats - 1, 1) / ROOM_S)
        for b in range(hats - 1):
            pair = np.ix_([at + b, at + b + 1], [at + b, at + b + 1])
            precision[pair] += np.array([[1.0, -1.0], [-1.0, 1.0]]) / apart_K**2
    unsure = unsure_K(inputs)
    if unsure > 0.0:
        share_level(precision, places_of(inputs, shared, nodes), unsure)
    return Prior(mean, precision)


def _join_at_rest(structure: Structure, precision: FloatArray) -> None:
    """Conductances at rest have something in common: what one surface does in still air, the others do too."""
    places = [at.start for law, at in zip(structure.laws, structure.conductances, strict=True) if law is OUTSIDE]
    block = np.ix_(places, places)
    own = np.linalg.inv(precision[block])
    precision[block] = np.linalg.inv(own + ALL_AT_REST**2)
