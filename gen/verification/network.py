"""How far the board is from the exact solution of a network, over whole runs with channels that change."""

from __future__ import annotations

import numpy as np

from gen.arrays import IntArray
from gen.lowering.effects.program import Channel
from gen.lowering.program import Program
from gen.model.network_solution import NetworkSolution, Steps
from gen.reference.board import reference_of
from gen.reference.network import ReferenceNetwork
from gen.verification.accuracy import ErrorCourse
from gen.verification.profiles import campaign

_POINTS = 60
_CHANGES = 0.02
"""Share of samples at which the channels change."""


def course_of_network(program: Program, lanes: int, length: int) -> ErrorCourse:
    """Compare the reference's readings with the exact solution of its network.

    Parameters
    ----------
    program
        What the board holds.
    lanes, length
        Of a campaign from starts within the domain, with channels that are held for some seconds and lie in their
        ranges; `length` in samples.
    """
    model, channels = program.model, program.channels
    solution = NetworkSolution(model)
    random = np.random.default_rng(41)
    profile = campaign(model, lanes, length, seed=10_800)
    told = _drawn(random, channels, lanes)
    low, high = (end * 1000.0 for end in model.domain_temperature)
    start = np.clip(profile.start_mK, np.ceil(low - told[0].min()), np.floor(high - told[0].max())).astype(np.int64)
    board = reference_of(program, start.tolist(), told)
    assert isinstance(board, ReferenceNetwork)
    names = model.component_names
    states = solution.start(dict.fromkeys(names, (start + told[0]) / 1000.0), told[0] / 1000.0)
    step_s = np.full(lanes, model.sample_time)
    ends = np.linspace(0, length, min(_POINTS, length) + 1).round().astype(int)[1:]
    worst = np.zeros((len(ends), len(names)))
    interval = 0
    plain = len(channels) == 1 and not solution.network.laws
    table = solution.steps(np.arange(256), np.full(256, model.sample_time)) if plain else None
    for step in range(length):
        told = np.where(random.random(lanes) < _CHANGES, _drawn(random, channels, lanes), told)
        board.set_channels(told)
        board.step(profile.pwm[:, step])
        pwm = np.clip(np.abs(profile.pwm[:, step]), *model.domain_pwm)
        if table is not None:
            steps = Steps(table.increment[pwm], table.ambient[pwm], table.heat[pwm])
            states = states + np.einsum("lij,lj->li", steps.increment, states) + steps.heat
            states = states + steps.ambient * (told[0] / 1000.0)[:, None]
        else:
            columns = {channel.column: told[k] / 1000.0 for k, channel in enumerate(channels) if k}
            states = solution.advance(states, pwm, step_s, told[0] / 1000.0, columns)
        shown = np.array(list(solution.shown(states, told[0] / 1000.0).values()))
        worst[interval] = np.maximum(worst[interval], np.abs(board.readings - shown).max(axis=1))
        interval += step + 1 == ends[interval]
    return ErrorCourse(
        (ends * model.sample_time).tolist(), {name: worst[:, number].tolist() for number, name in enumerate(names)}
    )


def _drawn(random: np.random.Generator, channels: tuple[Channel, ...], lanes: int) -> IntArray:
    """Values of every channel, shape (channels, lanes), in thousandths."""
    return np.array([random.integers(channel.low, channel.high + 1, lanes) for channel in channels], dtype=np.int64)
