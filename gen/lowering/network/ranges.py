"""What temperatures a network can reach, and how fast they change, whatever PWM, ambient and channels do.

The comparison principle for systems without negative entries off their diagonal (Smith, Monotone Dynamical Systems,
chapter 3): a vector U with M U + f <= 0 for every |PWM| and all that channels may say, and not below the start, stays
above every solution. Each row is affine in its factors, so that their ends are all that has to be looked at. Where
paths have laws the same holds of what the equations give at U, which Newton's method finds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.network.terms import Term, Terms, drifting_sensor, lagging_reading, scaled, slope_of
from gen.model import ThermalModel
from gen.model.network import Network
from gen.model.network_parts import Node

_NEWTON_STEPS = 60
_SETTLED_K = 1e-9
"""By how much Newton's last step may move: claims are wider by far more."""
MARGIN_K = 0.01
"""By which the board's own temperatures may lie outside of the exact ones' range; errors stay far below it."""
LAW_MARGIN_K = 0.1
"""The same with convection or radiation, whose conductances are those at a sample's beginning: the largest error up to
which such a network can be built, less than half of a thermocouple amplifier's step."""


@dataclass(frozen=True, eq=False)
class Ranges:
    """Ends of everything that the board holds.

    Attributes
    ----------
    low, high
        Temperatures by state, degC, shape (n,).
    ambient
        Ends of the ambient, degC.
    margin
        By which that is more than the exact temperatures reach, K.
    """

    low: FloatArray
    high: FloatArray
    ambient: tuple[float, float]
    margin: float

    def ends(self, term: Term) -> tuple[float, float]:
        """Least and largest temperature of a term's source, degC."""
        if term.source == "state":
            return float(self.low[term.other]), float(self.high[term.other])
        return self.ambient if term.source == "ambient" else (term.reference, term.reference)

    def of(self, target: int) -> tuple[float, float]:
        """Least and largest temperature of a state, degC."""
        return float(self.low[target]), float(self.high[target])

    def difference(self, term: Term) -> float:
        """Largest magnitude of the difference that a term multiplies, K."""
        low, high = self.ends(term)
        if term.law is not None:
            return term.law.largest((low, high), self.of(term.target))
        return max(high - float(self.low[term.target]), float(self.high[term.target]) - low)


def reachable(model: ThermalModel, terms: Terms) -> Ranges | None:
    """Ranges for every sequence of PWM, ambient and channels in the domain; None where nothing bounds them."""
    ambient, shown = model.domain_ambient, model.domain_temperature
    offsets = [0.0, *(node.sensor.offset for node in model.network.sensed if node.sensor)] if model.network else [0.0]
    start = min(ambient[0], shown[0] - max(offsets)), max(ambient[1], shown[1] - min(offsets))
    first = _starts(model, terms, start)
    high = _bounding(terms, ambient[1], first[1])
    low = _bounding(terms, ambient[0], first[0], upper=False)
    if high is None or low is None:
        return None
    margin = LAW_MARGIN_K if terms.laws else MARGIN_K
    return Ranges(low - margin, high + margin, ambient, margin)


def _starts(model: ThermalModel, terms: Terms, sensed: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Least and largest start of each state, degC; hidden nodes may start outside of what sensed ones do.

    No sensor has drifted at a start.
    """
    states = len(terms.states)
    low, high = np.full(states, sensed[0]), np.full(states, sensed[1])
    network = model.network
    # By how much further nodes may start whose sensors' gains are wrong: below, and above.
    further = np.array([_further(model, node, sensed) for node in network.sensed]) if network else np.zeros((0, 2))
    for node, (below, above) in zip(network.sensed, further, strict=True) if network else ():
        for name in (node.name, lagging_reading(node.name)):
            if name in terms.states:
                place = terms.states.index(name)
                low[place], high[place] = low[place] + below, high[place] + above
        if (drift := drifting_sensor(node.name)) in terms.states:
            low[terms.states.index(drift)] = high[terms.states.index(drift)] = 0.0
    for node, weights in zip(network.hidden, network.hidden_at_start, strict=True) if network else ():
        rise, room = float(weights[:-1].sum()), sorted(weights[-1] * end for end in model.domain_ambient)
        place = network.index(node.name) if network else 0
        below, above = weights[:-1] @ further
        low[place] = min(low[place], rise * sensed[0] + room[0] + below)
        high[place] = max(high[place], rise * sensed[1] + room[1] + above)
    return low, high


def _further(model: ThermalModel, node: Node, sensed: tuple[float, float]) -> tuple[float, float]:
    """By how much a node may start below and above what sensors without an error of their gain let others start, K."""
    sensor = node.sensor
    if sensor is None or sensor.gain_error == 0.0:
        return 0.0, 0.0
    shown = [float(sensor.temperature(end, at)) for end in model.domain_temperature for at in model.domain_ambient]
    return min(0.0, min(shown) - sensed[0]), max(0.0, max(shown) - sensed[1])


def widest_shown(network: Network, ranges: Ranges) -> float:
    """Largest magnitude of a reading, and of its difference to the ambient, of sensors with an error of their gain."""
    ends = (*ranges.low, *ranges.high, *ranges.ambient, 0.0)
    span = float(max(ends) - min(ends))
    return max(
        (
            (1.0 + abs(s.gain_error)) * span + abs(s.offset) + abs(s.drift)
            for s in (n.sensor for n in network.sensed)
            if s and s.gain_error
        ),
        default=0.0,
    )


def widest_reference(terms: Terms, ranges: Ranges) -> float:
    """Largest magnitude of what is no state's temperature, degC, and of any state's difference to its own, K.

    That at which a heat was given may lie far beyond all that a node reaches: a file may count a heat from 0 K.
    """
    own = [term for term in terms.terms if term.source == "reference"]
    return max((max(abs(term.reference), ranges.difference(term)) for term in own), default=0.0)


def widest_start(network: Network, ranges: Ranges) -> float:
    """Largest magnitude of a hidden node's start, degC, were it made from temperatures anywhere in the ranges."""
    rises = [weights[:-1].sum() for weights in network.hidden_at_start]
    ends = (*ranges.low, *ranges.high, *ranges.ambient)
    if max(rises, default=0.0) <= 1.0 + 1e-12:
        return 0.0  # between temperatures that fit
    return float(max(rises) * (max(ends) - min(ends)) + max(map(abs, ranges.ambient)))


def _bounding(terms: Terms, ambient: float, start: FloatArray, *, upper: bool = True) -> FloatArray | None:
    """The least U >= start with M U + a ambient + f <= 0, or the greatest L <= start with the other sign."""
    if not terms.laws:
        return _bounded(terms, ambient, start, None, upper=upper)
    found = start
    for _ in range(_NEWTON_STEPS):
        before, after = found, _bounded(terms, ambient, start, found, upper=upper)
        if after is None:
            return None
        found = after
        if float(np.abs(found - before).max()) <= _SETTLED_K:
            return found
    return None


def _bounded(
    terms: Terms, ambient: float, start: FloatArray, at: FloatArray | None, *, upper: bool
) -> FloatArray | None:
    """The same with every law as it is near some temperatures of the states, if there are any laws."""
    rows, right = [], []
    for target in range(len(terms.states)):
        for corner in terms.corners(target):
            left, constant = matrix_row(terms, target, corner, ambient, at)
            rows.append(left)
            right.append(-constant)
    matrix, limit = np.concatenate(rows), np.concatenate(right)
    scale = np.abs(matrix).sum(axis=1)
    matrix, limit = matrix / scale[:, None], limit / scale
    return _least(matrix, limit, start) if upper else _negated(_least(matrix, -limit, -start))


def _negated(found: FloatArray | None) -> FloatArray | None:
    return None if found is None else -found


def _least(matrix: FloatArray, limit: FloatArray, start: FloatArray) -> FloatArray | None:
    """The least U with matrix U <= limit and U >= start, all entries at once; none larger than 1e6."""
    from scipy.optimize import linprog  # slow to import: reading and checking a file does without

    size = matrix.shape[1]
    matrix, index = np.unique(np.column_stack([matrix, limit]), axis=0, return_index=True)
    bounds = [(one, 1e6) for one in start.tolist()]
    solved = linprog(np.ones(size), A_ub=matrix[:, :-1], b_ub=limit[index], bounds=bounds, method="highs")
    return np.asarray(solved.x, dtype=np.float64) if solved.status == 0 else None


def matrix_row(
    terms: Terms, target: int, corner: dict[int, float], ambient: float, at: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """One state's row of h M, shape (rows, n), and the rest h (a T_ambient + f), shape (rows,).

    Parameters
    ----------
    terms, target
        Which.
    corner
        Values of factors, and of laws' slopes where `at` does not say them.
    ambient
        degC.
    at
        States about which laws are taken as lines, degC.
    """
    own = terms.of(target)
    count = own[0].rate.size if own else terms.terms[0].rate.size
    row, rest = np.zeros((count, len(terms.states))), np.zeros(count)
    for term in own:
        rate = scaled(term, corner) * (-1.0 if term.growing else 1.0)
        if term.law is not None:
            slope = corner.get(slope_of(term.law), 0.0)
            if at is not None:
                there, here = float(at[term.other]) if term.source == "state" else ambient, float(at[target])
                slope = term.law.slope(here, there)
                known = here - there if term.source == "state" else here
                rest += rate * (term.law.driving(there, here) + slope * known)
            row[:, target] -= rate * slope
            if term.source == "state":
                row[:, term.other] += rate * slope
            continue
        row[:, target] -= rate
        if term.source == "state":
            row[:, term.other] += rate
        else:
            rest += rate * (ambient if term.source == "ambient" else term.reference)
    for heat in terms.heats_of(target):
        rest += scaled(heat, corner)
    return row, rest


def speeds(terms: Terms, ranges: Ranges) -> FloatArray:
    """Largest magnitude of h (M T + f) in the ranges by row of the domain and state, K per sample, shape (rows, n)."""
    found = []
    for target in range(len(terms.states)):
        worst = np.zeros(terms.terms[0].rate.size)
        for corner in terms.corners(target):
            warmth = sum((scaled(heat, corner) for heat in terms.heats_of(target)), np.zeros_like(worst))
            # Affine in the target's own temperature, whose ends are tried; sources stand where it is worst.
            for end in (ranges.low[target], ranges.high[target]):
                rising, falling = warmth.copy(), warmth.copy()
                for term in terms.of(target):
                    rate, (low, high) = scaled(term, corner), ranges.ends(term)
                    first, second = sorted((low - end, high - end))
                    if term.law is not None:
                        # No line in the target's temperature: as if it had both ends at once.
                        first, second = (
                            term.law.driving(low, ranges.high[target]),
                            term.law.driving(high, ranges.low[target]),
                        )
                    if term.growing:
                        first, second = -second, -first
                    falling += rate * first
                    rising += rate * second
                worst = np.maximum(worst, np.maximum(np.abs(rising), np.abs(falling)))
        found.append(worst)
    return np.stack(found, axis=1)
