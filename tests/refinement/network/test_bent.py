"""What a file is held against: by how much the runs that it stands for bend it, and by which runs noise is judged."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gen.identification.network.fitting.bins import binned
from gen.identification.network.fitting.inputs import inputs_of
from gen.refinement.network.fitting.data import Data
from gen.refinement.network.fitting.fit import Bench, Fitted, _masked
from gen.runs import Run

LATER = np.array([True, False, False])


def test_how_far_a_file_is_bent_is_what_its_own_runs_and_numbers_are_off_by() -> None:
    """Squares weighed by what each reading tells, of the earlier runs alone; the numbers' by their prior."""
    weight, residual = np.array([[9.0], [4.0], [0.5]]), np.array([[7.0], [0.5], [2.0]])
    problem = SimpleNamespace(inputs=SimpleNamespace(weight=weight), penalty=lambda vector: 3.0 * vector)
    fitted: Any = SimpleNamespace(
        problem=problem, vector=2.0, fit=SimpleNamespace(evaluated=SimpleNamespace(residual=residual))
    )
    bench = SimpleNamespace(data=SimpleNamespace(is_later=LATER))
    found = Bench.bent(cast(Bench, bench), cast(Fitted, fitted))
    assert found == pytest.approx(4.0 * 0.5**2 + 0.5 * 2.0**2 + 3.0 * 2.0)


def test_only_later_runs_say_how_dense_their_errors_are() -> None:
    time = np.arange(0.0, 300.0)
    run = Run(time, np.full(time.size, 100), {"part": 30.0 + 0.0 * time})
    inputs = inputs_of([binned(name, run, ("part",), 25.0, 255) for name in ("later", "earlier")])
    is_later = np.arange(inputs.covered.shape[0]) < inputs.covered.shape[0] // 2
    made = _masked(inputs, cast(Data, SimpleNamespace(is_later=is_later)))
    assert np.array_equal(made.covered[is_later], inputs.covered[is_later])
    assert np.all(inputs.covered[~is_later] > 0.0)
    assert np.all(made.covered[~is_later] == 0.0)
