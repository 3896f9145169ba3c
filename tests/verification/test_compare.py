"""What `gen verify` counts and measures: no word is left out, and costs are the worst, not the usual ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen.avr.compile import Sizes
from gen.verification import runners
from gen.verification.accuracy import ErrorCourse, StepErrors
from gen.verification.compare import first_mismatch
from gen.verification.profiles import Profile
from gen.verification.runners import AvrRunner
from gen.verification.verify import CombinationResult, TargetResult, summary, verify
from tests.examples import example

KIND = np.dtype([("a.x1.lo", "<u2"), ("a.x1.hi", "<i4"), ("a.S", "<i4"), ("flags", "u1")])
LANES, LENGTH = 3, 5


@given(st.data())
def test_any_word_that_differs_is_found_and_the_earliest_is_named(data: st.DataObject) -> None:
    expected = np.zeros((LANES, LENGTH), dtype=KIND)
    expected["a.x1.hi"] = np.arange(LANES * LENGTH).reshape(LANES, LENGTH)
    assert first_mismatch(expected, expected.copy()) is None
    places = st.tuples(st.integers(0, LANES - 1), st.integers(0, LENGTH - 1), st.sampled_from(KIND.names or ()))
    wrong = data.draw(st.sets(places, min_size=1, max_size=4))
    found = expected.copy()
    for lane, step, name in wrong:
        found[name][lane, step] += 1
    mismatch = first_mismatch(expected, found)
    assert mismatch is not None
    assert mismatch.differing == len(wrong)
    assert mismatch.step == min(step for _, step, _ in wrong)
    assert (mismatch.lane, mismatch.step, mismatch.field) in wrong
    assert mismatch.found == mismatch.expected + 1


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> AvrRunner:
    """A run of which every figure is known: 400 cycles, but for one sample of each kind."""
    runner: Any = AvrRunner.__new__(AvrRunner)
    runner._elf, runner._empty, runner.stack_bytes = tmp_path / "model", tmp_path / "empty", 37
    sizes = {runner._elf: Sizes(flash=5000, ram=300), runner._empty: Sizes(flash=200, ram=20)}
    monkeypatch.setattr(runners, "sizes", sizes.__getitem__)
    made: AvrRunner = runner
    return made


def test_a_cost_is_the_worst_of_its_kind(measured: AvrRunner) -> None:
    pwm = np.array([[50, 50, 50, 200, 200, -200, 0], [0, 0, 9, 9, 9, 9, 9]])
    measured.cycles = np.full(pwm.shape, 400)
    measured.cycles[0, 2] = 450  # held
    measured.cycles[0, 3] = 1200  # another speed
    measured.cycles[0, 5] = 700  # another direction at the same speed: neither held nor a change of coefficients
    measured.cycles[1, 0] = 1300  # a start
    profile = Profile(pwm, np.zeros(2, dtype=np.int64))
    cost = measured.cost(profile)
    assert cost.cycles_constant == 450
    assert cost.cycles_constant_mean == pytest.approx(400.0 + 50.0 / 8.0, abs=0.06)
    assert cost.cycles_change == 1300
    measured.cycles[1, 0] = 400
    assert measured.cost(profile).cycles_change == 1200
    # Of the model alone: neither the empty program nor the harness's own input record.
    assert (cost.flash_bytes, cost.ram_bytes) == (4800, 280 - profile.records().dtype.itemsize)
    assert cost.stack_bytes == 37


def test_a_rule_that_judges_otherwise_on_the_board_fails_the_verification() -> None:
    def late(files: dict[str, str]) -> dict[str, str]:
        path = next(path for path in files if path.endswith("_alarms.cpp"))
        old = "if (timers->held > rule.persistence) {"
        assert old in files[path]
        return files | {path: files[path].replace(old, "if (timers->held >= rule.persistence) {")}

    options: dict[str, Any] = {"scale": 0.02, "host_builds": ["g++ -O2"]}
    (result,) = verify(example("my1016"), ["fixed"], ["table"], "host", mutation=late, **options)
    assert not result.passed
    differing = [target.target for target in result.targets if target.differing]
    assert len(differing) == 1
    assert "alarms" in differing[0]


def result(differing: int) -> CombinationResult:
    course = ErrorCourse([1.0], {"part": [0.0]})
    steps = StepErrors([51], [0.0, 1.0], {"part": [[0.0, 0.0]]})
    targets = [TargetResult("one", 10, 20, 0), TargetResult("other", 10, 20, differing)]
    return CombinationResult("fixed", "table", targets, {"part": 1e-5}, {"part": 0.0}, course, steps)


def test_one_word_of_one_target_makes_the_whole_different() -> None:
    coefficients = example("my1016")
    assert summary(coefficients, [result(0), result(0)])["verdict"] == "equal"
    found = summary(coefficients, [result(0), result(1), result(0)])
    assert (found["verdict"], found["differing"], found["words"]) == ("different", 1, 120)
