"""Numbers in the input's column that no drive has: sums below a log, numbers that stand for an error, glitches."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, write

SHARE = (TRUE.pwm / 340).round(2)
"""204 of 255 becomes 0.6."""
AT = 30


def with_input(values: pd.Series, name: str) -> pd.DataFrame:
    frame = TRUE.rename(columns={"pwm": name})
    return frame.assign(**{name: values})


def pwm_of(share: float) -> int:
    return int(share * 255 + 0.5)


@pytest.mark.parametrize("footer", ["Sum,43.2,9999,9999,9999", ",43.2,,,", "Mean,0.36,40.1,30.1,21.0\nTotal,240,,,"])
def test_rows_without_a_time_do_not_decide_on_the_scale(footer: str, tmp_path: Path) -> None:
    text = csv(with_input(SHARE, "duty")) + footer + "\n"
    found = take(write(tmp_path, text), tmp_path / "out")
    run = read_run(found.runs[0])
    assert set(run.pwm.tolist()) == {0, 153}
    same(run, TRUE.drop(columns="pwm"))
    assert any("row without a time" in what for what in found.counted().index)


def test_a_sum_below_does_not_change_the_full_scale_that_is_proposed_or_taken(tmp_path: Path) -> None:
    power = with_input(TRUE.pwm * 5.0, "Power [W]")
    path = write(tmp_path, csv(power) + "Total,486000,,,\n")
    with pytest.raises(InputError, match=r"--input 'Power \[W\]' --full-scale 2000"):
        take(path, tmp_path / "asked")
    run = read_run(take(path, tmp_path / "out", input="Power [W]", full_scale=1020.0).runs[0])
    assert run.pwm.max() == 255
    assert run.time_s.size == len(TRUE)


@pytest.mark.parametrize(
    ("name", "values", "error"),
    [
        ("PWM %", TRUE.pwm / 3.4, 9999),
        ("PWM %", TRUE.pwm / 3.4, -999.9),
        ("duty", SHARE, 9999),
        ("duty", SHARE, -1),
        ("PWM %", TRUE.pwm / 3.4, -1),
        ("pwm_counts", TRUE.pwm * 0.75, 65535),
    ],
)
def test_an_errors_number_is_no_input(name: str, values: pd.Series, error: float, tmp_path: Path) -> None:
    odd = values.astype(float).copy()
    odd[[AT, AT + 9]] = error
    odd[0] = error
    found = take(write(tmp_path, csv(with_input(odd, name))), tmp_path / "out")
    run = read_run(found.runs[0])
    assert set(run.pwm.tolist()) == {0, 153}
    assert run.time_s.tolist() == TRUE.time_s[1:].tolist()  # nothing is known before the first input
    said = " ".join(found.counted().index)
    assert f"{error:g} (" in said
    assert "missing input, held from the row before" in said


@pytest.mark.parametrize("values", [[0.6, 1.0, -1.0], [0.6, -0.4, -1.0]])
def test_a_drive_that_turns_back_is_no_error(values: list[float], tmp_path: Path) -> None:
    share = SHARE.copy()
    share[[AT, AT + 1, AT + 2]] = values
    run = read_run(take(write(tmp_path, csv(with_input(share, "duty"))), tmp_path / "out").runs[0])
    assert run.pwm[AT + 2] == -255


def test_counts_of_sixteen_bits_that_reach_their_end_are_no_error(tmp_path: Path) -> None:
    counts = TRUE.pwm * 60.0
    counts[AT] = 65535
    frame = with_input(counts, "pwm_counts")
    run = read_run(take(write(tmp_path, csv(frame)), tmp_path / "out", full_scale=65535.0).runs[0])
    assert run.pwm[AT] == 255


def test_one_reading_far_beyond_all_others_is_asked_for_and_left_out(tmp_path: Path) -> None:
    share = SHARE.copy()
    share[AT] = 37.5
    path = write(tmp_path, csv(with_input(share, "duty")))
    with pytest.raises(InputError, match=r"37.5 \(line 32\) is far beyond all others, 0..0.6; settle it by --unit"):
        take(path, tmp_path / "asked")
    found = take(path, tmp_path / "out", units={"duty": "duty"})
    assert set(read_run(found.runs[0]).pwm.tolist()) == {0, pwm_of(0.6)}
    assert any("37.5 (far beyond all others" in what for what in found.counted().index)
    percent = read_run(take(path, tmp_path / "percent", units={"duty": "percent"}).runs[0])
    assert percent.pwm[AT] == pwm_of(0.375)


def test_one_reading_beyond_what_the_name_says_is_left_out(tmp_path: Path) -> None:
    percent = (TRUE.pwm / 40.8).round(1)  # up to 5
    percent[AT] = 620
    found = take(write(tmp_path, csv(with_input(percent, "PWM %"))), tmp_path / "out")
    assert set(read_run(found.runs[0]).pwm.tolist()) == {0, 13}
    assert any("620 (far beyond all others" in what for what in found.counted().index)


def test_more_than_the_full_scale_that_is_not_far_beyond_is_still_refused(tmp_path: Path) -> None:
    percent = (TRUE.pwm / 3.4).round(1)
    percent[AT] = 150
    with pytest.raises(InputError, match="more than its full scale of 100"):
        take(write(tmp_path, csv(with_input(percent, "PWM %"))), tmp_path / "out", units={"PWM %": "percent"})


def test_a_mapping_keeps_them(tmp_path: Path) -> None:
    share = SHARE.copy()
    share[AT] = -1
    path, mapping = write(tmp_path, csv(with_input(share, "duty"))), tmp_path / "log.toml"
    take(path, tmp_path / "out", mapping=mapping)
    mapping.write_text(mapping.read_text().replace('overflow = "empty"', 'overflow = "keep"'))
    run = read_run(take(path, tmp_path / "kept", mapping=mapping).runs[0])
    assert run.pwm[AT] == -255
