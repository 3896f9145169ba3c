"""What drove the machine, from a log that is no motor's PWM to the coefficient file and what is made of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import gen
from gen.cli import cli
from gen.coefficients import parse
from gen.drawing.content import section_of
from gen.errors import InputError
from gen.interface import import_runs
from gen.runs import read_run
from gen.runs.drive import Drive, drive_of

STEP_S, TAU_S, RISE_K = 5.0, 300.0, 40.0


def log(folder: Path, name: str, levels: list[float], full_W: float = 500.0, rest_W: float = 0.0) -> Path:
    """A heater that follows its power with one time constant, logged in watts, scaled at import.

    With another rest so much is added to what is logged, as of a signal of 4 to 20 mA.
    """
    power = np.repeat(levels, 240)
    rise = np.zeros(power.size)
    for k in range(1, power.size):
        rise[k] = rise[k - 1] + STEP_S / TAU_S * (RISE_K * power[k - 1] / 500.0 - rise[k - 1])
    noise = np.random.default_rng(len(levels)).normal(0.0, 0.05, power.size)
    table = pd.DataFrame(
        {
            "time_s": STEP_S * np.arange(power.size),
            "Power (W)": power + rest_W,
            "block_degC": np.round(22.0 + rise + noise, 3),
            "ambient_degC": 22.0,
        }
    )
    path = folder / f"{name}.csv"
    table.to_csv(path, index=False)
    return import_runs([path], folder / "runs", input="Power (W)", full_scale=full_W + rest_W, rest=rest_W).runs[0]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("heater")


@pytest.fixture(scope="module")
def runs(folder: Path) -> list[Path]:
    return [log(folder, "mon", [200.0, 0.0]), log(folder, "tue", [500.0, 350.0, 0.0])]


@pytest.fixture(scope="module")
def coefficients(folder: Path, runs: list[Path]) -> Path:
    path = folder / "coeffs.json"
    report = folder / "found.html"
    result = CliRunner().invoke(cli, ["identify", *map(str, runs), "--out", str(path), "--report", str(report)])
    assert result.exit_code == 0, result.output
    return path


def test_the_input_reaches_the_coefficient_file_and_the_report(folder: Path, coefficients: Path) -> None:
    tree = json.loads(coefficients.read_text(encoding="utf-8"))
    assert tree["input"]["stands_for"] == {"quantity": "Power (W)", "unit": "W", "full_scale": 500}
    assert "Power (W): 255 counts = 500 W" in (folder / "found.html").read_text(encoding="utf-8")


def test_a_network_says_it_too(runs: list[Path]) -> None:
    found = gen.identify(runs, model="network", max_hidden=0, full_scale=255)
    assert found.model.coefficients.document.input.meaning == "Power (W): 255 counts = 500 W"


def test_the_project_says_it_in_words_and_computes_as_without_it(folder: Path, coefficients: Path) -> None:
    tree = json.loads(coefficients.read_text(encoding="utf-8"))
    del tree["input"]["stands_for"]
    plain = folder / "plain.json"
    plain.write_text(json.dumps(tree), encoding="utf-8")
    for path, out in ((coefficients, "with"), (plain, "without")):
        result = CliRunner().invoke(cli, ["build", str(path), "--out", str(folder / out)])
        assert result.exit_code == 0, result.output
    for name in ("README.md", "report.html", "lib/motor/src/motor.h"):
        assert "Power (W): 255 counts = 500 W" in (folder / "with" / name).read_text(encoding="utf-8")
        assert "stands for" not in (folder / "without" / name).read_text(encoding="utf-8")
    schedules = [
        [line for line in (folder / out / "lib/motor/src/motor_schedule.cpp").read_text().splitlines() if "{" in line]
        for out in ("with", "without")
    ]
    assert schedules[0] == schedules[1]


def test_plots_name_it_with_and_without_a_model(runs: list[Path], coefficients: Path) -> None:
    loaded = parse(coefficients.read_bytes())
    assert "PWM, counts (Power (W): 255 counts = 500 W)" in [p.label for p in section_of(runs[0], loaded).panels]
    assert "PWM, counts (Power (W), 255 = 500 W)" in [p.label for p in section_of(runs[0], None).panels]


def test_a_run_scaled_otherwise_is_refused_by_what_takes_the_model(folder: Path, coefficients: Path) -> None:
    other = log(folder, "wed", [300.0, 0.0], full_W=400.0)
    message = r"found Power \(W\), 255 = 400 W; expected as in .*stands_for, Power \(W\): 255 counts = 500 W"
    with pytest.raises(InputError, match=message) as caught:
        gen.simulate(gen.load(coefficients), other)
    assert (caught.value.file, caught.value.place) == (str(other), "comment input")
    first = folder / "runs" / "mon.csv"
    for fit, test in ((other, first), (first, other)):
        with pytest.raises(InputError, match=message):
            gen.refine(gen.load(coefficients), fit=[fit], test=[test])


def test_runs_that_disagree_are_refused_before_any_fit(folder: Path, runs: list[Path]) -> None:
    other = log(folder, "thu", [300.0, 0.0], full_W=450.0)
    for model in ("parts", "network"):
        with pytest.raises(InputError, match=r"found .*255 = 450 W; expected one input for all runs, and .*mon.csv"):
            gen.identify([*runs, other], model=model)


def test_a_full_scale_below_255_stands_for_its_share(runs: list[Path]) -> None:
    found = gen.identify([runs[0]], full_scale=204)
    assert found.model.coefficients.document.input.meaning == "Power (W): 204 counts = 400 W"


def test_a_rest_that_is_not_0_is_no_part_of_the_share(folder: Path, runs: list[Path]) -> None:
    path = log(folder, "sat", [200.0, 0.0], rest_W=125.0)
    found = gen.identify([path], full_scale=204)
    document = found.model.coefficients.document
    assert document.input.meaning == "Power (W): 204 counts = 525 W, 0 counts = 125"
    told = gen.identify([runs[0]], full_scale=204).model.coefficients.document
    assert document.components == told.components  # the same heater
    with pytest.raises(InputError, match=r"found Power \(W\), 255 = 500 W; expected .*stands_for, .*0 counts = 125"):
        gen.simulate(found.model, runs[0])


@pytest.mark.parametrize(
    "text",
    [
        "",
        "153 in all rows",
        "pwm",
        "x, 255 = ",
        "x, 255 = 1e999 W",
        "x, 255 = 0 W",
        "x, 255 = 1.2.3 W",
        "x, 254 = 5 W",
        "x, 255 = 4 mA, 0 = 4",
    ],
)
def test_a_comment_that_says_nothing_of_a_scale_is_none(text: str) -> None:
    assert drive_of({"input": text}) is None


@pytest.mark.parametrize(
    "drive",
    [
        Drive("Power (W)", "W", 500.0),
        Drive("a, 255 = 3 A", "A", 12.5, "direction"),
        Drive("throttle", "percent", 100.0),
        Drive("Valve", "mA", 20.0, "", 4.0),
        Drive("stick, x", "of its own unit", 1.0, "way", -1.0),
        Drive("I", "of its own unit", 1e-06),
    ],
)
def test_what_is_written_is_read(drive: Drive) -> None:
    assert drive_of({"input": drive.text()}) == drive


def test_a_motors_own_pwm_stands_for_itself(tmp_path: Path) -> None:
    path = tmp_path / "own.csv"
    path.write_text("time_s,pwm,block_degC\n" + "".join(f"{k},{200 + k % 2},{20 + k}\n" for k in range(30)))
    made = read_run(import_runs([path], tmp_path / "runs").runs[0])
    drive = drive_of(made.comments)
    assert drive is not None
    assert drive.is_pwm


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        (Drive("PWM", "counts", 255.0), Drive("Duty (%)", "percent", 100.0), True),
        (Drive("Duty (%)", "percent", 100.0), Drive("duty", "duty", 1.0), True),
        (Drive("Duty (%)", "percent", 80.0), Drive("duty", "duty", 1.0), False),  # 80 % is all of it here
        (Drive("Duty (%)", "percent", 80.0), Drive("Stellgrad", "percent", 80.0), True),
        (Drive("I", "A", 100.0), Drive("Duty (%)", "percent", 100.0), False),
        (Drive("I", "A", 12.0), Drive("I", "A", 12.5), False),
        (Drive("I", "mA", 20.0, rest=4.0), Drive("valve", "mA", 20.0, rest=4.0), True),
        (Drive("I", "mA", 20.0, rest=4.0), Drive("I", "mA", 20.0), False),
        (Drive("Duty (%)", "percent", 100.0, rest=50.0), Drive("duty", "duty", 1.0), False),
    ],
)
def test_a_share_is_the_same_in_any_unit(one: Drive, other: Drive, alike: bool) -> None:
    assert one.agrees(other) is alike
    assert other.agrees(one) is alike


def test_counts_that_one_log_does_not_call_so_are_refused_with_what_makes_them_agree(tmp_path: Path) -> None:
    values = np.where(np.arange(60) % 40 < 20, 1023, 0)
    frame = pd.DataFrame({"time_s": 5.0 * np.arange(60), "field 1": values, "block_degC": 22.0 + np.arange(60) / 10.0})
    named, bare = tmp_path / "named.csv", tmp_path / "bare.csv"
    frame.rename(columns={"field 1": "pwm"}).to_csv(named, index=False)
    frame.to_csv(bare, index=False)
    first = import_runs([named], tmp_path / "runs", full_scale=1023).runs[0]
    found = import_runs([bare], tmp_path / "runs", input="field 1", full_scale=1023)
    assert "if these are counts: --unit 'field 1=counts'" in str(found.guesses().loc["field 1", "why"])
    for both in ([first, found.runs[0]], [found.runs[0], first]):
        with pytest.raises(InputError, match=r"; where field 1 is in counts, too: .* --unit 'field 1=counts'$"):
            gen.identify(both)
    again = import_runs(
        [bare], tmp_path / "runs", input="field 1", full_scale=1023, units={"field 1": "counts"}, overwrite=True
    )
    one, other = (drive_of(read_run(path).comments) for path in (first, again.runs[0]))
    assert one is not None
    assert other is not None
    assert one.agrees(other)


def test_no_unit_makes_scales_agree_that_differ() -> None:
    assert Drive("field1", "of its own unit", 1023.0).remedy(Drive("pwm", "counts", 255.0)) == ""
    assert Drive("I", "A", 12.0).remedy(Drive("P", "W", 12.0)) == ""


def test_one_motor_logged_as_percent_as_share_and_as_counts_is_one_motor(tmp_path: Path) -> None:
    paths = []
    for name, (column, unit) in {"a": ("Duty (%)", 100.0), "b": ("duty", 1.0), "c": ("pwm", 255.0)}.items():
        made = read_run(log(tmp_path, name, [500.0, 200.0, 0.0]))
        table = pd.DataFrame(
            {"time_s": made.time_s, column: made.pwm / 255.0 * unit, "block_degC": made.temps["block"]}
        )
        table["ambient_degC"] = 22.0
        if column == "pwm":
            table[column] = made.pwm
        table.to_csv(tmp_path / f"{name}_as.csv", index=False)
        paths += import_runs([tmp_path / f"{name}_as.csv"], tmp_path / f"runs_{name}").runs
    assert (
        len({(tmp_path / path).read_text(encoding="utf-8").split("255 = ")[1].split("\n")[0] for path in paths[:2]})
        == 2
    )
    found = gen.identify(paths)
    for path in paths:
        simulated, run = gen.simulate(found.model, path), gen.read_run(path)
        assert (simulated["block_degC"] - run["block_degC"]).abs().mean() < 0.5
