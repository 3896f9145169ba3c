"""Frames as `DataFrame.to_json` writes them, by columns; and arrays that end early."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, same, taken, write

LATER = TRUE.assign(time_s=10.0 * np.arange(len(TRUE)))
STAMPS = pd.DatetimeIndex(pd.Timestamp("2026-03-02 08:15:00") + pd.to_timedelta(LATER.time_s, unit="s"))
FRAMES = {
    "numbers of rows": LATER,
    "the time": LATER.set_index("time_s"),
    "rows left out": LATER[LATER.index % 7 != 3],
    "timestamps": LATER.drop(columns="time_s").set_index(STAMPS),
}


@pytest.mark.filterwarnings("ignore:.*date format is deprecated")
@pytest.mark.parametrize("dates", ["epoch", "iso"])
@pytest.mark.parametrize("index", FRAMES)
def test_a_frame_by_columns(index: str, dates: str, tmp_path: Path) -> None:
    text = FRAMES[index].to_json(date_format=dates)  # type: ignore[call-overload]
    run = taken(write(tmp_path, text, name="log.json"), tmp_path / "out")
    expected = FRAMES[index].reset_index(drop=True) if "time_s" in FRAMES[index] else LATER
    same(run, expected)


def test_numbered_channels_below_keys_are_no_columns(tmp_path: Path) -> None:
    """As Firebase has arrays."""
    tree = {
        f"-N{k:06}": {"0": row.time_s, "1": row.pwm, "2": row.winding_degC, "3": row.casing_degC, "4": 1.0}
        for k, row in enumerate(TRUE.itertuples())
    }
    named = {"1": "pwm", "2": "winding_degC"}
    run = taken(write(tmp_path, json.dumps(tree), name="log.json"), tmp_path / "out", time="0", columns=named)
    np.testing.assert_allclose(run.temps["winding"], TRUE.winding_degC)


def test_times_beside_the_object_that_holds_the_other_arrays(tmp_path: Path) -> None:
    """As a coffee machine's site has them; an array of another length says nothing of the rows."""
    data = {name: TRUE[name].tolist() for name in TRUE if name != "time_s"}
    tree = {"id": "a", "timeframe": [f"{t:.3f}" for t in TRUE.time_s], "tags": ["x", "y"], "data": data}
    same(taken(write(tmp_path, json.dumps(tree), name="log.json"), tmp_path / "out"), TRUE)


def test_an_array_in_one_line_that_ends_early_is_told_so(tmp_path: Path) -> None:
    text = json.dumps(TRUE.to_dict("records"))
    cut = text[: text.index('"time_s": 30.0') + 20]
    with pytest.raises(InputError, match=r"line 1, column \d+: begins as JSON .* does the file end early\?"):
        taken(write(tmp_path, cut, name="log.json"), tmp_path / "out")
    mended = cut[: cut.rindex("}") + 1] + "]"
    same(taken(write(tmp_path, mended, name="mended.json"), tmp_path / "out"), TRUE[:60])
