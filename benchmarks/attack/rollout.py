"""Beam search on the board's own words: whose rounding and rest, along the costate, push the furthest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.attack.board import Array, Board, Copy, Integers
from benchmarks.attack.exact import ExactComponent


@dataclass(frozen=True)
class Guide:
    """What G searches are guided by.

    Attributes
    ----------
    costates
        At each block's end, shape (blocks + 1, G, 2 n + 1); in between they are interpolated.
    candidates
        Rows to choose from, shape (blocks, G, C).
    block
        Samples in a block.
    beam
        How many runs each search goes on with after every sample.
    """

    costates: Array
    candidates: Integers
    block: int
    beam: int = 1


@dataclass(frozen=True)
class Track:
    """One run.

    Attributes
    ----------
    start_mK
        Its start.
    rows
        The domain's row of each sample.
    words
        x1 as given out, before the first sample and after each.
    """

    start_mK: int
    rows: list[int]
    words: list[int]


class _History:
    """What was chosen at each sample, and from which run it came."""

    def __init__(self, start_mK: Sequence[int], beam: int, samples: int) -> None:
        lanes = len(start_mK) * beam
        self._start_mK, self._beam = list(start_mK), beam
        self._rows = np.zeros((samples, lanes), dtype=np.int16)
        self._parents = np.zeros((samples, lanes), dtype=np.int32)
        self._words: NDArray[np.int64] = np.zeros((samples + 1, lanes), dtype=np.int64)
        self._furthest, self._at = -1.0, (0, 0)

    def started(self, words: Integers, distance: Array) -> None:
        """Note the words before the first sample."""
        self._words[0] = words
        self._note(0, distance)

    def sampled(self, sample: int, parents: Integers, rows: Integers, words: Integers, distance: Array) -> None:
        """Note what a sample came to."""
        self._parents[sample], self._rows[sample], self._words[sample + 1] = parents, rows, words
        self._note(sample + 1, distance)

    def best(self) -> Track:
        """The run with the largest error of all, up to there."""
        samples, lane = self._at
        rows, words = [], [int(self._words[samples, lane])]
        for k in reversed(range(samples)):
            rows.append(int(self._rows[k, lane]))
            lane = int(self._parents[k, lane])
            words.append(int(self._words[k, lane]))
        return Track(self._start_mK[lane // self._beam], rows[::-1], words[::-1])

    def _note(self, samples: int, distance: Array) -> None:
        lane = int(distance.argmax())
        if distance[lane] > self._furthest:
            self._furthest, self._at = float(distance[lane]), (samples, lane)


def search(board: Board, exact: ExactComponent, copy: Copy, start_mK: Sequence[int], guide: Guide) -> Track:
    """Follow all guides to their end, from a start each; the run with the largest error."""
    n, width = exact.order, guide.beam
    blocks, guides, count = guide.candidates.shape
    lanes = guides * width
    history = _History(start_mK, width, blocks * guide.block)
    starts = np.repeat(np.array(start_mK), width)
    state = [np.repeat(word, width) for word in board.start(list(start_mK))]
    z = np.zeros((lanes, n))
    z[:, 0] = starts / 1000.0
    level = z.mean(axis=0)  # values are compared, so what all have in common may go
    history.started(board.word(state), np.abs(board.rise(state) - z[:, 0]))
    before: Integers | None = None
    first = np.arange(guides)[:, None] * (width * count)
    for k in range(blocks * guide.block):
        block, within = divmod(k, guide.block)
        share = (within + 1) / guide.block
        costate = (1.0 - share) * guide.costates[block] + share * guide.costates[block + 1]
        row = np.repeat(guide.candidates[block][:, None, :], width, axis=1).ravel()
        tried = board.sample(
            [np.repeat(word, count) for word in state], row, None if before is None else np.repeat(before, count)
        )
        true = np.repeat(z, count, axis=0)
        away = true.copy()
        away[:, 0] -= copy.steady[row]
        true += (exact.growth[row] @ away[:, :, None])[:, :, 0]
        error = copy.true(board.values(tried), row) - true
        value = _along(costate[:, :n], true - level, guides) + _along(costate[:, n:-1], error, guides)
        if k == 0 and width > 1:  # all runs of a search are one
            value[:, count:] = -np.inf
        kept = value.argmax(axis=1)[:, None] if width == 1 else np.argpartition(-value, width - 1, axis=1)[:, :width]
        place = (first + kept).ravel()
        state = [word[place] for word in tried]
        z, before = true[place], row[place]
        history.sampled(k, place // count, before, board.word(state), np.abs(board.rise(state) - z[:, 0]))
    return history.best()


def _along(costate: Array, values: Array, guides: int) -> Array:
    """Costate times values, shape (G, values of each)."""
    product: Array = (values.reshape(guides, -1, costate.shape[1]) @ costate[:, :, None])[:, :, 0]
    return product
