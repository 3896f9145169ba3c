"""What runs cannot tell is said, with the run to log; what they can tell is not asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.coefficients import load
from gen.refinement.condense import condense
from gen.refinement.parts.excitation import excitation
from gen.runs import Run, write_run
from tests.refinement.plant import COEFFICIENTS, NAMES


@pytest.mark.parametrize(("pwm", "one_direction"), [((200, 120), True), ((-200, -120), False), ((200, -200), False)])
def test_a_second_direction_is_asked_for_where_no_run_turns_in_reverse(
    tmp_path: Path, pwm: tuple[int, int], *, one_direction: bool
) -> None:
    coefficients = load(COEFFICIENTS)
    time = np.arange(0.0, 7200.0, 5.0)
    temps = {name: np.full(time.size, 40.0) for name in NAMES}
    write_run(tmp_path / "run.csv", Run(time, np.where(time < 3600.0, *pwm), temps, np.full(time.size, 30.0)))
    found = excitation(coefficients, [condense(coefficients, tmp_path / "run.csv")])
    assert any("one direction" in sentence for sentence in found.missing) == one_direction
    assert dict(found.facts)["hours in reverse"] == f"{sum(level < 0 for level in pwm):.1f}"
