"""Many judgements in one process or several, and their JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_order(
    items: Sequence[Item], judge: Callable[[Item], Result], lost: Callable[[Item, Exception], Result], jobs: int
) -> Iterator[Result]:
    """Judge each, and give the results in their order as they come.

    Parameters
    ----------
    items
        What to judge.
    judge
        Judges one; with several processes it has to be importable, as :mod:`pickle` asks.
    lost
        What is said of one whose process died.
    jobs
        How many processes.
    """
    if jobs == 1:
        yield from map(judge, items)
        return
    with ProcessPoolExecutor(jobs) as pool:
        waiting = [(item, pool.submit(judge, item)) for item in items]
        for item, future in waiting:
            try:
                yield future.result()
            except BrokenProcessPool as error:
                yield lost(item, error)


def json_text(made: object) -> str:
    """Give the text of what was made; what is no number is null."""
    return json.dumps(_without_nan(made), indent=1, default=float) + "\n"


def _without_nan(value: object) -> object:
    if isinstance(value, dict):
        return {key: _without_nan(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_nan(entry) for entry in value]
    return None if isinstance(value, float) and math.isnan(value) else value
