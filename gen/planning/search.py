"""The search for the run that tells most: beginnings by rule and by chance, then exchange of stretches.

A run is a row of blocks of one length, each at one of a few PWM levels. Stretches as long as the network's time
constants are set to each level in turn, wherever they may begin, and what tells most is kept (coordinate exchange,
Meyer and Nachtsheim, Technometrics 37, 1995), until nothing tells more. What is exchanged is judged by derivatives;
of the best few, whole fits decide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.identification.network.fitting.inputs import Levels
from gen.identification.network.fitting.simulation import steps_of
from gen.planning.expected import Expected
from gen.planning.hypotheses import Hypothesis
from gen.planning.limits import Limits, nothing_is_cold_enough

SHORTEST_BLOCK_S, MOST_BLOCKS, FEWEST_BLOCKS = 300.0, 24, 6
BINS = 3
"""Bins in a block."""
BY_CHANCE, IMPROVED, SWEEPS = 32, 2, 3
"""Beginnings by chance, how many of the best beginnings are improved, and how often at most."""
TOGETHER = 40
"""Runs that are simulated at once."""
BETTER = 1e-3
"""Least gain in what is maximised with which an exchange counts, as a share."""


@dataclass(frozen=True, eq=False)
class Grid:
    """The blocks of a run.

    Attributes
    ----------
    blocks
        How many.
    block_s
        Length of each, s.
    stretches
        Lengths that are exchanged, in blocks.
    """

    blocks: int
    block_s: float
    stretches: tuple[int, ...]

    @property
    def bin_s(self) -> float:
        """Width of a bin, s."""
        return self.block_s / BINS


def grid_of(times: FloatArray, seconds: float) -> Grid:
    """Cut a run into blocks.

    Parameters
    ----------
    times
        The network's time constants, s.
    seconds
        Of the run.
    """
    fast = float(np.clip(times.min(), max(SHORTEST_BLOCK_S, seconds / MOST_BLOCKS), seconds / FEWEST_BLOCKS))
    blocks = max(1, round(seconds / fast))
    block = seconds / blocks
    longest = max(1, blocks // 2)
    wanted = [1, *(round(float(t) * part / block) for t in times for part in (1.0, 2.0)), longest]
    lengths = sorted({min(max(length, 1), longest) for length in wanted})
    return Grid(blocks, block, tuple(_few(lengths)))


def _few(lengths: Sequence[int]) -> list[int]:
    """Lengths of which none is nearer to another than by half."""
    kept: list[int] = []
    for length in lengths:
        if not kept or length >= 1.5 * kept[-1]:
            kept.append(length)
    return kept


def time_constants(hypothesis: Hypothesis, levels: Levels) -> FloatArray:
    """Give a network's time constants at an input, shape (n,), s, from the slowest on."""
    steps = steps_of(hypothesis.shape, levels, hypothesis.shape.physical(levels, hypothesis.shared))
    return np.asarray(np.sort(-1.0 / steps.rates[0])[::-1])


@dataclass(frozen=True, eq=False)
class Sought:
    """What was found.

    Attributes
    ----------
    best
        The level's number in each block of the best run, shape (B,).
    plain
        The same of the best run that holds one level or climbs in steps.
    """

    best: IntArray
    plain: IntArray


class Search:
    """The search.

    Parameters
    ----------
    expected
        What runs would tell.
    limits
        What they may be.
    grid
        Their blocks.
    seed
        Of chance.
    """

    def __init__(self, expected: Expected, limits: Limits, grid: Grid, seed: int) -> None:
        self._expected, self._limits, self._grid = expected, limits, grid
        self._chance = np.random.default_rng([20281, seed])

    def run(self) -> Sought:
        """Search.

        Raises
        ------
        InputError
            If no run keeps to the limits.
        """
        self._check_coolest()
        plain = self._plain()
        of_plain = self._worth(plain)
        first = np.concatenate([plain, self._by_chance()])
        worth = np.concatenate([of_plain, self._worth(first[len(plain) :])])
        order = [k for k in np.argsort(-worth, kind="stable")[:IMPROVED].tolist() if np.isfinite(worth[k])]
        best_plain = plain[int(np.argmax(of_plain))]
        improved = sorted((self._improved(first[k], float(worth[k])) for k in order), key=lambda one: -one[1])
        if not self._expected.pairs:
            return Sought(improved[0][0], best_plain)
        few = [*(run for run, _ in improved), best_plain]
        best = max(few, key=lambda run: self._expected.whole(np.repeat(run, BINS)).worth)
        return Sought(best, best_plain)

    def _check_coolest(self) -> None:
        levels = self._limits.levels
        coolest = min(range(len(levels)), key=lambda k: abs(levels[k]))
        run = np.full((1, self._grid.blocks), coolest, dtype=np.int64)
        hottest = self._expected.hottest(self._bins(run))
        if not self._limits.kept(hottest)[0]:
            names = self._expected.remaining.hypotheses[0].shape.names
            raise nothing_is_cold_enough(self._limits, hottest[0], names, levels[coolest])

    def _bins(self, blocks: IntArray) -> IntArray:
        return np.repeat(blocks, BINS, axis=1)

    def _worth(self, blocks: IntArray) -> FloatArray:
        """What runs are worth, shape (K,); minus infinity beyond the limits."""
        made = np.full(len(blocks), -np.inf)
        allowed = np.flatnonzero(self._allowed(blocks))
        for first in range(0, allowed.size, TOGETHER):
            part = allowed[first : first + TOGETHER]
            made[part] = self._expected.worth(self._bins(blocks[part]))
        return made

    def _allowed(self, blocks: IntArray) -> BoolArray:
        return self._limits.kept(self._expected.hottest(self._bins(blocks)))

    def _plain(self) -> IntArray:
        """Runs that hold a level, with or without rest at the end; and stairs, up and down."""
        blocks, levels = self._grid.blocks, self._limits.levels
        made = [np.full(blocks, k) for k in range(len(levels))]
        if 0 in levels:
            rest = levels.index(0)
            made += [np.where(np.arange(blocks) < blocks // 2, k, rest) for k in range(len(levels)) if k != rest]
        forwards = [k for k, level in enumerate(levels) if level > 0]
        stairs = np.array(forwards)[np.arange(blocks) * len(forwards) // blocks]
        return np.array([*made, stairs, stairs[::-1]], dtype=np.int64)

    def _by_chance(self) -> IntArray:
        """Runs of stretches of the network's time constants at levels by chance."""
        made = np.zeros((BY_CHANCE, self._grid.blocks), dtype=np.int64)
        for run in made:
            at = 0
            while at < run.size:
                length = int(self._chance.choice(self._grid.stretches))
                run[at : at + length] = self._chance.integers(len(self._limits.levels))
                at += length
        return made

    def _improved(self, blocks: IntArray, worth: float) -> tuple[IntArray, float]:
        """Exchange stretches until nothing tells more."""
        for _ in range(SWEEPS):
            before = worth
            for begin in self._chance.permutation(self._grid.blocks).tolist():
                tried = self._exchanged(blocks, begin)
                if not len(tried):
                    continue
                found = self._worth(tried)
                best = int(np.argmax(found))
                if found[best] > worth + BETTER * abs(worth):
                    blocks, worth = tried[best], float(found[best])
            if worth <= before + 10.0 * BETTER * abs(before):
                break
        return blocks, worth

    def _exchanged(self, blocks: IntArray, begin: int) -> IntArray:
        """The run with each stretch from a block on at each level."""
        made = []
        for length in self._grid.stretches:
            for level in range(len(self._limits.levels)):
                other = blocks.copy()
                other[begin : begin + length] = level
                made.append(other)
        every = np.unique(np.array(made, dtype=np.int64), axis=0)
        return np.asarray(every[np.any(every != blocks, axis=1)])
