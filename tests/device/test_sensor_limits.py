"""The sensor checks at their limits: the ends of the physical range, and reach that does not fit 16 bits."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gen.coefficients import parse
from tests.device.sensor_harness import Cpp, Judged, Step, by_reference, word
from tests.device.variants import BASE

OK, RANGE, JUMP, UNCONFIRMED = 0, 4, 5, 8
LOWEST, HIGHEST, STEP = 40, 800, 64  # counts of 0.25 K: 10 degC, 200 degC, 16 K in a quarter of a second
BRUSH = 0


@pytest.fixture(scope="module")
def cpp(tmp_path_factory: pytest.TempPathFactory) -> Cpp:
    tree = json.loads(json.dumps(BASE))
    for chip in tree["wiring"]["thermocouples"]:
        chip |= {"min_degC": 10.0, "max_degC": 200.0, "max_rate_K_per_s": 64.0}
    made = Cpp(tmp_path_factory.mktemp("limits"), parse(json.dumps(tree).encode()))
    assert [(limits.lowest, limits.highest, limits.step) for limits in made.limits] == [(LOWEST, HIGHEST, STEP)] * 5
    return made


def samples(*counts: int) -> list[Step]:
    return [(BRUSH, word(item), True, 0) for item in counts]


def codes(found: list[Judged]) -> list[int]:
    return [code for code, *_ in found]


def test_both_ends_of_the_range_are_in_it(cpp: Cpp) -> None:
    at_lowest = samples(*[LOWEST] * 4, LOWEST - 1, *[LOWEST] * 4)
    assert codes(cpp.run(at_lowest)) == [8, 8, 8, OK, RANGE, 8, 8, 8, OK]
    at_highest = samples(*[HIGHEST] * 4, HIGHEST + 1, *[HIGHEST] * 4)
    assert codes(cpp.run(at_highest)) == [8, 8, 8, OK, RANGE, 8, 8, 8, OK]


@pytest.mark.parametrize("apart", [4 + STEP, -(4 + STEP)])
def test_a_change_of_just_the_rate_and_the_noise_is_no_jump(cpp: Cpp, apart: int) -> None:
    """16 K and one of noise in a sample; a count more is."""
    farther = apart + (1 if apart > 0 else -1)
    assert codes(cpp.run(samples(*[400] * 4, 400 + apart)))[-1] == OK
    assert codes(cpp.run(samples(*[400] * 4, 400 + farther)))[-1] == JUMP


@pytest.mark.parametrize("waited", [1020, 1024, 1030, 2048])
def test_after_a_long_gap_any_level_is_within_reach_on_the_board_too(cpp: Cpp, waited: int, tmp_path: Path) -> None:
    """64 counts times 1024 samples is 0 in the board's 16 bits: the sensor would have jumped by its first kelvin."""
    gap: list[Step] = [(BRUSH, word(400), False, 0)] * waited
    steps = [*samples(*[400] * 4), *gap, *samples(*[600] * 4)]
    for found in (cpp.run(steps), cpp.run_on_board(steps)[0], by_reference(cpp.limits, steps)):
        assert codes(found)[-4:] == [JUMP, UNCONFIRMED, UNCONFIRMED, OK]
