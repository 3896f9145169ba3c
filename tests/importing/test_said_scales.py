"""Scales and units that a name says in words of its own, or that are none of a temperature or a time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, csv, take, taken, write


@pytest.mark.parametrize("name", ["PWM 10bit", "PWM [0-1023]", "PWM/1023", "pwm_10_bit", "PWM (0..1023)"])
def test_the_full_scale_is_what_a_name_says_though_no_row_reaches_it(name: str, tmp_path: Path) -> None:
    run = taken(write(tmp_path, csv(TRUE.rename(columns={"pwm": name}))), tmp_path / "out")
    np.testing.assert_array_equal(run.pwm, np.round(TRUE.pwm * 255 / 1023))


def test_an_input_that_is_inverted_by_its_name_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match="is inverted by its name; expected the input: put 255 - x in its place, under"
    ):
        take(write(tmp_path, csv(TRUE.rename(columns={"pwm": "PWM (inverted)"}))), tmp_path / "out")


def test_fractions_of_a_pwm_may_be_percent_or_means_of_counts(tmp_path: Path) -> None:
    log = write(tmp_path, csv(TRUE.assign(pwm=TRUE.pwm / 5)))
    with pytest.raises(InputError, match=r"fractions up to 40\.8 may be percent or means of counts"):
        take(log, tmp_path / "out")
    np.testing.assert_array_equal(
        taken(log, tmp_path / "said", units={"pwm": "percent"}).pwm, np.round(TRUE.pwm * 0.51)
    )


@pytest.mark.parametrize("unit", ["(dBA)", "[µm]", "(%RH)", "[ADC]", "[mT]", "[kN]", "[-]", "[a.u.]"])
def test_what_a_part_has_in_another_unit_is_no_temperature(unit: str, tmp_path: Path) -> None:
    log = write(tmp_path, csv(TRUE.rename(columns={"casing_degC": f"Casing {unit}"})))
    assert set(taken(log, tmp_path / "out").temps) == {"winding"}


@pytest.mark.parametrize("unit", ["(°)", "[°Ré]", "[degrees]"])
def test_degrees_of_what_are_asked_for(unit: str, tmp_path: Path) -> None:
    log = write(tmp_path, csv(TRUE.rename(columns={"casing_degC": f"Casing {unit}"})))
    with pytest.raises(InputError, match="of an angle or of a temperature; settle it by --unit"):
        take(log, tmp_path / "out")


@pytest.mark.parametrize("name", ["Time [x10ms]", "Time (x10 ms)", "Time [ms*10]", "t_10ms", "Time [cs]"])
def test_a_time_in_several_of_a_unit(name: str, tmp_path: Path) -> None:
    log = write(tmp_path, csv(TRUE.assign(time_s=TRUE.time_s * 100).rename(columns={"time_s": name})))
    np.testing.assert_allclose(taken(log, tmp_path / "out").time_s, TRUE.time_s)


@pytest.mark.parametrize("name", ["Time (samples)", "Time [ticks]", "t [scans]"])
def test_a_time_in_no_unit_of_time_is_asked_for(name: str, tmp_path: Path) -> None:
    log = write(tmp_path, csv(TRUE.assign(time_s=TRUE.index).rename(columns={"time_s": name})))
    with pytest.raises(InputError, match="how long is one"):
        take(log, tmp_path / "out")
    run = taken(log, tmp_path / "said", units={name: "0.5s"})
    np.testing.assert_allclose(run.time_s, TRUE.time_s)
