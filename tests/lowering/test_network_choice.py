"""Which form of a network is taken: the cheapest that is good enough, found with few proofs."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.lowering.network import choose
from gen.lowering.network.choose import _cheapest, _Trial
from gen.lowering.network.terms import Terms


def trial(cost: float, defect: float) -> _Trial:
    return _Trial([1], (), (), np.array([[defect]]), cost)


def chosen(trials: list[_Trial], bounds: dict[float, float], monkeypatch: pytest.MonkeyPatch) -> tuple[_Trial, int]:
    """What is taken where 1 K is good enough and the best form, of a defect of 1, has a bound of 0.5 K; and proofs."""
    proofs = []

    def bound(_: Terms, defect: FloatArray) -> FloatArray:
        proofs.append(float(defect.max()))
        return np.array([bounds[proofs[-1]]])

    monkeypatch.setattr(choose, "_bound", bound)
    found, _ = _cheapest(cast(Terms, None), trials, trials[-1], np.array([0.5]), 1.0)
    return found, len(proofs)


def test_a_cheap_form_that_may_be_good_enough_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its defect is three times that of the best, which need not make its bound three times as large."""
    cheap, best = trial(10.0, 3.0), trial(90.0, 1.0)
    assert chosen([cheap, best], {3.0: 0.9, 1.0: 0.5}, monkeypatch) == (cheap, 1)
    assert chosen([cheap, best], {3.0: 1.1, 1.0: 0.5}, monkeypatch) == (best, 2)


def test_no_more_than_four_doubtful_forms_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each takes a proof; the cheapest come first, and one that is sure to do ends the search."""
    doubtful = [trial(10.0 + place, 3.0 + place / 8.0) for place in range(6)]
    best = trial(90.0, 1.0)
    bounds = {float(each.defect.max()): 1.1 for each in doubtful} | {1.0: 0.5}
    assert chosen([*doubtful, best], bounds, monkeypatch) == (best, 5)
    bounds[float(doubtful[3].defect.max())] = 0.9
    assert chosen([*doubtful, best], bounds, monkeypatch) == (doubtful[3], 4)


def test_a_form_that_is_far_from_good_enough_costs_no_proof(monkeypatch: pytest.MonkeyPatch) -> None:
    best = trial(90.0, 1.0)
    assert chosen([trial(10.0, 4.5), best], {1.0: 0.5}, monkeypatch) == (best, 1)
