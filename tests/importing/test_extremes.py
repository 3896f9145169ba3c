"""Recorders that write the least and the largest value of each interval, in columns side by side."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.importing.logs import TRUE, csv, take, taken, write

HEAD = """#;GP10 data
Device;GP10;S5P123456
;;CH0001;CH0001;CH0002;CH0002;CH0003;CH0003;CH0010
Tag;;Winding;Winding;Casing;Casing;Ambient;Ambient;Duty
Unit;;°C;°C;°C;°C;°C;°C;%
Date;Time;Min;Max;Min;Max;Min;Max;Max
"""


def test_names_and_units_above_the_line_of_min_and_max(tmp_path: Path) -> None:
    rows = "".join(
        f"05/03/2024;10:{i // 60:02d}:{i % 60:02d};"
        + ";".join(f"{value + off:.1f}".replace(".", ",") for value in values for off in (-0.1, 0.0))
        + ";60,0\n"
        for i, values in enumerate(zip(TRUE.winding_degC, TRUE.casing_degC, TRUE.ambient_degC, strict=True))
    )
    path = write(tmp_path, HEAD + rows, "cp1252")
    found = take(path, tmp_path / "a", units={"Date": "dmy"})
    assert found.guesses().loc["Winding Min", "taken"] == "left out"
    run = taken(path, tmp_path / "b", units={"Date": "dmy"})
    np.testing.assert_array_equal(run.temps["winding_max"], TRUE.winding_degC)
    np.testing.assert_array_equal(run.temps["casing_max"], TRUE.casing_degC)
    np.testing.assert_array_equal(run.ambient, TRUE.ambient_degC)
    assert set(run.temps) == {"winding_max", "casing_max"}
    assert set(run.pwm.tolist()) == {153}
    assert "winding_least" in taken(path, tmp_path / "c", columns={"Winding Min": "winding_least"}, time="1").temps


def test_what_lies_far_apart_or_the_other_way_round_is_no_pair(tmp_path: Path) -> None:
    wide = TRUE.rename(columns={"winding_degC": "coil max [degC]", "casing_degC": "case max [degC]"}).assign(
        **{"coil min [degC]": TRUE.winding_degC - 9, "case min [degC]": TRUE.casing_degC + 1}
    )
    assert set(taken(write(tmp_path, csv(wide)), tmp_path / "out").temps) == {
        "coil_max",
        "case_max",
        "coil_min",
        "case_min",
    }
