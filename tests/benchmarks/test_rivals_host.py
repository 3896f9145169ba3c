"""What the tools cost on this computer: what is counted, not how much it is."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from benchmarks.rivals.host import work
from benchmarks.rivals.host.commands import COMMANDS, Start
from benchmarks.rivals.host.process import process
from benchmarks.rivals.host.runs import write_runs
from benchmarks.rivals.host.simulators import Rate
from benchmarks.rivals.host.table import rates_table, starts_table, work_table
from benchmarks.rivals.host.work import Work, worked
from gen.cli import cli
from gen.errors import CheckFailed
from gen.runs import read_run


def test_a_process_is_told_with_its_own_memory() -> None:
    seconds, small = process([sys.executable, "-c", "pass"], 1)
    _, large = process([sys.executable, "-c", "held = bytearray(100 * 2**20)"], 1)
    assert seconds > 0.0
    assert 95.0 < large - small < 110.0


def test_a_process_that_fails_is_no_figure() -> None:
    with pytest.raises(CheckFailed, match="ends with 3"):
        process([sys.executable, "-c", "raise SystemExit(3)"], 1)


def test_tables_have_multiples_and_memory() -> None:
    (cells,) = zip(*(column.cells for column in rates_table([Rate("reference", 15.31)]).columns), strict=True)
    assert cells == ("reference", "x 15.3")
    (cells,) = zip(*(column.cells for column in starts_table([Start("gen build", 12.4, 99.6)]).columns), strict=True)
    assert cells == ("`gen build`", "x 12", "100 MB")


def test_every_command_is_started() -> None:
    assert set(COMMANDS) == set(cli.commands)


def test_a_shorter_run_is_the_beginning_of_a_longer_one_and_all_are_as_long_as_asked_for(tmp_path: Path) -> None:
    short = [read_run(path) for path in write_runs(tmp_path / "short", "run", 3, 0.5)]
    (long, *_) = [read_run(path) for path in write_runs(tmp_path / "long", "run", 1, 1.0)]
    assert [run.time_s[-1] for run in short] == [1800.0] * 3
    assert long.time_s[-1] == 3600.0 and len(long.temps) == 4
    assert np.array_equal(short[0].pwm[:-1], long.pwm[: len(short[0].pwm) - 1])
    assert not np.array_equal(short[0].pwm, short[1].pwm)


def test_a_dusty_motor_gets_warmer_from_the_same_drive(tmp_path: Path) -> None:
    (clean,), (dusty,) = (write_runs(tmp_path / str(worse), "run", 1, 1.0, dusty=worse) for worse in (False, True))
    before, after = read_run(clean), read_run(dusty)
    assert np.array_equal(before.pwm, after.pwm)
    assert max(after.temps[name][-1] - before.temps[name][-1] for name in before.temps) > 1.0


def test_refinement_gets_as_many_runs_as_identification_and_the_same_model_for_all_sizes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[list[str]] = []

    def noted(command: Sequence[str], tries: int) -> tuple[float, float]:
        words = list(command[3:])
        out = Path(words[words.index("--out") + 1])
        out.write_text(f"model {len(asked)}")
        if words[0] == "refine":
            assert all(Path(word).exists() for word in words if word.endswith(".csv"))
            asked.append([Path(words[1]).read_text(), *(Path(word).parts[-2:][0] for word in words[3:5])])
        return float(len(words)), 50.0

    monkeypatch.setattr(work, "process", noted)
    found = worked([(2, 0.1), (3, 0.1)], ["parts", "network"], lambda _: None)
    assert [(one.command, one.kind, one.runs, one.hours) for one in found] == [
        (command, kind, runs, 0.1)
        for command in ("identify", "refine")
        for kind in ("parts", "network")
        for runs in (2, 3)
    ]
    assert asked[0] == ["model 0", "2x0.1", "2x0.1"]
    assert asked[2] == ["model 0", "3x0.1", "3x0.1"]
    assert asked[1][0] == asked[3][0] == "model 1"


def test_work_is_told_as_multiples_of_the_first_row_and_for_each_hour_of_runs() -> None:
    found = [Work("identify", "parts", 2, 1.0, 10.0, 99.6), Work("refine", "network", 6, 2.0, 30.0, 150.0)]
    rows = list(zip(*(column.cells for column in work_table(found).columns), strict=True))
    assert rows == [
        ("`gen identify`, parts", "2", "1 h", "x 1.00", "x 1.00", "100 MB"),
        ("`gen refine`, network", "6", "2 h", "x 3.00", "x 0.50", "150 MB"),
    ]
