"""A logger whose unit is changed while it runs, which no column says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, csv, taken, truth, write

TEMPS = ["winding_degC", "casing_degC", "ambient_degC"]
NAMES = {"winding_degC": "Winding", "casing_degC": "Casing", "ambient_degC": "Ambient"}


def logged(frame: pd.DataFrame, at: int, temps: list[str], to: str) -> str:
    """A log whose readings are in the other unit from a row on."""
    made = frame.copy()
    rows = made.index >= at if to == "F" else made.index < at
    made.loc[rows, temps] = np.round(made.loc[rows, temps] * 1.8 + 32.0, 1)
    return csv(made.rename(columns=NAMES))


@pytest.mark.parametrize("to", ["F", "C"])
@pytest.mark.parametrize("temps", [TEMPS, TEMPS[:1]], ids=["all", "one alone"])
def test_a_unit_that_changes_in_all_columns_is_refused_with_its_row(temps: list[str], to: str, tmp_path: Path) -> None:
    frame, names = TRUE[["time_s", "pwm", *temps]], [NAMES[name] for name in temps]
    with pytest.raises(InputError, match=rf"all temperatures go on as what they were before in deg{to}") as caught:
        taken(write(tmp_path, logged(frame, 40, temps, to)), tmp_path / "out", units=dict.fromkeys(names, "degC"))
    assert caught.value.place == "line 42"


def test_what_a_single_column_does_or_a_gap_hides_is_no_other_unit(tmp_path: Path) -> None:
    alone = write(tmp_path, logged(TRUE, 40, ["casing_degC"], "F"), name="alone.csv")
    assert len(taken(alone, tmp_path / "alone").temps) == 2
    frame = truth().assign(casing_degC=22.0, winding_degC=22.0, ambient_degC=21.0)
    frame.loc[40:, TEMPS[:2]] = 71.6
    frame.loc[40:, "ambient_degC"] = 70.0
    frame.loc[40:, "time_s"] += 3600.0
    assert len(taken(write(tmp_path, csv(frame.rename(columns=NAMES)), name="gap.csv"), tmp_path / "gap").temps) == 2
