"""What is recorded of the tests: who runs a line, and that nothing is waited for that no trial would choose."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from benchmarks.mutants.defects import Mutant
from benchmarks.mutants.nearest import nearest, recorded
from tests.examples import ROOT

TESTS = """
import time

import numpy as np
import pytest

from gen.interruption import EXIT_STATUS
from gen.model.schedules import Polynomial


@pytest.fixture(scope="module")
def line() -> object:
    return Polynomial((2.0, 1.0))(np.ones(1))


def test_first(line: object) -> None:
    assert line == 3.0


def test_second(line: object) -> None:
    assert line == 3.0


def test_other() -> None:
    assert EXIT_STATUS


def test_slow() -> None:
    time.sleep(60.0)


@pytest.mark.parametrize("case", range(9))
def test_cases(case: int) -> None:
    assert case < 9
"""


def test_a_line_belongs_to_the_tests_that_need_it_and_slow_ones_are_left_out(tmp_path: Path) -> None:
    (tmp_path / "test_lines.py").write_text(TESTS)
    target = tmp_path / "made" / "map.json"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "benchmarks.mutants.recording"]
    command += ["--mutants-map", str(target), "--mutants-test", "0.5", "--mutants-cases", "2", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    found = recorded(target.parent)
    names = {test.rpartition("::")[2]: test for test in found.seconds}
    assert set(names) == {"test_first", "test_second", "test_other", "test_cases[0]", "test_cases[1]"}
    lines = found.lines["gen/model/schedules.py"]
    run = next(line for line, tests in lines.items() if tests)
    mutant = Mutant("gen/model/schedules.py", run, "", "", "", "")
    assert set(nearest(mutant, found, ROOT, 10.0)) == {names["test_first"], names["test_second"]}
