"""A verdict of the fit runs says nothing where the test runs are missed by far."""

from __future__ import annotations

import pytest

from gen.refinement.errors import Errors, missed
from gen.refinement.run_errors import Score


def of(rmse_K: float) -> dict[str, dict[str, Score]]:
    return {"run.csv": {"winding": Score(100 * rmse_K**2, 100, 2 * rmse_K)}}


@pytest.mark.parametrize(
    ("fit", "test", "said"), [(1.37, 26.4, True), (1.0, 2.9, False), (0.2, 1.5, False), (0.5, 2.1, True)]
)
def test_what_is_missed_by_far_is_said(fit: float, test: float, said: bool) -> None:
    found = missed(Errors(fit=of(fit), test=of(test)))
    assert bool(found) is said
    if said:
        assert found[0].startswith(f"the test runs are missed by {test:.3g} K, the fit runs by {fit:.2g} K")


def test_without_test_runs_nothing_is() -> None:
    assert missed(Errors(fit=of(1.0))) == []
