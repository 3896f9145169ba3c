"""The noise beside which a hidden node or a path counts."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from gen.identification.network.fitting.bins import Binned
from gen.identification.network.hidden_nodes import noise_of


@pytest.mark.parametrize(
    ("each_K", "together_K"), [((0.02,), 0.02), ((0.03, 0.03, 0.03), 0.03), ((0.1, 0.7), 0.5), ((0.0, 0.0), 0.0)]
)
def test_the_noise_of_runs_together_lies_between_theirs_and_the_louder_counts_more(
    each_K: tuple[float, ...], together_K: float
) -> None:
    runs = [cast(Binned, SimpleNamespace(noise_K=noise)) for noise in each_K]
    assert noise_of(runs) == pytest.approx(together_K)
