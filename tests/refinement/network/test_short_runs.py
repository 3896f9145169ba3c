"""A motor of minutes, whose throttle always moves: what is said of it is what its file gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gen
from gen.refinement.network.fitting import data as of_data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.prepared import prepared
from gen.runs import Run, write_run
from tests.identification.network.plant import Plant

SMALL = Plant(
    capacity=(12.0, 30.0),
    links=((0, 1, 0.5),),
    surfaces=((1, 0.1, 0.5),),
    heats=((0, 0.5, 40.0),),
    sensed={"winding": 0, "bell": 1},
)
"""An outrunner: what heats it goes with the square of a throttle that is held for twelve seconds."""
MINUTES, HELD_ROWS = 12, 3


def flight(seed: int) -> Run:
    rng = np.random.default_rng(seed)
    rows = MINUTES * 60 // 4
    pwm = np.repeat(rng.integers(40, 230, rows // HELD_ROWS), HELD_ROWS)
    pwm[2 * rows // 3 :] = 0
    return SMALL.run(pwm.astype(np.int64), rng, noise=0.05)


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("flights")
    made = [folder / f"flight{number}.csv" for number in range(6)]
    for number, path in enumerate(made):
        write_run(path, flight(number))
    return made


@pytest.fixture(scope="module")
def model(paths: list[Path]) -> gen.Model:
    return gen.identify(paths[:4], model="network").model


def as_it_is_K(model: gen.Model, path: Path) -> float:
    """The file's error on a run as refinement computes it, mean square over its bins."""
    _, data, shape, _ = prepared(model.coefficients, [path], lambda _: None)
    error = Bench(data).as_it_is(shape)
    cover = np.where(np.isfinite(error), data.inputs.covered, 0.0)
    return float(np.sqrt(np.sum(cover * np.nan_to_num(error) ** 2) / cover.sum()))


def simulated_K(model: gen.Model, path: Path) -> float:
    read, shown = gen.read_run(path), gen.simulate(model, path)
    away = [shown[f"{name}_degC"] - read[f"{name}_degC"] for name in ("winding", "bell")]
    return float(np.sqrt(np.mean(np.concatenate(away) ** 2)))


def test_refinement_errs_where_the_file_does(
    model: gen.Model, paths: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert simulated_K(model, paths[4]) < 0.2
    assert as_it_is_K(model, paths[4]) < 1.5 * simulated_K(model, paths[4])
    monkeypatch.setattr(of_data, "FINEST_S", of_data.BIN_S)
    assert as_it_is_K(model, paths[4]) > 2.0 * simulated_K(model, paths[4]), "in bins of two minutes"


def test_nothing_is_missing_of_an_unchanged_motor(model: gen.Model, paths: list[Path]) -> None:
    found = gen.refine(model, fit=paths[4:5], test=paths[5:])
    assert found.verdict == "nothing missing"
    assert found.effects().empty
