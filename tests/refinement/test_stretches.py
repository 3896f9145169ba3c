"""Single speeds, each run once: stretches of a run are left out in turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pytest

from gen.arrays import BoolArray, IntArray
from gen.model.effects import Setting
from gen.refinement.parts import judged_on_stretches
from gen.refinement.parts.judged_on_stretches import STRETCHES, by_stretch
from gen.refinement.parts.judgement import Judgement
from gen.refinement.parts.stacked_runs import StackedRuns


@dataclass(frozen=True)
class Runs:
    """What is changed of stacked runs."""

    blocks: IntArray
    left_out: BoolArray
    tolerance_K: float


def test_each_run_is_parted_by_its_own_length(monkeypatch: pytest.MonkeyPatch) -> None:
    """One of 90 bins and one of 36, which is filled up with bins that are none."""
    bins = (90, 36)
    blocks = np.where(np.arange(90)[:, None] < np.array(bins), 0, -1)
    seen: list[Runs] = []

    def fit(runs: Any, terms: Any) -> Any:  # noqa: ANN401
        seen.append(runs)

    monkeypatch.setattr(judged_on_stretches, "fit", fit)
    monkeypatch.setattr(judged_on_stretches, "judge", lambda *_: Judgement(1.0, 1.0, 1.0, ("none",)))
    known = Setting("part0", (), {}, (60, 120), 1e-3, None, False, frozenset(), False, False)
    assert by_stretch(cast(StackedRuns, Runs(blocks, np.zeros((1, 90, 2), dtype=bool), 1.0)), known, 1) is None
    assert seen
    for cut in seen:
        for run, length in enumerate(bins):
            parts = [np.flatnonzero(mask[:length, run]) for mask in cut.left_out]
            assert [part.size for part in parts] == [length // 3] * 3
            assert np.concatenate(parts).tolist() == list(range(length))  # one third after the other
            own, counts = np.unique(cut.blocks[:length, run], return_counts=True)
            assert own.tolist() == list(range(STRETCHES * run, STRETCHES * (run + 1)))
            assert set(counts.tolist()) == {length // STRETCHES}
        assert np.all(cut.blocks[36:, 1] == -1)
