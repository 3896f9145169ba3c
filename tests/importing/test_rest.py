"""Inputs that are not 0 at rest: 4 to 20 mA, a servo's pulses, a stick."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from gen.runs import read_run
from gen.runs.drive import drive_of
from tests.importing.logs import csv, take, truth, write


@pytest.mark.parametrize(
    ("head", "low", "high", "rest", "full"),
    [("Valve (mA)", 4.0, 20.0, 4, 20), ("Control [V]", 1.0, 5.0, 1, 5), ("throttle", 1000.0, 1900.0, 1000, 2000)],
)
def test_a_signal_whose_rest_is_not_0_is_told_with_what_settles_it(
    head: str, low: float, high: float, rest: float, full: float, tmp_path: Path
) -> None:
    frame = truth()
    signal = np.where(frame.pwm > 0, high, low)
    path = write(tmp_path, csv(frame.assign(pwm=signal).rename(columns={"pwm": head})))
    found = take(path, tmp_path / "out", input=head, full_scale=full)
    (warning,) = found.warnings
    assert f"if so: --rest {rest} --full-scale {full}" in warning
    assert take(path, tmp_path / "whole", input=head, full_scale=2.0 * full).warnings == []
    found = take(path, tmp_path / "said", input=head, rest=rest, full_scale=full)
    assert found.warnings == []
    run = read_run(found.runs[0])
    reached = round(255 * (high - rest) / (full - rest))
    np.testing.assert_array_equal(run.pwm, np.where(frame.pwm > 0, reached, 0))
    said = drive_of(run.comments)
    assert said is not None
    assert (said.quantity, said.full_scale, said.rest) == (head, full, rest)


def test_a_signal_about_its_rest_is_at_rest_and_below_it_backwards(tmp_path: Path) -> None:
    """Pulses of 1000 to 2000 us, at rest in the middle; what a transmitter jitters by is counted, and no speed."""
    frame = truth()
    pulse = np.where(frame.pwm > 0, 1750.0, 1503.0)
    pulse[:7] = 1250.0
    path = write(tmp_path, csv(frame.assign(pwm=pulse)))
    found = take(path, tmp_path / "out", input="pwm", rest=1500.0, full_scale=2000.0)
    pwm = read_run(found.runs[0]).pwm
    assert set(pwm[:7]) == {-128}
    assert set(pwm[7:]) == {0, 128}
    counted = found.counted()["count"]
    assert counted["within 2% of the rest, taken as at rest"] == (pulse == 1503.0).sum()
    assert counted["below the rest, taken as backwards"] == 7


def test_a_rest_is_kept_in_the_mapping_and_not_said_twice(tmp_path: Path) -> None:
    frame = truth()
    path = write(tmp_path, csv(frame.assign(pwm=np.where(frame.pwm > 0, 12.0, 4.0)).rename(columns={"pwm": "mA"})))
    mapping = tmp_path / "map.toml"
    first = take(path, tmp_path / "out", input="mA", rest=4.0, full_scale=20.0, mapping=mapping)
    again = take(path, tmp_path / "again", mapping=mapping)
    np.testing.assert_array_equal(read_run(again.runs[0]).pwm, read_run(first.runs[0]).pwm)
    assert "4 to 20 of its own unit = 0 to 255" in set(again.guesses()["taken"].str.removeprefix("pwm: "))
    with pytest.raises(InputError, match="the mapping file exists") as caught:
        take(path, tmp_path / "third", rest=4.0, mapping=mapping)
    assert caught.value.place == "--rest"


@pytest.mark.parametrize(
    ("rest", "message"),
    [
        (20.0, "found 20, expected less than the full scale of 20"),
        (8.0, "found 24 of its own unit, more than its full scale of 20"),
    ],
)
def test_a_rest_that_does_not_fit_is_refused(rest: float, message: str, tmp_path: Path) -> None:
    frame = truth()
    values = np.where(frame.pwm > 0, 12.0, -8.0)
    path = write(tmp_path, csv(frame.assign(pwm=values).rename(columns={"pwm": "mA"})))
    with pytest.raises(InputError, match=message):
        take(path, tmp_path / "out", input="mA", rest=rest, full_scale=20.0)


def test_a_rest_in_another_unit_than_its_column_is_refused(tmp_path: Path) -> None:
    """Pulses in ms with a rest in us: all of it would be backwards."""
    frame = truth()
    path = write(tmp_path, csv(frame.assign(pwm=np.where(frame.pwm > 0, 1.8, 1.0)).rename(columns={"pwm": "Pulse"})))
    with pytest.raises(InputError, match="never goes beyond the rest of 1000"):
        take(path, tmp_path / "out", input="Pulse", rest=1000.0, full_scale=2000.0)


def test_an_input_that_rests_where_it_begins_and_ends_is_told(tmp_path: Path) -> None:
    frame = truth()
    stick = np.where(frame.pwm > 0, 900, 512)
    stick[:20] = 512
    found = take(write(tmp_path, csv(frame.assign(pwm=stick))), tmp_path / "out", input="pwm", full_scale=1023.0)
    (said,) = found.warnings
    assert "begins and ends at 512 and is never near 0" in said
    assert "if so: --rest 512 --full-scale 1023" in said
    assert take(write(tmp_path, csv(frame)), tmp_path / "rests").warnings == []


def test_pulses_of_a_speed_controller_under_the_name_of_a_pwm_are_asked_for(tmp_path: Path) -> None:
    frame = truth()
    path = write(tmp_path, csv(frame.assign(pwm=np.where(frame.pwm > 0, 1800, 1000))))
    with pytest.raises(InputError, match=r"--rest 1000 \(or 1500\) --full-scale 2000 of pulses in us"):
        take(path, tmp_path / "out")
