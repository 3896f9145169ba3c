"""Tasks for tests; a worker imports them by their module's name."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np

from gen.errors import CheckFailed
from gen.fleet.folder.store import Store
from gen.fleet.tasks.work import Arrays


def random_sums(store: Store, *, seed: int, marks: str = "") -> Arrays:
    """Arithmetic whose last bits would show any difference; leaves a mark each time."""
    if marks:
        (Path(marks) / f"{seed}-{os.getpid()}-{time.monotonic_ns()}").touch()
    matrix = np.random.default_rng(seed).normal(size=(60, 60))
    return {"solved": np.linalg.solve(matrix @ matrix.T + np.eye(60), matrix), "text": np.array(f"seed {seed}")}


def refused(store: Store, *, seed: int) -> Arrays:
    """Every second one complains."""
    if seed % 2:
        raise CheckFailed(f"seed {seed} is odd")
    return {"seed": np.array(seed)}


def dies_once(store: Store, *, seed: int, marks: str) -> Arrays:
    """The first worker that takes seed 2 dies of it, as by the kernel's hand."""
    mark = Path(marks) / "died"
    if seed == 2 and not mark.exists():
        mark.touch()
        os._exit(9)
    return random_sums(store, seed=seed)


def hangs(store: Store, *, seed: int, marks: str, always: bool = False) -> Arrays:
    """The first worker that takes seed 2, or each, never comes back from it."""
    mark = Path(marks) / "hung"
    if seed == 2 and (always or not mark.exists()):
        mark.write_text(str(os.getpid()))
        while True:
            time.sleep(60.0)
    return random_sums(store, seed=seed)
