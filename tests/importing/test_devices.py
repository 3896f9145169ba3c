"""Logs with a row for each reading of a device, in columns that not all devices have."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from gen.arrays import FloatArray
from gen.errors import InputError
from tests.importing.logs import TRUE, take, taken, write

BEGIN = 1772439300
HEADER = ("ts", "device", "temp", "duty", "rpm")


def readings(late: tuple[float, float, float], order: str, rpm: bool = False) -> list[dict[str, object]]:
    """Of a drive, a motor and a room, each some time after the round began, in this order."""
    rows = []
    for i, (pwm, winding, ambient) in enumerate(TRUE[["pwm", "winding_degC", "ambient_degC"]].to_numpy().tolist()):
        at = BEGIN + 10 * i
        told: dict[str, dict[str, object]] = {
            "d": {"ts": at + late[0], "device": "drive", "duty": pwm / 2.55},
            "m": {"ts": at + late[1], "device": "motor", "temp": winding} | ({"rpm": 900 + 37 * i % 50} if rpm else {}),
            "r": {"ts": at + late[2], "device": "room", "temp": ambient},
        }
        rows += [told[letter] for letter in order]
    return rows


def as_json(rows: list[dict[str, object]]) -> str:
    return "\n".join(map(json.dumps, rows))


def as_csv(rows: list[dict[str, object]]) -> str:
    return "\n".join([",".join(HEADER), *(",".join(str(row.get(name, "")) for name in HEADER) for row in rows)])


def told(values: ArrayLike) -> FloatArray:
    found = np.asarray(values, dtype=np.float64)
    return found[np.isfinite(found)]


@pytest.mark.parametrize("form", [as_json, as_csv])
@pytest.mark.parametrize(
    ("late", "order"),
    [((0.0, 0.0, 0.0), "mrd"), ((0.0, 1.0, 2.0), "dmr"), ((0.0, 1.0, 2.0), "mrd"), ((0.0, 0.1, 0.2), "rdm")],
)
def test_each_device_keeps_what_it_tells(
    form: object, late: tuple[float, float, float], order: str, tmp_path: Path
) -> None:
    """Also the drive, whose duty is in a column that the others do not have; rows go back where devices do."""
    assert callable(form)
    log = write(tmp_path, form(readings(late, order)))
    with pytest.raises(InputError, match=r"has a row for each of drive, motor, room; expected --series device,temp,"):
        take(log, tmp_path / "out")
    columns = taken(log, tmp_path / "out", series="device,temp", units={"duty": "percent"}).columns()
    np.testing.assert_allclose(told(columns["motor_degC"])[-100:], TRUE.winding_degC[-100:])
    np.testing.assert_allclose(told(columns["ambient_degC"])[-100:], TRUE.ambient_degC[-100:])
    step = 3 if late[1] else 1
    np.testing.assert_array_equal(columns["pwm"], np.repeat(TRUE.pwm, step)[-len(columns["pwm"]) :])
    assert (np.diff(columns["time_s"]) > 0).all()


def test_several_columns_of_values(tmp_path: Path) -> None:
    """No column is called values, and the motor tells two: none of them may hold readings of both devices."""
    log = write(tmp_path, as_json(readings((0.0, 1.0, 2.0), "dmr", rpm=True)))
    with pytest.raises(InputError, match=r"between which temp goes to and fro; expected --series device,temp"):
        take(log, tmp_path / "out", units={"duty": "percent"})
    found = taken(log, tmp_path / "out", series="device,temp,rpm", units={"duty": "percent"})
    columns = found.columns()
    np.testing.assert_allclose(told(columns["motor_degC"]), TRUE.winding_degC)
    np.testing.assert_allclose(told(columns["ambient_degC"]), TRUE.ambient_degC)
    np.testing.assert_allclose(told(columns["speed_rpm"]), 900.0 + 37 * np.arange(len(TRUE)) % 50)
    assert sorted(set(columns["pwm"])) == [0, 204]


def test_devices_that_were_said_to_be_none_are_warned_of(tmp_path: Path) -> None:
    log = write(tmp_path, as_json(readings((0.0, 1.0, 2.0), "dmr")))
    found = take(log, tmp_path / "out", columns={"device": ""}, units={"duty": "percent"})
    assert any(
        "temp: goes to and fro with device" in said and "--series device,temp" in said for said in found.warnings
    )


def test_an_input_beside_all_readings_stays(tmp_path: Path) -> None:
    """Each sensor is read at a time of its own."""
    rows = []
    for i, row in enumerate(TRUE.itertuples()):
        rows.append(f"{10 * i},winding,{row.winding_degC},{row.pwm}")
        rows.append(f"{10 * i + 5},room,{row.ambient_degC},{row.pwm}")
    log = write(tmp_path, "\n".join(["time_s,sensor,temp,pwm", *rows]))
    columns = taken(log, tmp_path / "out", series="sensor,temp").columns()
    np.testing.assert_array_equal(columns["pwm"], np.repeat(TRUE.pwm, 2))


def test_a_temperature_that_differs_by_what_is_no_name_is_taken(tmp_path: Path) -> None:
    """A remark of each row that is named by whether the winding lies above a mean says nothing of sensors."""
    noise = TRUE.winding_degC * 0 + 40.0 + np.round(np.random.default_rng(0).normal(size=len(TRUE)), 1)
    words = np.where(noise > 40.0, "warm", "well")
    log = write(
        tmp_path, TRUE.assign(winding_degC=noise, casing_degC=noise[::-1].to_numpy(), remark=words).to_csv(index=False)
    )
    np.testing.assert_allclose(taken(log, tmp_path / "out").temps["winding"], noise)


def test_a_time_that_goes_back_again_and_again_is_told_so(tmp_path: Path) -> None:
    rows = [f"{BEGIN + 10 * i},{row.winding_degC},{row.pwm}" for i, row in enumerate(TRUE.itertuples())]
    log = write(tmp_path, "\n".join(["time,winding,pwm", *rows[::-1]]))
    with pytest.raises(InputError, match=r"goes back 119 times in 120 rows; expected --time time --sort"):
        take(log, tmp_path / "out")
    run = taken(log, tmp_path / "out", time="time", sort=True, units={"winding": "degC"})
    np.testing.assert_allclose(run.temps["winding"], TRUE.winding_degC)
