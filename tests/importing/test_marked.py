"""What servers and small instruments print round after round, a name and its number in a line; names in comments."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, take, taken, write

DUTY = TRUE.pwm / 2.55
STEP_S = 10
AT = 1_709_632_800 + STEP_S * np.arange(len(TRUE))


def of_sensors(coil: float, room: float, duty: float) -> list[str]:
    """`ipmitool sensor`: limits behind each reading, what is no number, and what is not there."""
    limits = "ok    | 0.000     | 0.000     | 95.000    | 98.000    | 98.000    "
    return [
        f"Coil Temp        | {coil:.3f}     | degrees C  | {limits}",
        f"Room Temp        | {room:.3f}     | degrees C  | {limits}",
        f"PS1 Duty         | {duty:.3f}   | percent    | {limits}",
        "Chassis Intru    | 0x0        | discrete   | 0x0000| na        | na        | na        | na        | na",
        "FAN3             | na         | RPM        | na    | na        | na        | na        | na        | na",
    ]


def of_records(coil: float, room: float, duty: float) -> list[str]:
    """`ipmitool sdr`: the unit behind the number."""
    return [
        f"Coil Temp        | {coil:.3f} degrees C      | ok",
        f"Room Temp        | {room:.3f} degrees C      | ok",
        f"PS1 Duty         | {duty:.3f} percent        | ok",
        "Intrusion        | Not Readable      | ns",
    ]


def of_tabs(coil: float, room: float, duty: float) -> list[str]:
    """As chargers and instruments write them."""
    return [f"Coil Temp\t{coil:.3f}", f"Room Temp\t{room:.3f}", f"PS1 Duty\t{duty:.3f}", "Alarm\tOFF"]


@pytest.mark.parametrize("printed", [of_sensors, of_records, of_tabs])
def test_rounds_of_names_and_numbers_below_a_time(
    printed: Callable[[float, float, float], list[str]], tmp_path: Path
) -> None:
    lines = []
    for at, coil, room, duty in zip(AT, TRUE.winding_degC, TRUE.ambient_degC, DUTY, strict=True):
        lines += [str(at), *printed(coil, room, duty)]
    units = {} if printed is not of_tabs else {"PS1 Duty": "percent"}
    run = taken(write(tmp_path, "\n".join(lines) + "\n", name="log.txt"), tmp_path / "out", units=units)
    np.testing.assert_allclose(run.temps["coil"], TRUE.winding_degC, atol=1e-3)
    assert run.ambient is not None
    np.testing.assert_allclose(run.ambient, TRUE.ambient_degC, atol=1e-3)
    np.testing.assert_array_equal(run.pwm, TRUE.pwm)
    np.testing.assert_allclose(np.diff(run.time_s), STEP_S)


def test_rounds_without_times_say_how_to_print_them(tmp_path: Path) -> None:
    lines = [line for coil in TRUE.winding_degC for line in of_sensors(coil, 21.0, 50.0)]
    log = write(tmp_path, "\n".join(lines) + "\n", name="log.txt")
    with pytest.raises(InputError, match=r"--time SECONDS .*better, print the time before each round: .*COMMAND"):
        take(log, tmp_path / "out")


def test_a_table_of_names_and_numbers_with_times_stays_one(tmp_path: Path) -> None:
    rows = ["name\tvalue\tat"]
    for at, coil, duty in zip(AT, TRUE.winding_degC, DUTY, strict=True):
        rows += [f"coil\t{coil:.3f}\t{at}", f"duty\t{duty:.3f}\t{at}"]
    with pytest.raises(InputError, match="--series name"):
        take(write(tmp_path, "\n".join(rows) + "\n", name="log.txt"), tmp_path / "out")


def test_names_and_units_in_comments_that_come_again(tmp_path: Path) -> None:
    """`nvidia-smi dmon -o DT`."""
    head = "#Date       Time        gpu   pwr gtemp mtemp    sm\n#YYYYMMDD   HH:MM:SS    Idx     W     C     C     %\n"
    text = ""
    for k, (coil, room, duty) in enumerate(zip(TRUE.winding_degC, TRUE.ambient_degC, DUTY, strict=True)):
        text += head if k % 20 == 0 else ""
        text += f" 20240305   10:{k // 6:02d}:{k % 6}0    0   220 {coil:5.1f} {room:5.1f} {duty:6.2f}\n"
    log = write(tmp_path, text, name="log.txt")
    run = taken(log, tmp_path / "out", input="sm", columns={"mtemp": "ambient_degC"})
    np.testing.assert_allclose(run.temps["gtemp"], TRUE.winding_degC, atol=0.06)
    np.testing.assert_array_equal(run.pwm, TRUE.pwm)
    np.testing.assert_allclose(np.diff(run.time_s), 10.0)
