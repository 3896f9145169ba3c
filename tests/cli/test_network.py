"""A network at the command line: simulated exactly, refused in one line by each command that cannot take it yet."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
import pytest

import gen as package
from gen.cli import cli
from gen.errors import InputError
from tests.cli.test_light import ended
from tests.command import gen
from tests.examples import NETWORKS, ROOT

PAGE = (ROOT / "docs" / "format.md").read_text(encoding="utf-8")
RUN = "time_s,pwm,casing_degC,fan_percent\n0,102,30,0\n60,102,31,50\n900,0,32,0\n"

#: A command line for each command that takes a coefficient file, and what it says that it is.
REFUSED = {
    "build --schedule onboard": ("build FILE --schedule onboard --out out", "gen build --schedule onboard"),
    "verify --schedule onboard": ("verify FILE --schedule onboard --json out.json", "gen verify --schedule onboard"),
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("run.csv", "test.csv"):
        (tmp_path / name).write_text(RUN)
    (tmp_path / "rules.json").write_text('{"alarms": []}')
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_command_that_cannot_take_a_network_says_so_and_writes_nothing(folder: Path) -> None:
    before = sorted(folder.rglob("*"))
    for name in NETWORKS:
        file = str(ROOT / "examples" / name / "coeffs.json")
        given = [line.replace("FILE", file) for line, _ in REFUSED.values()]
        for (_, what), (status, said, _) in zip(REFUSED.values(), ended(folder, given), strict=True):
            sentence = f"{what} takes transfer functions only, and this is a network (docs/format.md)"
            assert (status, said) == (2, f"error: {file}: $.network: {sentence}\n")
    assert sorted(folder.rglob("*")) == before


def test_the_page_s_table_says_the_same() -> None:
    rows = dict(re.findall(r"^\| `gen (\w+)` \| [^|]+ \| ([^|]+) \|$", PAGE, re.MULTILINE))
    assert set(rows) == set(cli.commands)
    assert not [name for name, cell in rows.items() if "not yet" in cell]


@pytest.mark.parametrize("name", NETWORKS)
def test_simulate_writes_the_sensed_nodes(folder: Path, name: str) -> None:
    done = gen("simulate", ROOT / "examples" / name / "coeffs.json", "run.csv", "--out", "out.csv", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    made = pd.read_csv(folder / "out.csv", comment="#")
    loaded = package.load(ROOT / "examples" / name / "coeffs.json")
    assert made.columns.tolist() == ["time_s", *(f"{part}_degC" for part in loaded.components)]
    shown = package.simulate(loaded, folder / "run.csv")
    np.testing.assert_allclose(made["casing_degC"], shown["casing_degC"], rtol=0.0, atol=1e-12)
    assert made["casing_degC"][0] == pytest.approx(30.0)


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_the_board_simulated_is_near_the_exact_solution(folder: Path, arithmetic: Literal["fixed", "float"]) -> None:
    """Rows lie on the board's grid, so that only its arithmetic is between the two; hidden nodes start alike."""
    loaded = package.load(ROOT / "examples" / "network" / "coeffs.json")
    time = np.arange(0.0, 1200.0, 20.0)
    run = pd.DataFrame(
        {
            "time_s": time,
            "pwm": np.where(time < 600.0, 200, -90),
            "bearing_degC": 41.0,
            "magnet_degC": 38.5,
            "ambient_degC": np.where(time < 300.0, 22.25, 24.5),
            "fan_percent": np.where(time < 800.0, 0.0, 65.0),
        }
    )
    exact = package.simulate(loaded, run)
    board = package.simulate(loaded, run, arithmetic=arithmetic)
    for name in loaded.components:
        np.testing.assert_allclose(board[f"{name}_degC"], exact[f"{name}_degC"], rtol=0.0, atol=2e-5)
    assert exact["bearing_degC"].iloc[0] == pytest.approx(41.0)
    assert float(np.ptp(exact["casing_degC"])) > 1.0


def test_a_model_in_memory_is_refused_without_a_file() -> None:
    motor = package.load(ROOT / "examples" / "two_nodes" / "coeffs.json")
    assert motor.components == ("casing",)
    with pytest.raises(InputError, match=r"^\$\.network: this takes transfer functions only"):
        package.Model(motor.coefficients, motor.text).transfer_functions_only("this")
    with pytest.raises(InputError, match=r"steady_rise\(\) takes transfer functions only"):
        motor.steady_rise()
    with pytest.raises(InputError, match=r"transfer_function\(\) takes transfer functions only"):
        motor.transfer_function("casing", 153)
