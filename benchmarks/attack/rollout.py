"""Runs on the board's own words: at each sample the PWM whose rounding and rest, along the costate, push the furthest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.attack.board import Array, Board, Copy, Integers
from benchmarks.attack.exact import ExactComponent


@dataclass(frozen=True)
class Guide:
    """What a run is guided by.

    Attributes
    ----------
    costates
        At each block's end, shape (blocks + 1, L, 2 n + 1); in between they are interpolated.
    candidates
        Rows to choose from, shape (blocks, L, C).
    block
        Samples in a block.
    """

    costates: Array
    candidates: Integers
    block: int


@dataclass(frozen=True)
class Runs:
    """What came of L runs.

    Attributes
    ----------
    start_mK
        Starts.
    rows
        The domain's row at each sample, shape (samples, L).
    words
        x1 as given out, before the first sample and after each, shape (samples + 1, L).
    reached
        Largest |x1 - T| of each run, in K and in float64, shape (L,).
    at
        After how many samples.
    """

    start_mK: list[int]
    rows: NDArray[np.int16]
    words: Integers
    reached: Array
    at: Integers

    def best(self) -> tuple[int, list[int], list[int]]:
        """Start, rows and words up to the largest error of all."""
        lane = int(self.reached.argmax())
        end = int(self.at[lane])
        return self.start_mK[lane], self.rows[:end, lane].tolist(), self.words[: end + 1, lane].tolist()


def run(board: Board, exact: ExactComponent, copy: Copy, start_mK: Sequence[int], guide: Guide) -> Runs:
    """Play all lanes to the guide's end."""
    n = exact.order
    blocks, lanes, count = guide.candidates.shape
    samples = blocks * guide.block
    every = np.arange(lanes)
    state = board.start(list(start_mK))
    z = np.zeros((lanes, n))
    z[:, 0] = np.array(start_mK) / 1000.0
    before: Integers | None = None
    rows = np.zeros((samples, lanes), dtype=np.int16)
    words = np.zeros((samples + 1, lanes), dtype=np.int64)
    words[0] = board.word(state)
    reached, at = np.abs(board.rise(state) - z[:, 0]), np.zeros(lanes, dtype=np.int64)
    for k in range(samples):
        block, within = divmod(k, guide.block)
        share = (within + 1) / guide.block
        costate = (1.0 - share) * guide.costates[block] + share * guide.costates[block + 1]
        row = guide.candidates[block].ravel()
        tried = board.sample(
            [np.repeat(word, count) for word in state], row, None if before is None else np.repeat(before, count)
        )
        true = np.repeat(z, count, axis=0)
        away = true.copy()
        away[:, 0] -= copy.steady[row]
        step = (exact.growth[row] @ away[:, :, None])[:, :, 0]
        error = copy.true(board.values(tried), row) - (true + step)
        score = _along(costate[:, :n], step, count) + _along(costate[:, n:-1], error, count)
        place = every * count + score.argmax(axis=1)
        state = [word[place] for word in tried]
        z = z + step[place]
        before = row[place]
        rows[k], words[k + 1] = before, board.word(state)
        distance = np.abs(board.rise(state) - z[:, 0])
        further = distance > reached
        reached, at = np.where(further, distance, reached), np.where(further, k + 1, at)
    return Runs(list(start_mK), rows, words, reached, at)


def _along(costate: Array, values: Array, count: int) -> Array:
    """Costate times values, shape (L, count)."""
    lanes, n = costate.shape
    product: Array = (values.reshape(lanes, count, n) @ costate[:, :, None])[:, :, 0]
    return product
