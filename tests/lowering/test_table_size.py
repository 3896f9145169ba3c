"""How small the table of the MY1016 can be (``pytest -s`` prints the figures that docs/proof.md gives)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gen.arrays import IntArray
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.lower import with_rows
from gen.lowering.lower import lower
from gen.lowering.recursion.dynamics import dynamics
from tests.examples import example

FLASH_GOAL = 10_240
LIMIT_K = 1e-5


def _bits_needed(column: IntArray, bound_K: Callable[[IntArray], float]) -> int:
    """Bits of the shortest whole numbers that, times a power of two, keep the component within the limit."""
    shift = 0
    while bound_K((column + (1 << shift) >> shift + 1) << shift + 1) <= LIMIT_K:
        shift += 1
    return int(np.abs(column).max()).bit_length() - shift


def _component_bits(index: int) -> tuple[list[int], list[int]]:
    """Bits of each column, every other column being as fine as it is; and of their second differences."""
    model = example("my1016").model
    lowered = lower(example("my1016"), "fixed", "table").components[index]
    assert isinstance(lowered, FixedComponent)
    exact = dynamics(model, model.components[index], lowered.substeps)

    def bound_K(rates: IntArray, steady: IntArray) -> float:
        proof = with_rows(lowered, exact, rates, steady).proof
        return proof.bound_K if proof else float("inf")

    def with_rate(place: int, column: IntArray) -> float:
        rates = lowered.rates.copy()
        rates[:, place] = np.minimum(column, 2**32 - 1)
        return bound_K(rates, lowered.steady)

    columns = [*lowered.rates.T, lowered.steady]
    needed = [
        _bits_needed(column, lambda c, place=place: with_rate(place, c))  # type: ignore[misc]
        for place, column in enumerate(columns[:-1])
    ]
    needed.append(_bits_needed(columns[-1], lambda c: bound_K(lowered.rates, c)))
    curvature = [int(np.abs(np.diff(column, 2)).max()).bit_length() + 1 for column in columns]
    coarser = [max(0, int(np.abs(c).max()).bit_length() - bits) for c, bits in zip(columns, needed, strict=True)]
    return needed, [max(1, bits - less) for bits, less in zip(curvature, coarser, strict=True)]


def test_a_table_of_rows_that_stand_alone_leaves_the_code_no_room_within_the_goal_for_flash() -> None:
    rows = 256
    plain = predicted = 0
    for index in range(4):
        needed, curvature = _component_bits(index)
        print(f"\ncomponent {index}: bits of R.., S {needed}, of their second differences {curvature}", end="")
        plain += sum(needed)
        predicted += sum(curvature)
    by_itself = rows * plain / 8.0
    from_neighbours = rows / 2.0 * (plain + predicted) / 8.0
    print(
        f"\nrow by itself {plain} bits, table {by_itself:.0f} B; every other by its neighbours {from_neighbours:.0f} B"
    )
    # Packed to the last bit, each column alone at the limit: what is left has to hold the code and the unpacking.
    assert FLASH_GOAL - by_itself < 2_000
    assert from_neighbours < by_itself
