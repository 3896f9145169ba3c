"""What is left out of one run: stretches that hold readings, whatever gap parts them."""

from __future__ import annotations

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.identification.choice.folds import STRETCHES, folds_of
from gen.identification.logs.sources import Source
from gen.runs import Run


def source(time: FloatArray) -> Source:
    return Source("run.csv", Run(time, np.full(time.size, 100), {"coil": np.linspace(20.0, 60.0, time.size)}))


@pytest.mark.parametrize("gap_s", [0.0, 3600.0, 40_000.0, 1e6])
def test_each_fold_of_one_run_leaves_out_readings_also_where_it_has_a_gap(gap_s: float) -> None:
    time = np.arange(0.0, 14_400.0, 20.0)
    time[time >= 7200.0] += gap_s
    folds = folds_of([source(time)])
    assert len(folds) == STRETCHES - 1
    for fold in folds:
        ((_, out),) = fold.judged
        assert out.sum() == pytest.approx(time.size / STRETCHES, rel=0.1)
        assert not out[0]  # the first stretch always takes part
        np.testing.assert_array_equal(np.isnan(fold.fit[0].run.temps["coil"]), out)


def test_a_run_of_two_readings_with_a_gap_has_no_fold_without_readings() -> None:
    assert all(out.any() for fold in folds_of([source(np.array([0.0, 1e6]))]) for _, out in fold.judged)
