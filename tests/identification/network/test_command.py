"""`gen identify --model network` and `gen.identify(model="network")` as a user meets them."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import gen
from gen.cli import main
from gen.runs import write_run
from tests.identification.network.plant import TWO, holds


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("runs")
    rng = np.random.default_rng(1)
    profiles = (holds((200, 50), (0, 40), (90, 40)), holds((120, 50), (255, 40), (0, 30)))
    made = [folder / f"day_{k}.csv" for k in range(len(profiles))]
    for path, pwm in zip(made, profiles, strict=True):
        write_run(path, TWO.run(pwm, rng))
    return made


def command(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    monkeypatch.setattr(sys, "argv", ["gen", "identify", *map(str, arguments)])
    try:
        main()
    except SystemExit as ended:
        return int(ended.code or 0)
    return 0


def test_runs_become_a_network_that_predicts_them(
    paths: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out, found = tmp_path / "coeffs.json", tmp_path / "found.json"
    assert command(monkeypatch, *paths, "--model", "network", "--max-hidden", 1, "--out", out, "--json", found) == 0
    printed = capsys.readouterr().out
    assert "network of 2 nodes, 0 of them hidden" in printed
    assert "2 component(s)" in printed
    said = json.loads(found.read_text())
    assert said["model"] == "network"
    assert [candidate["hidden"] for candidate in said["candidates"]] == [0, 1]
    assert set(said["components"]) == {"winding", "casing"}
    low, high = said["components"]["casing"]["speeds"]["200"]["steady_rise_K"]["interval"]
    # 6 w + 14 w^2 watts leave through 0.3 + 0.4 w at w = 200/255.
    w = 200.0 / 255.0
    assert low < (6.0 * w + 14.0 * w * w) / (0.3 + 0.4 * w) < high
    assert high - low < 2.0
    motor = gen.load(out)
    assert motor.components == ("winding", "casing")
    shown, read = gen.simulate(motor, paths[0]), gen.read_run(paths[0])
    for name in motor.components:
        assert float((shown[f"{name}_degC"] - read[f"{name}_degC"]).std()) < 0.25


def test_from_python_with_its_curves(paths: list[Path]) -> None:
    found = gen.identify(paths, model="network", max_hidden=0)
    assert isinstance(found, gen.NetworkIdentification)
    assert found.verdict == found.details()["verdict"]
    table = found.summary()
    assert {"steady_rise_K", "steady_rise_K_low", "steady_rise_K_high", "left_out_rms_K"} == set(table.columns)
    curve = found.curves()["day_0"]
    assert float((curve["casing_degC"] - curve["casing_model_degC"]).std()) < 0.1
    assert float(np.ptp(curve["casing_model_degC"])) > 10.0


def test_the_report_is_written_beside_the_file(
    paths: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, page = tmp_path / "coeffs.json", tmp_path / "r.html"
    assert command(monkeypatch, *paths, "--model", "network", "--max-hidden", 0, "--out", out, "--report", page) == 0
    assert sorted(tmp_path.iterdir()) == [out, page]
    assert "winding" in page.read_text(encoding="utf-8")


def test_another_model_is_refused(paths: list[Path]) -> None:
    with pytest.raises(gen.InputError, match="model: found 'tree', expected 'auto', 'parts', 'network'"):
        gen.identify(paths, model="tree")  # type: ignore[call-overload]
