"""What `import gen` offers, as someone at a notebook uses it."""

from __future__ import annotations

import doctest
import importlib
import inspect
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import click
import control
import numpy as np
import pandas as pd
import pytest

import gen
from gen.cli import cli
from gen.emulate.scenario import Scenario
from tests.examples import ROOT

MY1016 = ROOT / "examples" / "my1016" / "coeffs.json"


@pytest.fixture
def motor() -> gen.Model:
    return gen.load(MY1016)


def frame(*rows: tuple[float, int], **columns: float) -> pd.DataFrame:
    time, pwm = zip(*rows, strict=True)
    return pd.DataFrame({"pwm": pwm, **columns}, index=pd.Index(time, name="time_s"))


@pytest.mark.parametrize("module", ["certificate", "files", "firmware", "model", "simulation"])
def test_every_example_of_the_docstrings_runs(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    result = doctest.testmod(importlib.import_module(f"gen.interface.{module}"), optionflags=doctest.ELLIPSIS)
    assert result.attempted > 0
    assert result.failed == 0


def test_importing_the_package_is_quick() -> None:
    code = (
        "import gen, sys; print([m for m in ('numpy', 'scipy', 'pandas', 'control', 'matplotlib') if m in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_all_that_is_promised_is_there() -> None:
    for name in gen.__all__:
        assert getattr(gen, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = gen.nothing


def test_importing_a_room_hides_no_function(motor: gen.Model) -> None:
    for room in ("identification", "refinement", "verification", "reference.simulate"):
        importlib.import_module(f"gen.{room}")
    assert all(callable(f) for f in (gen.identify, gen.refine, gen.verify, gen.simulate, gen.build))


def test_a_component_is_a_control_system(motor: gen.Model) -> None:
    """The step response of python-control is the simulator's, where PWM is held."""
    system = motor.transfer_function("brush", 153)
    assert isinstance(system, control.TransferFunction)
    time = np.linspace(0.0, 7200.0, 25)
    response = 153.0 * control.step_response(system, time).outputs
    run = pd.DataFrame({"pwm": 153}, index=pd.Index(time, name="time_s"))
    rise = gen.simulate(motor, run)["brush_degC"] - 30.0
    assert rise.to_numpy() == pytest.approx(response, abs=1e-4)
    assert motor.steady_rise().loc[153, "brush"] == pytest.approx(153.0 * system.dcgain().real)


def test_a_frame_and_its_file_give_the_same(motor: gen.Model, tmp_path: Path) -> None:
    run = frame((0.0, 100), (10.0, 0), (600.0, 51), (900.25, 51), casing_degC=31.5, ambient_degC=29.0)
    path = tmp_path / "run.csv"
    run.reset_index().to_csv(path, index=False)
    pd.testing.assert_frame_equal(gen.simulate(motor, run), gen.simulate(motor, path))
    read = gen.read_run(path)
    assert list(read.columns) == ["pwm", "casing_degC", "ambient_degC"]
    assert read.attrs["name"] == "run"
    pd.testing.assert_frame_equal(gen.simulate(motor, read), gen.simulate(motor, path))


def test_the_board_is_simulated_word_for_word(motor: gen.Model) -> None:
    run = frame(*((float(t), 153) for t in range(0, 600, 60)))
    board, exact = gen.simulate(motor, run, "fixed"), gen.simulate(motor, run)
    assert board["casing_degC"].to_numpy() == pytest.approx(exact["casing_degC"].to_numpy(), abs=1e-4)
    words = [name for name in board if name not in exact]
    assert words
    assert all(board[name].dtype == np.int64 for name in words)


@pytest.mark.parametrize(
    ("run", "message"),
    [
        (pd.DataFrame({"pwm": [1, 2]}), "run 1: expected an index or a column named time_s"),
        (frame((1.0, 5), (1.0, 5)), "frame run_1"),
        (frame((0.0, 300)), "frame run_1"),
        (pd.DataFrame({"time_s": [0.0], "speed": [3]}), "frame run_1"),
        (["no", "run"], "run 1 is a list; expected a path or a pandas DataFrame"),
    ],
)
def test_a_frame_that_is_no_run_is_refused_like_a_file(motor: gen.Model, run: object, message: str) -> None:
    with pytest.raises(gen.InputError, match=message):
        gen.simulate(motor, run)


def test_a_project_is_built_and_its_guarantees_are_told(motor: gen.Model, tmp_path: Path) -> None:
    built = gen.build(motor, tmp_path / "firmware")
    assert (built.folder / "platformio.ini").is_file()
    guarantees = built.guarantees()
    assert list(guarantees.index) == list(motor.components)
    assert (guarantees["bound_K"] < 1e-5).all()
    (built.folder / "src" / "main.cpp").write_text("// mine\n")
    with pytest.raises(gen.InputError):
        gen.build(motor, built.folder)


def test_a_model_is_saved_as_it_was_read(motor: gen.Model, tmp_path: Path) -> None:
    motor.save(tmp_path / "copy.json")
    assert (tmp_path / "copy.json").read_bytes() == MY1016.read_bytes()
    with pytest.raises(gen.InputError):
        motor.save(tmp_path / "no folder" / "copy.json")


def test_attributes_of_a_frame_that_no_run_file_holds_are_no_fault_of_its_rows(motor: gen.Model) -> None:
    run = frame((0.0, 100), (10.0, 100))
    run.attrs.update({"note": "first\nsecond", "https://a": "b", "ambient_degC": 22})
    assert gen.simulate(motor, run).index.tolist() == [0.0, 10.0]


def test_a_wrong_argument_is_told_before_any_work(motor: gen.Model, tmp_path: Path) -> None:
    run = frame((0.0, 100), (10.0, 100))
    wrong: list[tuple[Callable[..., object], tuple[object, ...], dict[str, object], str]] = [
        (gen.load, (None,), {}, "path: found a NoneType, expected a path"),
        (gen.read_run, (3,), {}, "path: found a int, expected a path"),
        (gen.simulate, (motor, run, "double"), {}, "arithmetic: found 'double', expected 'exact', 'fixed', 'float'"),
        (gen.simulate, (motor, run), {"start": "hot"}, "start: found 'hot'"),
        (gen.identify, (run,), {}, "runs: found a DataFrame, expected a list of runs"),
        (gen.identify, ("run.csv",), {}, "runs: found a str, expected a list of runs"),
        (gen.identify, ([],), {}, "runs: found no run, expected at least one"),
        (gen.identify, ([run],), {"max_order": 9}, "max_order: found 9, expected a whole number from 1 to 4"),
        (gen.identify, ([run],), {"max_hidden": 1.5}, "max_hidden: found 1.5, expected a whole number from 0 to 3"),
        (gen.identify, ([run],), {"full_scale": 254.5}, "full_scale: found 254.5, expected a whole number"),
        (gen.identify, ([run],), {"model": "parts", "drives": "heater"}, "parts know nothing of that"),
        (gen.identify, ([run],), {"ambient": float("nan")}, "ambient: found nan"),
        (gen.identify, ([run],), {"ambient": -280.0}, "ambient: found -280.0, expected a number from -273.15 to 1000"),
        (gen.refine, (motor,), {"fit": [], "test": [run]}, "fit: found no run"),
        (gen.refine, (motor,), {"fit": [run], "test": [run]}, "a run is given as fit and as test"),
        (gen.import_runs, (["log.csv"], tmp_path / "x"), {"rest": float("-inf")}, "rest: found -inf"),
        (gen.import_runs, (["log.csv"], tmp_path / "x"), {"full_scale": 0.0}, "full_scale: found 0.0"),
        (gen.build, (motor, tmp_path / "x"), {"arithmetic": "quick"}, "arithmetic: found 'quick'"),
        (gen.verify, (motor,), {"target": "moon"}, "target: found 'moon', expected 'host', 'avr', 'all'"),
        (gen.verify, (motor,), {"scale": 0}, "scale: found 0, expected a number from 0.001 to 10"),
    ]
    for function, arguments, options, message in wrong:
        with pytest.raises(gen.InputError) as told:
            function(*arguments, **options)
        assert message in str(told.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "function"),
    [
        ("build", gen.build),
        ("emulate", Scenario),
        ("identify", gen.identify),
        ("import", gen.import_runs),
        ("plan", gen.plan),
        ("refine", gen.refine),
        ("simulate", gen.simulate),
        ("verify", gen.verify),
    ],
)
def test_what_is_left_out_is_the_same_for_a_command_and_in_python(name: str, function: Callable[..., object]) -> None:
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    asked = command.make_context(name, [], resilient_parsing=True).params
    given = {each.name: each.default for each in inspect.signature(function).parameters.values()}
    both = {key for key in asked.keys() & given.keys() if given[key] is not inspect.Parameter.empty}
    assert both
    for key in both:
        assert (given[key] or None) == ((str(asked[key]) if key == "out" else asked[key]) or None), key
