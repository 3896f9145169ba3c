"""What an ESP publishes, among all else that its log says: both ways in which ESPHome has written it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from tests.importing.logs import taken, write

ROWS = 120
CASING = [22.0 + 0.1 * i for i in range(ROWS)]


def said(version: str, name: str, value: float, unit: str) -> str:
    if version == "2023":
        return f"[D][sensor:094]: '{name}': Sending state {value:.5f} {unit} with 1 decimals of accuracy"
    return f"[S][sensor]: '{name}' >> {value:.2f} {unit}"


def log(version: str, *, timed: bool = True, coloured: bool = False) -> str:
    lines = ["INFO ESPHome", "INFO Reading configuration /config/motor.yaml...", "[18:29:59][C][wifi:600]: WiFi:"]
    for i in range(ROWS):
        stamp = f"[18:{30 + 5 * i // 60:02d}:{5 * i % 60:02d}]" if timed else ""
        if i % 40 == 0:
            lines.append(stamp + said(version, "Motor Duty", 60.0 if i else 0.0, "%"))
        lines.append(stamp + said(version, "Casing Temperature", CASING[i], "°C"))
        if i % 6 == 0:
            lines.append(stamp + said(version, "Room Temperature", 22.0, "°C"))
        lines.append(f"{stamp}[W][component:237]: Component display took a long time for an operation (130 ms).")
    return "\n".join(f"\x1b[0;36m{line}\x1b[0m" if coloured else line for line in lines)


@pytest.mark.parametrize("version", ["2023", "2026"])
@pytest.mark.parametrize("coloured", [False, True])
def test_each_name_is_a_column_and_an_input_holds_until_it_is_published_anew(
    tmp_path: Path, version: str, coloured: bool
) -> None:
    run = taken(write(tmp_path, log(version, coloured=coloured), name="esp.log"), tmp_path / "out")
    np.testing.assert_allclose(run.time_s - run.time_s[0], 5.0 * np.arange(ROWS))
    np.testing.assert_allclose(run.temps["casing"], CASING, atol=0.006)
    assert run.pwm.tolist() == [0] * 40 + [153] * 80  # 60 %
    assert run.ambient is not None
    assert np.flatnonzero(np.isfinite(run.ambient)).tolist() == list(range(0, ROWS, 6))


def test_lines_without_a_time_say_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the line has no time; expected one before each") as found:
        taken(write(tmp_path, log("2023", timed=False), name="esp.log"), tmp_path / "out")
    assert found.value.place == "line 4"
    assert not (tmp_path / "out").exists()


def test_a_switch_is_an_input_of_nothing_or_all(tmp_path: Path) -> None:
    text = (
        log("2026")
        .replace("'Motor Duty' >> 0.00 %", "'Motor' >> OFF")
        .replace("'Motor Duty' >> 60.00 %", "'Motor' >> ON")
    )
    run = taken(write(tmp_path, text, name="esp.log"), tmp_path / "out", input="Motor", full_scale=1.0)
    assert run.pwm.tolist() == [0] * 40 + [255] * 80
