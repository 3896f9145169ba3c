"""Which paths and heats are needed: those through which next to nothing flows are taken out, if nothing gets worse."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.identification.network.fitting.priors import prior_of
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.speed_laws import WITHIN
from gen.identification.network.fitting.structure import Structure
from gen.identification.network.left_out import LeftOut, left_out
from gen.identification.network.search import Found, all_found, tightened
from gen.identification.network.starts import taken_over
from gen.identification.network.telling.uncertainty import spread_of
from gen.side_by_side import has_help

SHARES = (0.02, 0.005)
"""Of the whole heat: paths and heats that never carry more are candidates; the boldest cut that does no harm stays."""
AT_EACH = 12
"""Linearisations after a cut."""
SHOWN = 2.0
"""Standard deviations from which a slope over speed is shown by the runs; a path without costs the board no table."""
HARM = 1.02
"""Factor on the left-out error within which a cut does no harm."""
MOST_TABLES = 60
"""Of 1 KB each, as one over all |PWM| has: the Mega reads 60 KB of its flash by addresses of 16 bits."""
OBJECTION = 4.0
"""Increase of the runs' own weighed squares for each number that is cut, beyond which the runs speak against a cut.
Of five steps at five speeds, one left out is missed by a kelvin or two at best: next to that the left-out error does
not see that a part is torn from the rest of the motor."""


def pruned(
    found: Found, judged: LeftOut, folds: list[BoolArray], scale: Scale, slack_K: float
) -> tuple[Found, LeftOut]:
    """Take out what is not needed.

    Parameters
    ----------
    found, judged
        The full network and its left-out error.
    folds
        What each fold leaves out.
    scale
        For the prior.
    slack_K
        Errors that differ by less, in the mean square, do not count.
    """
    structures = dict.fromkeys(_cut(found, share) for share in SHARES)
    structures.pop(found.structure, None)
    for smaller in _refitted(found, list(structures), scale):
        errors = left_out(smaller, folds)
        if _harmless(errors, judged, slack_K) and not _objected(found, smaller):
            found, judged = smaller, errors
            break
    constant = _constant(found)
    if constant:
        (smaller,) = _refitted(found, [replace(found.structure, constant=constant)], scale)
        errors = left_out(smaller, folds)
        if _harmless(errors, judged, slack_K) and not _objected(found, smaller):
            return smaller, errors
    return found, judged


def held_to_tables(found: Found) -> Structure:
    """Give the structure with as many paths within the motor constant as it takes for a board to hold all tables.

    Those whose change with speed the runs show least are. What goes by temperature is worth more than these.
    """
    structure = found.structure
    varying = [q for q, law in enumerate(structure.laws) if law is WITHIN]
    too_many = tables_of(structure) - MOST_TABLES
    if too_many <= 0:
        return structure
    deviation = spread_of(found).deviation
    slopes = [structure.conductances[q].stop - 1 for q in varying]
    shown = np.abs(found.vector[slopes]) / deviation[slopes]
    least = [varying[k] for k in np.argsort(shown)[: -(-too_many // 2)]]
    return replace(structure, constant=structure.constant | frozenset(least))


def tables_of(structure: Structure) -> int:
    """Say how many words of a board's network go with speed: a path within the motor has one at each of its ends."""
    within = sum(law is WITHIN for law in structure.laws)
    outside = sum(j < 0 for _, j in structure.paths)
    by_temperature = outside * bool(structure.natural) + len(structure.heated) * (structure.warmth is not None)
    return 2 * within + outside + len(structure.heated) + by_temperature


def _refitted(found: Found, structures: Sequence[Structure], scale: Scale) -> Iterator[Found]:
    """Fit smaller networks: all side by side, or, without help, one by one as they are asked for."""
    inputs = found.problem.inputs
    problems = [Problem(structure, inputs, prior_of(structure, inputs, scale)) for structure in structures]
    searches = []
    for problem in problems:
        start = taken_over(problem, found.problem, found.vector)
        searches.append(partial(tightened, problem, start, found.density, AT_EACH, rounds=2))
    if has_help():
        yield from all_found(problems, searches)
    else:
        yield from (search() for search in searches)


def _harmless(errors: LeftOut, judged: LeftOut, slack_K: float) -> bool:
    return errors.score_K**2 <= (HARM * judged.score_K) ** 2 + slack_K**2


def _objected(found: Found, smaller: Found) -> bool:
    """Whether the runs, weighed as for the larger network, speak against the smaller one."""
    inputs = found.problem.inputs
    residual = smaller.fit.evaluated.residual
    more = float(np.sum(inputs.weight * residual**2)) - found.fit.evaluated.cost
    return more > OBJECTION * (found.structure.size - smaller.structure.size)


def _constant(found: Found) -> frozenset[int]:
    """Paths within the motor of which the runs do not show that they change with speed."""
    deviation = spread_of(found).deviation
    structure = found.structure
    made = []
    for q, (law, at) in enumerate(zip(structure.laws, structure.conductances, strict=True)):
        if law is WITHIN and abs(found.vector[at.stop - 1]) < SHOWN * deviation[at.stop - 1]:
            made.append(q)
    return frozenset(made)


def flows(found: Found) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give the most heat that ever flows through each path, that each node is given by PWM, and by each column.

    Returns
    -------
    paths, heats, fed
        All over the largest total of heats, shapes (Q,), (heated,) and (fed,).
    """
    problem = found.problem
    structure, inputs = problem.structure, problem.inputs
    physics = structure.physical(inputs.levels, found.vector)
    ends = np.column_stack([found.fit.evaluated.after, problem.ambient(found.vector)])
    conductance = physics.conductance[inputs.level]
    most = [
        float(np.max(np.abs(conductance[:, q] * (ends[:, i] - ends[:, j])))) for q, (i, j) in enumerate(structure.paths)
    ]
    total = max(float(np.max(physics.heat.sum(axis=1))), 1e-12)
    fed = structure.fed_W(inputs.levels, found.vector)
    by_pwm = physics.heat.copy()
    for k, (_, node) in enumerate(structure.fed):
        by_pwm[:, node] -= fed[:, k]
    heats = by_pwm[:, list(structure.heated)].max(axis=0)
    return np.array(most) / total, np.asarray(heats / total), np.asarray(fed.max(axis=0, initial=0.0) / total)


def _cut(found: Found, share: float) -> Structure:
    """The structure without what never carries more than a share; every node keeps a way out, and one its heat."""
    structure = found.structure
    by_path, by_heat, by_feed = flows(found)
    kept = [q for q in range(len(structure.paths)) if by_path[q] > share]
    for q in sorted(set(range(len(structure.paths))) - set(kept), key=lambda q: -by_path[q]):
        if not _all_reach([structure.paths[k] for k in kept], structure.nodes):
            kept.append(q)
    kept.sort()
    heated = [node for h, node in enumerate(structure.heated) if by_heat[h] > share]
    heated = heated or [structure.heated[int(np.argmax(by_heat))]]
    return replace(
        structure,
        paths=tuple(structure.paths[q] for q in kept),
        heated=tuple(heated),
        constant=frozenset(),
        fed=tuple(fed for k, fed in enumerate(structure.fed) if by_feed[k] > share),
    )


def _all_reach(paths: list[tuple[int, int]], nodes: int) -> bool:
    reached = {-1}
    while True:
        more = {end for path in paths if reached & set(path) for end in path} - reached
        if not more:
            return len(reached) == nodes + 1
        reached |= more
