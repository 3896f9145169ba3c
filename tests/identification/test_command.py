"""`gen identify` as a user meets it: the chain to a verified build, and what it costs."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.real_machines.shipped import predict
from gen.cli import main
from gen.identification.parts import joint
from gen.identification.parts.output_error import OutputErrorProblem
from gen.model import ExactSolution
from gen.runs import Run, write_run
from tests.command import gen
from tests.model.examples import model

NAMES = ("brush", "bearing", "magnet", "casing")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Three hours at 0.25 s, four components, five speeds; sensors with noise and 0.25 degC."""
    folder = tmp_path_factory.mktemp("runs")
    rng = np.random.default_rng(1)
    solution = ExactSolution(model("my1016"))
    clock = np.arange(43_200, dtype=np.float64) * 0.25
    paths = []
    for pwm in (51, 102, 153, 204, 255):
        counts = np.where(clock < 8000.0, pwm, 0)
        rise = solution.simulate(counts)
        temps = {n: np.round((30.0 + rise[n][:-1] + rng.normal(0.0, 0.15, len(clock))) * 4) / 4 for n in NAMES}
        paths.append(folder / f"pwm_{pwm}.csv")
        write_run(paths[-1], Run(clock, counts, temps, np.full(len(clock), 30.0)))
    return paths


@pytest.fixture
def searches(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int]]:
    """Of each search for parameters: how often it ran the model through all records, and over how many rows."""
    made: list[tuple[int, int]] = []
    for function in (OutputErrorProblem, joint.refine):
        module = sys.modules[function.__module__]

        def counted(*arguments: Any, search: Callable[..., Any] = module.least_squares, **options: Any) -> Any:  # noqa: ANN401
            found = search(*arguments, **options)
            made.append((found.nfev, found.fun.size))
            return found

        monkeypatch.setattr(module, "least_squares", counted)
    return made


def test_identify_build_verify_without_editing(
    runs: list[Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    searches: list[tuple[int, int]],
) -> None:
    out, report, found = tmp_path / "coeffs.json", tmp_path / "report.html", tmp_path / "found.json"
    command = ["gen", "identify", *runs, "--model", "parts", "--out", out, "--report", report, "--json", found]
    monkeypatch.setattr(sys, "argv", list(map(str, command)))
    main()
    assert capsys.readouterr().err == ""
    # How long that takes: benchmarks/speed.py. Here, 216 000 rows become some thousand for each component.
    assert 100 < sum(times for times, _ in searches) < 3_000
    assert max(rows for _, rows in searches) < 5_000
    for name, part in json.loads(found.read_text())["components"].items():
        assert part["order"] == (3 if name == "brush" else 1)
        for pwm in (51, 102, 153, 204, 255):
            true = model("my1016").component(name).steady_rise([pwm])[0]
            assert part["speeds"][str(pwm)]["steady_rise_K"]["value"] == pytest.approx(true, abs=0.25)
    assert gen("build", out, "--out", tmp_path / "firmware").returncode == 0
    options = ("--target", "host", "--compilers", "g++,clang++", "--arithmetic", "fixed", "--schedule", "table")
    checked = gen("verify", out, *options, "--scale", "0.005")
    assert checked.returncode == 0, checked.stderr
    assert "none differs" in checked.stdout


@pytest.mark.parametrize("ambient", ["-273.2", "1000.1"])
def test_an_ambient_that_no_room_has_is_usage(ambient: str, tmp_path: Path) -> None:
    done = gen("identify", tmp_path / "run.csv", "--out", tmp_path / "c.json", "--ambient", ambient)
    assert (done.returncode, done.stdout) == (2, "")
    assert "-273.15" in done.stderr
    assert "1000" in done.stderr.replace(ambient, "")


def test_help_has_an_example_and_a_bad_name_is_usage(runs: list[Path], tmp_path: Path) -> None:
    done = gen("identify", "--help")
    assert "gen identify cold_*.csv" in " ".join(done.stdout.split())
    done = gen("identify", runs[0], "--out", tmp_path / "c.json", "--name", "while")
    assert done.returncode == 2
    assert "keyword" in done.stderr
    assert not (tmp_path / "c.json").exists()


def test_a_real_machine_s_unused_run_is_predicted() -> None:
    """The Temperature Control Lab's first heater; its second, which the model does not know, warms the sensor too."""
    (prediction,), left_out = predict("Temperature Control Lab, heater 1")
    assert not left_out
    assert prediction.moved_K > 20.0
    assert prediction.rms_K < 0.15 * prediction.moved_K
