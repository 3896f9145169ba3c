"""Derivatives by parameters that act in several places, against their definition term by term."""

from __future__ import annotations

import numpy as np
import pytest

from gen.identification.network.fitting.partial import Partial


@pytest.mark.parametrize(
    ("of", "by"),
    [([0, 2, 1], [3, 4, 5]), ([0, 1, 2], [3, 3, 1]), ([1], [0]), ([], [])],
    ids=["one after the other", "one in several places", "one", "none"],
)
@pytest.mark.parametrize("level", [None, [0, 1, 1, 0, 1]])
def test_each_parameter_does_what_its_places_do(of: list[int], by: list[int], level: list[int] | None) -> None:
    rng = np.random.default_rng(7)
    levels = np.arange(5) if level is None else np.array(level)
    value = rng.normal(size=(levels.max() + 1, len(of)))
    made, unit = rng.normal(size=(5, 2, 6)), rng.normal(size=(5, 2, 3))
    expected = made.copy()
    for k, (place, parameter) in enumerate(zip(of, by, strict=True)):
        for row, held in enumerate(levels.tolist()):
            expected[row, :, parameter] += value[held, k] * unit[row, :, place]
    partial = Partial(np.array(of, dtype=np.int64), np.array(by, dtype=np.int64), value)
    partial.add_to(made, unit, None if level is None else levels)
    np.testing.assert_allclose(made, expected, rtol=1e-12)
