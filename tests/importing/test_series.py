"""Logs with a row for each reading: of home automation, of databases of time series."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import take, write

ROWS = 60
TEMPERATURE = 21.0 + 0.25 * np.arange(ROWS)
POWER = np.where(np.arange(ROWS) % 20 < 10, 2000.0, 0.0)


def times(offset_ms: int = 0) -> list[str]:
    begin = np.datetime64("2024-01-05T08:00:00.000")
    return [f"{begin + np.timedelta64(30_000 * i + offset_ms, 'ms')}Z" for i in range(ROWS)]


def history(late_ms: int = 0) -> str:
    """First all of one sensor, then all of the other, which is read `late_ms` later."""
    lines = ["entity_id,state,last_changed"]
    lines += [f"sensor.boiler_temperature,{t:.2f},{at}" for t, at in zip(TEMPERATURE, times(late_ms), strict=True)]
    lines += [f"sensor.heater_power,{p:.0f},{at}" for p, at in zip(POWER, times(), strict=True)]
    lines[20] = lines[20].replace(f"{TEMPERATURE[19]:.2f}", "unavailable")
    return "\n".join(lines)


def test_each_name_becomes_a_column(tmp_path: Path) -> None:
    log = write(tmp_path, history())
    with pytest.raises(InputError, match=r"has a row for each of .*; expected --series entity_id, which gives each"):
        take(log, tmp_path / "out")
    with pytest.raises(
        InputError, match=r"expected what drives it, such as --input sensor\.heater_power --full-scale 20"
    ):
        take(log, tmp_path / "out", series="entity_id")
    mapping = tmp_path / "map.toml"
    found = take(
        log, tmp_path / "out", series="entity_id", input="sensor.heater_power", full_scale=2000.0, mapping=mapping
    )
    run = read_run(found.runs[0])
    np.testing.assert_allclose(run.time_s, 30.0 * np.arange(ROWS))
    np.testing.assert_allclose(run.pwm, POWER / 2000.0 * 255.0)
    expected = TEMPERATURE.copy()
    expected[19] = np.nan
    np.testing.assert_allclose(run.temps["sensor_boiler"], expected)
    again = take(log, tmp_path / "again", mapping=mapping)
    assert again.runs[0].read_bytes() == found.runs[0].read_bytes()


def test_sensors_that_are_read_at_other_times_share_the_rows(tmp_path: Path) -> None:
    log = write(tmp_path, history(late_ms=7000))
    found = take(log, tmp_path / "out", series="entity_id", input="sensor.heater_power", full_scale=2000.0)
    run = read_run(found.runs[0])
    assert run.time_s.size == 2 * ROWS
    np.testing.assert_allclose(run.pwm[1::2], run.pwm[::2])  # held from the row before
    known = run.temps["sensor_boiler"]
    assert np.isnan(known[::2]).all()
    assert np.isfinite(known[1::2]).sum() == ROWS - 1


def test_the_column_of_values_may_be_said(tmp_path: Path) -> None:
    frame = pd.read_csv(write(tmp_path, history())).rename(columns={"state": "measured", "entity_id": "name"})
    log = tmp_path / "long.csv"
    frame.to_csv(log, index=False)
    said = {"input": "sensor.heater_power", "full_scale": 2000.0}
    with pytest.raises(
        InputError, match="--series: which column holds the values nobody knows; expected --series name,C"
    ):
        take(log, tmp_path / "out", series="name", **said)
    assert read_run(take(log, tmp_path / "out", series="name,measured", **said).runs[0]).time_s.size == ROWS
    with pytest.raises(
        InputError, match='--series: found "nam", expected one of the columns name, measured, last_changed'
    ):
        take(log, tmp_path / "more", series="nam", **said)


def test_a_second_reading_of_one_name_and_time_is_counted(tmp_path: Path) -> None:
    text = history() + f"\nsensor.boiler_temperature,99.00,{times()[5]}"
    log = write(tmp_path, text)
    found = take(log, tmp_path / "out", series="entity_id", input="sensor.heater_power", full_scale=2000.0)
    assert found.counted()["count"]["second reading of one name and time, left out"] == 1
    assert read_run(found.runs[0]).temps["sensor_boiler"][5] == TEMPERATURE[5]
