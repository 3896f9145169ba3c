"""The calibration's command, and that its page in the documentation is up to date."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from gen.rig import NODES, Motor, MotorConfig, my1016
from gen.rig.calibrate.__main__ import main
from gen.rig.calibrate.targets import time_to_63
from gen.rig.calibrate.unknowns import GUESSES, UNKNOWNS, motor
from gen.rig.response import held, no_load
from gen.runs import read_run

PAGE = Path(__file__).parents[2] / "docs" / "rig.md"


def test_the_documentation_holds_the_numbers_of_the_stored_motor(tmp_path: Path) -> None:
    copy = tmp_path / "rig.md"
    copy.write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    result = CliRunner().invoke(main, ["--doc", str(copy)])
    assert result.exit_code == 0, result.output
    assert copy.read_text(encoding="utf-8") == PAGE.read_text(encoding="utf-8")


def test_the_pages_example_runs_and_shows_the_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = PAGE.read_text(encoding="utf-8").split("```python")[1].split("```")[0]
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(code, names)
    run = read_run("run.csv")
    assert run.time_s[-1] == 10_800.0
    assert run.temps["casing"][7200] > 70.0
    assert (tmp_path / "truth.csv").is_file()


def test_a_page_without_marks_is_refused_and_left_alone(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("nothing to fill\n", encoding="utf-8")
    result = CliRunner().invoke(main, ["--doc", str(page)])
    assert result.exit_code == 2
    assert "page.md: expected one pair of marks" in result.output
    assert page.read_text(encoding="utf-8") == "nothing to fill\n"


def test_first_guesses_make_the_motor_that_they_describe() -> None:
    guessed = motor(GUESSES)
    values = {unknown.name: unknown.guess for unknown in UNKNOWNS}
    assert guessed.capacities_J_per_K["casing"] == pytest.approx(values["capacity.casing"])
    path = guessed.path("air", "casing")
    assert path.still_W_per_K == pytest.approx(values["still.air-casing"])
    assert path.forced_W_per_K == pytest.approx(values["forced.air-casing"])
    assert guessed.losses.ripple_eddy_W == pytest.approx(values["losses.ripple_eddy_W"])
    assert guessed.faults.brush.arc_W == pytest.approx(values["brush.arc_W"])


def test_closed_form_response_is_that_of_the_motor_in_time() -> None:
    point = held(my1016(), no_load(0.4), ambient_degC=20.0)
    times = np.array([600.0, 3600.0, 40_000.0])
    closed = point.rise_from(np.full(len(NODES), 20.0), times)
    running, now = Motor(MotorConfig(max_step_s=1.0), ambient_degC=20.0), 0.0
    for time, expected in zip(times, closed, strict=True):
        running.step(102, time - now)
        now = time
        # The start of the rotor and the winding's resistance on the way are left out of the closed form.
        np.testing.assert_allclose(running.state, expected, atol=0.02)


def test_time_to_63_percent_of_a_first_order_step_is_its_time_constant() -> None:
    times = np.arange(0.0, 20_000.0, 10.0)
    assert abs(time_to_63(times, -np.expm1(-times / 700.0)) - 700.0) < 0.05
