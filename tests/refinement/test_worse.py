"""What makes runs worse that took no part is said plainly, and the model stays as it was."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import gen
from gen.cli import main
from gen.refinement.errors import Errors
from gen.refinement.run_errors import Score
from gen.refinement.worse import got_worse, lowered, spoiled, told_worse
from tests.refinement.network.motor import read, run, tree, write


def of(*rmse_K: float) -> Errors:
    return Errors(test={f"run_{k}.csv": {"winding": Score(100 * r**2, 100, 2 * r)} for k, r in enumerate(rmse_K)})


@pytest.mark.parametrize(
    ("before", "after", "worse"),
    [(0.5, 0.6, True), (0.5, 0.52, False), (0.1, 0.11, False), (2.0, 1.0, False), (2.0, 2.2, True)],
)
def test_worse_is_by_a_share_and_by_what_a_sensor_tells(before: float, after: float, worse: bool) -> None:
    assert got_worse(of(before), of(after)) is worse
    said = told_worse(of(before), of(after))
    assert bool(said) is worse
    if worse:
        assert f"the test runs are missed by {after:.3g} K, before by {before:.3g} K" in said[0]


def test_one_test_run_that_got_worse_beside_better_ones_is_named() -> None:
    before, after = of(2.0, 0.5), of(0.4, 0.7)
    assert not got_worse(before, after)
    assert [said.split(":")[0] for said in told_worse(before, after)] == ["run_1.csv"]


@pytest.mark.parametrize(
    ("before", "after", "torn"),
    [
        ((0.1, 2.0), (0.5, 1.0), True),  # one run was explained, and is not any more
        ((0.1, 2.0), (0.13, 0.3), False),  # a little, which the noise of 0.1 K hides
        ((0.5, 2.0), (0.9, 0.5), False),  # was not explained before
        ((0.04, 2.0), (0.12, 0.1), False),  # less than noise before, about noise after
        ((0.1, 0.1), (0.1, 0.1), False),
    ],
)
def test_runs_that_the_file_explains_must_not_pay_for_others(
    before: tuple[float, ...], after: tuple[float, ...], torn: bool
) -> None:
    def fitted(rmse_K: tuple[float, ...]) -> Errors:
        return Errors(fit=of(*rmse_K).test)

    said = spoiled(fitted(before), fitted(after), noise_K=0.1)
    assert bool(said) is torn
    if torn:
        assert said[0].startswith("run_0.csv: explained by the file as it is, and missed by up to 5 times as much")
        assert "run_1.csv" in said[0]


def test_what_makes_test_runs_worse_explains_nothing() -> None:
    assert [lowered(v) for v in ("explained", "nothing missing", "unexplained")] == [
        "partly explained",
        "unexplained",
        "unexplained",
    ]


def given(folder: Path) -> list[str]:
    """Runs to fit of a motor that cools better at rest than its file says, a run to test of one that does not."""
    changed = tree()
    changed["network"]["paths"][1]["conductance_W_per_K"]["at_rest"] = 0.5
    (folder / "small.json").write_text(json.dumps(tree()), encoding="utf-8")
    for seed, motor in ((1, changed), (2, changed), (3, tree())):
        write(run(read(motor), seed), folder / f"run_{seed}.csv")
    names = ["--fit", "run_1.csv", "run_2.csv", "--test", "run_3.csv", "--out", "out.json"]
    return ["refine", "small.json", *names, "--json", "summary.json", "--report", "report.html"]


@pytest.fixture
def called(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.chdir(tmp_path)
    return given(tmp_path)


def status(monkeypatch: pytest.MonkeyPatch, arguments: list[str]) -> int:
    monkeypatch.setattr("sys.argv", ["gen", *arguments])
    try:
        main()
    except SystemExit as ended:
        return int(ended.code or 0)
    return 0


def test_the_command_says_so_and_writes_the_model_as_it_was(
    called: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status(monkeypatch, called) == 0
    told = capsys.readouterr()
    assert "verdict: partly explained" in told.out
    assert "with what was found the test runs are missed by" in told.err
    assert told.out.splitlines()[-1] == "out.json: the model as it was; what was found makes the test runs worse"
    assert (tmp_path / "out.json").read_bytes() == (tmp_path / "small.json").read_bytes()
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["tests_worse"] is True
    assert summary["after"]["test"]["rmse_K"] > 1.05 * summary["before"]["test"]["rmse_K"]
    assert "the test runs are missed by more than before" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_accepted_as_a_change_it_is_written_and_still_said(
    called: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status(monkeypatch, [*called, "--accept-change"]) == 0
    assert "with what was found the test runs are missed by" in capsys.readouterr().err
    assert gen.load(tmp_path / "out.json").text != gen.load(tmp_path / "small.json").text
