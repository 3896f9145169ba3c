"""A network at the command line: simulated exactly, refused in one line by each command that cannot take it yet."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import gen as package
from gen.cli import cli
from gen.errors import InputError
from tests.cli.commands import gen
from tests.cli.test_light import ended
from tests.examples import NETWORKS, ROOT

PAGE = (ROOT / "docs" / "format.md").read_text(encoding="utf-8")
RUN = "time_s,pwm,casing_degC,fan_percent\n0,102,30,0\n60,102,31,50\n900,0,32,0\n"

#: A command line for each command that takes a coefficient file, and what it says that it is.
REFUSED = {
    "build": ("build FILE --out out", "gen build"),
    "verify": ("verify FILE --target avr --json out.json", "gen verify"),
    "check": (f"check {ROOT / 'firmware_out'} --coefficients FILE", "gen check --coefficients"),
    "simulate": ("simulate FILE run.csv --arithmetic fixed --out out.csv", "gen simulate --arithmetic fixed"),
    "emulate": ("emulate FILE --out out.csv", "gen emulate"),
    "refine": ("refine FILE --fit run.csv --test test.csv --out out.json", "gen refine"),
    "thresholds": ("thresholds FILE run.csv --rules rules.json --out out.json", "gen thresholds"),
}
OTHERS = {
    "build --schedule onboard": ("build FILE --schedule onboard --out out", "gen build --schedule onboard"),
    "simulate --arithmetic float": ("simulate FILE run.csv --arithmetic float", "gen simulate --arithmetic float"),
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("run.csv", "test.csv"):
        (tmp_path / name).write_text(RUN)
    (tmp_path / "rules.json").write_text('{"alarms": []}')
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_command_that_cannot_take_a_network_says_so_and_writes_nothing(folder: Path) -> None:
    commands = {**REFUSED, **OTHERS}
    before = sorted(folder.rglob("*"))
    for name in NETWORKS:
        file = str(ROOT / "examples" / name / "coeffs.json")
        given = [line.replace("FILE", file) for line, _ in commands.values()]
        for (_, what), (status, said, _) in zip(commands.values(), ended(folder, given), strict=True):
            sentence = f"{what} takes transfer functions only, and this is a network (docs/format.md)"
            assert (status, said) == (2, f"error: {file}: $.network: {sentence}\n")
    assert sorted(folder.rglob("*")) == before


def test_the_page_s_table_says_the_same() -> None:
    rows = dict(re.findall(r"^\| `gen (\w+)` \| [^|]+ \| ([^|]+) \|$", PAGE, re.MULTILINE))
    assert set(rows) == set(cli.commands)
    assert {name for name, cell in rows.items() if "not yet" in cell} == {*REFUSED, "identify"}


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


def test_a_model_in_memory_is_refused_without_a_file() -> None:
    motor = package.load(ROOT / "examples" / "two_nodes" / "coeffs.json")
    assert motor.components == ("casing",)
    with pytest.raises(InputError, match=r"^\$\.network: this takes transfer functions only"):
        package.Model(motor.coefficients, motor.text).transfer_functions_only("this")
    with pytest.raises(InputError, match=r"steady_rise\(\) takes transfer functions only"):
        motor.steady_rise()
    with pytest.raises(InputError, match=r"transfer_function\(\) takes transfer functions only"):
        motor.transfer_function("casing", 153)
