"""Recorders that write the largest and the least values of an interval in two rows of one time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.importing.means import means
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, write

TURNS = 2 * len(TRUE)


def by_turns(*, largest_first: bool = True) -> pd.DataFrame:
    """Each row twice: half a step of the fastest sensor above it and below it, the input and the time as they are."""
    frame = TRUE.loc[TRUE.index.repeat(2)].reset_index(drop=True)
    signs = np.where((np.arange(TURNS) % 2 == 0) == largest_first, 1.0, -1.0)
    for name, half in (("winding_degC", 0.6), ("casing_degC", 0.2), ("ambient_degC", 0.1)):
        frame[name] = np.round(frame[name] + signs * half, 3)
    frame.insert(1, "Kind", np.where(signs > 0, "Max", "Min"))
    return frame


@pytest.mark.parametrize("largest_first", [True, False])
@pytest.mark.parametrize("named", [True, False])
def test_their_mean_is_taken_and_told(largest_first: bool, named: bool, tmp_path: Path) -> None:
    frame = by_turns(largest_first=largest_first)
    path = write(tmp_path, csv(frame if named else frame.drop(columns="Kind")))
    mapping = tmp_path / "map.toml"
    found = take(path, tmp_path / "runs", mapping=mapping)
    same(read_run(found.runs[0]), TRUE)
    guess = found.guesses().loc["rows of one time"]
    assert guess["taken"] == "their mean"
    assert ("by the column Kind" in guess["why"]) == named
    assert found.counted().loc["repeated time, the mean of its rows taken", "count"] == len(TRUE)
    again = take(path, tmp_path / "again", mapping=mapping)
    assert again.runs[0].read_bytes() == found.runs[0].read_bytes()


def test_one_of_them_may_be_asked_for(tmp_path: Path) -> None:
    path = write(tmp_path, csv(by_turns()))
    run = taken(path, tmp_path / "runs", duplicates="last")
    np.testing.assert_allclose(run.temps["winding"], TRUE.winding_degC - 0.6, atol=1e-9)


def test_pieces_of_a_log_keep_their_rows(tmp_path: Path) -> None:
    frame = by_turns()
    frame["time_s"] += np.where(np.arange(TURNS) >= 140, 500.0, 0.0)
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs", split=True)
    same(read_run(found.runs[0]), TRUE[:70])
    same(read_run(found.runs[1]), TRUE[70:].assign(time_s=TRUE.time_s[70:] + 500.0))


def test_samples_of_a_clock_that_is_too_coarse_are_no_such_rows(tmp_path: Path) -> None:
    """They rise within a second and between seconds; or fall in both."""
    time = np.floor(TRUE.time_s).astype(int)
    for k, rate in enumerate((0.1, -0.1)):
        frame = TRUE.assign(time_s=time, winding_degC=np.round(40 + rate * np.arange(len(TRUE)), 1), casing_degC=30.0)
        path = write(tmp_path, csv(frame), name=f"{k}.csv")
        with pytest.raises(InputError, match=r"60 of 120 rows repeat the time .* --duplicates spread"):
            take(path, tmp_path / "runs")
        run = taken(path, tmp_path / f"mean{k}", duplicates="mean")
        np.testing.assert_allclose(run.temps["winding"], 40 + rate * (2 * np.arange(60) + 0.5), atol=1e-9)


def test_noise_of_a_clock_that_is_too_coarse_is_no_such_rows(tmp_path: Path) -> None:
    noise = np.round(np.random.default_rng(3).normal(0.0, 0.5, len(TRUE)), 2)
    frame = TRUE.assign(time_s=np.floor(TRUE.time_s).astype(int), winding_degC=40 + noise)
    with pytest.raises(InputError, match="rows repeat the time"):
        take(write(tmp_path, csv(frame)), tmp_path / "runs")


def test_of_rows_without_a_number_the_mean_is_of_the_others() -> None:
    values = np.array([1.0, 3.0, np.nan, 5.0, np.nan, np.nan, 8.0])
    found = means(values, np.array([0, 2, 4, 6]), np.array([1, 3, 5]))
    np.testing.assert_array_equal(found[[0, 2, 4, 6]], [2.0, 5.0, np.nan, 8.0])
