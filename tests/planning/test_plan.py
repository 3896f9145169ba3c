"""`gen plan` as a user meets it, and what `gen refine` says of a run that followed a plan."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

import gen
from gen.cli import cli
from gen.model.network_solution import NetworkSolution
from gen.planning import plan as planning
from gen.record.profile import carried_comments, parse_profile
from gen.refinement.network.planned import Expectation, Pair, followed, settled
from gen.runs import EXPECTS, Run, write_run
from tests.examples import ROOT
from tests.planning.open_question import AMBIENT, changed, short_run
from tests.refinement.network.motor import read, run, tree


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("plan")
    (made / "small.json").write_text(json.dumps(tree()), encoding="utf-8")
    write_run(made / "short.csv", short_run())
    return made


@pytest.fixture(scope="module")
def planned(folder: Path) -> Result:
    """The command, once."""
    given = ["plan", str(folder / "small.json"), str(folder / "short.csv"), "--hours", "2", "--limit-degC", "80"]
    return CliRunner().invoke(cli, [*given, "--out", str(folder / "next.csv"), "--json", str(folder / "next.json")])


def test_the_profile_is_one_that_emulate_and_log_take(planned: Result, folder: Path) -> None:
    assert planned.exit_code == 0, planned.output
    profile = parse_profile(str(folder / "next.csv"))
    assert profile[0][0] == 0.0
    assert profile[-1][1] == 0
    assert profile[-1][0] < 7200.0
    (comment,) = carried_comments(str(folder / "next.csv"))
    expected = Expectation.model_validate_json(comment.removeprefix(f"# {EXPECTS}: "))
    assert sum(seconds for _, seconds in expected.holds) == 7200.0
    assert carried_comments("0:153,3600:0") == carried_comments(None) == []


def test_the_table_and_the_summary_say_what_is_expected(planned: Result, folder: Path) -> None:
    said = json.loads((folder / "next.json").read_text(encoding="utf-8"))
    assert all(name in planned.output for name in said["hypotheses"])
    assert "hottest: winding" in planned.output
    assert set(said["hottest_degC"]) == {"winding", "casing"}
    assert all(said["hottest_degC"][name] <= said["allowed_degC"][name] for name in said["hottest_degC"])
    assert said["allowed_degC"] == {"winding": 77.0, "casing": 77.0}
    assert said["readings_95_K"]["after"] < said["readings_95_K"]["before"]


def test_the_function_gives_what_the_command_wrote(planned: Result, folder: Path, tmp_path: Path) -> None:
    assert planned.exit_code == 0
    made = gen.plan(gen.load(folder / "small.json"), [folder / "short.csv"], hours=2, limit_degC=80.0)
    made.save(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == (folder / "next.csv").read_bytes()
    assert json.loads(json.dumps(made.details())) == json.loads((folder / "next.json").read_text(encoding="utf-8"))
    assert made.profile["pwm"].abs().max() <= 255
    assert len(made.separations()) == len(made.details()["pairs"])


def test_a_healthy_motor_well_known_leaves_nothing_to_be_decided(tmp_path: Path) -> None:
    (tmp_path / "small.json").write_text(json.dumps(tree()), encoding="utf-8")
    for seed in (1, 2, 3):
        write_run(tmp_path / f"{seed}.csv", run(read(tree()), seed, noise_K=0.3))
    given = ["plan", str(tmp_path / "small.json"), *(str(tmp_path / f"{seed}.csv") for seed in (1, 2, 3))]
    done = CliRunner().invoke(cli, [*given, "--hours", "1", "--out", str(tmp_path / "next.csv")])
    assert done.exit_code == 0, done.output
    assert done.output.startswith("nothing is to be decided: none alone is left")


def test_a_motor_in_still_air_becomes_as_hot_as_its_plan_says(tmp_path: Path) -> None:
    """What a law carries goes with temperature, a planned run takes it as it went with speed: within 2 K here."""
    still = tree()
    casing = still["network"]["paths"][1]
    rest = casing["conductance_W_per_K"]["at_rest"]
    law = {"poly": [1.0e-6, -2.0e-4, 0.017, 0.7]}
    still["network"]["paths"].append(
        {"between": casing["between"], "conductance_W_per_K": {"poly": [0.4 * rest]}, "convection": law}
    )
    casing["conductance_W_per_K"]["at_rest"] = 0.6 * rest
    (tmp_path / "still.json").write_text(json.dumps(still), encoding="utf-8")
    for seed in (1, 2):
        write_run(tmp_path / f"{seed}.csv", run(read(still), seed, noise_K=0.05))
    runs = [tmp_path / "1.csv", tmp_path / "2.csv"]
    made = gen.plan(gen.load(tmp_path / "still.json"), runs, hours=2, limit_degC=70.0)
    made.save(tmp_path / "next.csv")
    ambient = float(np.mean([value for seed in (1, 2) for value in gen.read_run(runs[seed - 1])["ambient_degC"]]))
    time, steps = np.arange(0.0, 7200.0, 5.0), parse_profile(str(tmp_path / "next.csv"))
    pwm = np.array([level for _, level in steps])[np.searchsorted([at for at, _ in steps], time, side="right") - 1]
    met = NetworkSolution(read(still).model).simulate_times(time, pwm, np.full(time.size, ambient))
    said = made.details()["hottest_degC"]
    assert {name: float(values.max()) for name, values in met.items()} == pytest.approx(said, abs=2.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--hours", "0"), "--hours"),
        (("--hours", "48.5"), "--hours"),
        (("--hours", "2", "--limit-degC", "20"), "degC at PWM 0 already"),
        (("--hours", "2", "--max-pwm", "300"), "--max-pwm"),
        (("--hours", "2", "--out", "missing/next.csv"), "missing/next.csv"),
        (("--hours", "2", "--json", "{folder}/short.csv"), "would be overwritten"),
    ],
)
def test_bad_input_is_exit_2_and_writes_nothing(
    options: tuple[str, ...], message: str, folder: Path, tmp_path: Path
) -> None:
    given = [text.format(folder=folder) for text in options]
    command = ["plan", str(folder / "small.json"), str(folder / "short.csv"), "--out", str(tmp_path / "out.csv")]
    done = CliRunner().invoke(cli, [*command, *given])
    assert done.exit_code != 0
    assert message in f"{done.output}{done.exception}"
    assert not list(tmp_path.iterdir())


def test_a_file_of_transfer_functions_is_refused_in_one_line(folder: Path) -> None:
    path = ROOT / "examples" / "my1016" / "coeffs.json"
    with pytest.raises(gen.InputError) as raised:
        gen.plan(gen.load(path), [folder / "short.csv"], hours=2)
    assert str(raised.value) == f"{path}: $.components: holds transfer functions; gen plan needs a network"


def test_an_interruption_leaves_nothing(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(planning, "remaining", interrupted)
    command = ["plan", str(folder / "small.json"), str(folder / "short.csv"), "--hours", "2"]
    done = CliRunner().invoke(cli, [*command, "--out", str(tmp_path / "out.csv"), "--json", str(tmp_path / "out.json")])
    assert done.exit_code != 0
    assert not list(tmp_path.iterdir())


def after(folder: Path, said: str | None, pwm: int | None = None) -> gen.Refinement:
    """Refine with the short run and one that follows the plan, or holds a PWM, and says so or something else."""
    steps = parse_profile(str(folder / "next.csv"))
    time = np.arange(0.0, 7200.0, 5.0)
    at = np.searchsorted([when for when, _ in steps], time, side="right") - 1
    asked = np.array([level for _, level in steps])[at] if pwm is None else np.full(time.size, pwm)
    room = np.full(time.size, AMBIENT)
    temps = NetworkSolution(read(changed()).model).simulate_times(time, asked, room)
    chance = np.random.default_rng(11)
    noisy = {name: values + chance.normal(0.0, 0.05, time.size) for name, values in temps.items()}
    comments = {} if said is None else {EXPECTS: said}
    made = Run(time, asked.astype(np.int64), noisy, room, comments=comments)
    write_run(folder / "planned.csv", made)
    write_run(folder / "test.csv", replace(run(read(changed()), 9), comments={}))
    fit = [folder / "short.csv", folder / "planned.csv"]
    return gen.refine(gen.load(folder / "small.json"), fit=fit, test=[folder / "test.csv"])


def expectation(folder: Path, second: str) -> str:
    holds = Expectation.model_validate_json(carried_comments(str(folder / "next.csv"))[0].partition(": ")[2]).holds
    pair = Pair(first="standstill_cooling", second=second, floors=3.0, separation_K=0.3)
    return Expectation(pairs=(pair,), holds=holds).text()


def test_refine_says_whether_a_planned_run_told_what_it_was_to_tell(planned: Result, folder: Path) -> None:
    assert planned.exit_code == 0
    (told,) = after(folder, expectation(folder, "none")).details()["planned"]
    assert (told["told"], told["remains"]) == (True, ("standstill_cooling",))
    assert told["sentence"].endswith("standstill_cooling remains")
    assert "was to tell standstill_cooling from none by 3.0 noise floors: it did, by " in told["sentence"]
    assert told["found_floors"] > 1.0


@pytest.mark.parametrize(("said", "pwm", "warning"), [("rain", None, "it is no planned run"), (None, 150, "alone")])
def test_what_is_no_planned_run_is_told_and_changes_nothing(
    planned: Result, folder: Path, said: str | None, pwm: int | None, warning: str
) -> None:
    assert planned.exit_code == 0
    found = after(folder, said or expectation(folder, "none"), pwm)
    assert found.details()["planned"] == []
    assert any(warning in text and "planned.csv" in text for text in found.warnings)


def test_how_much_of_a_plan_a_run_followed() -> None:
    expected = Expectation(pairs=(), holds=((100, 60.0), (0, 40.0)))
    time = np.arange(0.0, 101.0, 10.0)
    pwm = np.where(time < 50.0, 100, 0)
    assert followed(expected, Run(time, pwm)) == pytest.approx(0.9)
    assert followed(expected, Run(time[:6], pwm[:6])) == pytest.approx(0.5)


def test_after_its_plan_ended_a_run_follows_nothing() -> None:
    expected = Expectation(pairs=(), holds=((100, 60.0), (0, 40.0)))
    time = np.arange(0.0, 201.0, 10.0)
    assert followed(expected, Run(time, np.where(time < 60.0, 100, 0))) == pytest.approx(1.0)
    assert followed(expected, Run(time, np.where(time < 100.0, 100, 0))) == pytest.approx(0.6)


@pytest.mark.parametrize(
    ("added", "lookalikes", "remains"),
    [
        (None, (), ("none",)),
        ("standstill_cooling", (), ("standstill_cooling",)),
        ("standstill_cooling", ("none",), ("standstill_cooling", "none")),
        ("radiation", (), ()),
    ],
)
def test_what_remains_of_a_pair_is_what_was_found_or_looks_like_it(
    added: str | None, lookalikes: tuple[str, ...], remains: tuple[str, ...]
) -> None:
    def considered(name: str) -> Any:  # noqa: ANN401
        return SimpleNamespace(effect=SimpleNamespace(name=name))

    last = considered(added) if added else None
    step: Any = SimpleNamespace(
        without=None, considered=(), added=last, lookalikes=tuple(considered(name) for name in lookalikes)
    )
    pair = Pair(first="standstill_cooling", second="none", floors=3.0, separation_K=0.3)
    text = Expectation(pairs=(pair,), holds=((100, 60.0),)).text()
    time = np.arange(0.0, 61.0, 10.0)
    traced: Any = SimpleNamespace(steps=(step,))
    (found,), warnings = settled([("planned", Run(time, np.full(7, 100), comments={EXPECTS: text}))], traced)
    assert (found.remains, found.told, warnings) == (remains, len(remains) < 2, [])
