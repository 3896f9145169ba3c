"""No network is looked for that the board could not follow: what is judged is what is written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gen
from gen.arrays import FloatArray
from gen.identification.network.fitting.followed import MARGIN, UNIT, too_fast
from gen.identification.network.fitting.structure import Structure, full
from gen.runs import write_run
from tests.identification.network.plant import TWO, holds

LEAST_S = 50.0


def drawn(seed: int) -> tuple[Structure, FloatArray]:
    shape = full(("a", "b"), 1)
    vector = np.random.default_rng(seed).normal(0.0, 1.0, shape.size)
    vector[:3] = np.log([5.0, 8.0, 3.0])
    return shape, vector


@pytest.mark.parametrize("seed", range(3))
def test_slopes_are_those_of_differences(seed: int) -> None:
    shape, vector = drawn(seed)
    residual, slopes = too_fast(shape, vector, LEAST_S)
    assert residual.size
    for place in range(shape.size):
        step = np.zeros(shape.size)
        step[place] = 1e-6
        up, down = (too_fast(shape, vector + sign * step, LEAST_S)[0] for sign in (1.0, -1.0))
        assert (up - down) / 2e-6 == pytest.approx(slopes[:, place], abs=1e-5)


def test_a_rate_at_the_limit_costs_nothing() -> None:
    """Of two alike capacities C with G between them each follows with C / G, and both come together twice as fast."""
    shape = Structure(("a", "b"), 0, ((0, 1),), (), constant=frozenset({0}))
    vector = np.zeros(shape.size)
    vector[:2] = np.log(100.0)
    conductance = vector[shape.conductances[0]]
    conductance[:] = np.log(1.0)
    residual, _ = too_fast(shape, vector, 49.0)
    assert residual.size == 0
    residual, _ = too_fast(shape, vector, 60.0)
    assert residual * UNIT == pytest.approx(np.log(MARGIN * 60.0 / 50.0))
    assert too_fast(shape, vector, 0.0)[0].size == 0


def test_what_is_written_is_what_was_fitted(tmp_path: Path) -> None:
    """On a board with samples of 10 s a winding that follows its casing within 107 s is too fast: 200 s are asked."""
    rng, paths = np.random.default_rng(1), [tmp_path / f"run{k}.csv" for k in range(4)]
    for path in paths:
        speeds = rng.integers(60, 255, 5)
        write_run(path, TWO.run(holds(*((int(speed), 12) for speed in speeds), (0, 20)), rng, noise=0.05))
    found = gen.identify(paths, model="network", sample_time=10.0)
    parts = found.details()["components"]
    for path in paths:
        read, shown = gen.read_run(path), gen.simulate(found.model, path)
        for name, part in parts.items():
            error = shown[f"{name}_degC"].to_numpy() - read[f"{name}_degC"].to_numpy()
            told = np.hypot(part["rms_K"][path.stem], 0.09)  # means over bins, beside the noise of single readings
            assert np.sqrt(np.mean(error**2)) == pytest.approx(told, rel=0.2)
