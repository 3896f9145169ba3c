"""Channels for a campaign, and how far the board is from the exact solution of a model with effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import IntArray
from gen.lowering.effects import EffectsProgram
from gen.lowering.program import Program
from gen.model.effects import Applied
from gen.reference.model import ReferenceModel
from gen.verification.accuracy import ErrorCourse
from gen.verification.held import HeldSolution
from gen.verification.profiles import campaign

#: Samples of the comparison with the exact solution, which is integrated step by step.
EFFECTS_LENGTH = 14_400
_POINTS = 60
_CHANGES = 0.02
"""Share of samples at which the channels change."""


def course_with_effects(program: Program, effects: Sequence[Applied], lanes: int, length: int) -> ErrorCourse:
    """Compare the reference's readings with the exact solution of a model with effects.

    Parameters
    ----------
    program, effects
        What the board holds, and its effects.
    lanes, length
        Of a campaign from starts within the domain, with channels that are held for some seconds and lie within the
        middle half of their ranges; `length` in samples. A lane counts until the board holds something to its range.
    """
    assert program.effects is not None
    random = np.random.default_rng(311)
    profile = campaign(program.model, lanes, length, seed=10_800)
    low = max(component.start_range_mK[0] for component in program.components)
    high = min(component.start_range_mK[1] for component in program.components)
    start = np.clip(profile.start_mK, max(low, 0), high // 2)
    names = program.model.component_names
    told = _drawn(random, program.effects, lanes)
    board = ReferenceModel(program, [int(value) for value in start], told)
    exact = HeldSolution(
        program.model,
        effects,
        dict.fromkeys(names, start / 1000.0),
        told[0] / 1000.0,
        {name: rise / 1000.0 for name, rise in board.starts_mK.items()},
    )
    ends = np.linspace(0, length, min(_POINTS, length) + 1).round().astype(int)[1:]
    worst = np.zeros((len(ends), len(names)))
    interval = 0
    for step in range(length):
        told = np.where(random.random(lanes) < _CHANGES, _drawn(random, program.effects, lanes), told)
        board.set_channels(told)
        board.step(profile.pwm[:, step])
        columns = {c.column: told[i] / 1000.0 for i, c in enumerate(program.effects.channels)}
        exact.step(profile.pwm[:, step], told[0] / 1000.0, columns)
        error = np.where(board.within_ranges, np.abs(board.rises - exact.shown()), 0.0)
        worst[interval] = np.maximum(worst[interval], error.max(axis=1))
        interval += step + 1 == ends[interval]
    return ErrorCourse(
        (ends * program.model.sample_time).tolist(),
        {name: worst[:, number].tolist() for number, name in enumerate(names)},
    )


def _drawn(random: np.random.Generator, effects: EffectsProgram, lanes: int) -> IntArray:
    values = []
    for channel in effects.channels:
        quarter = (channel.high - channel.low) // 4
        values.append(random.integers(channel.low + quarter, channel.high - quarter + 1, lanes))
    return np.array(values, dtype=np.int64)
