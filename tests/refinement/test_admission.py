"""Which runs may teach a model, by their own comments."""

from __future__ import annotations

import numpy as np
import pytest

from gen.errors import InputError
from gen.refinement.admission import healthy
from gen.runs import Run


def run(**comments: str) -> Run:
    return Run(np.array([0.0, 1.0]), np.array([0, 0]), comments=comments)


@pytest.mark.parametrize(
    ("comments", "kept"),
    [
        ({}, True),
        ({"fault": "none"}, True),
        ({"motor_fault": "none"}, True),
        ({"healthy": "yes", "fault": "-"}, True),
        ({"fault": "bearing"}, False),
        ({"motor_fault": "heat:brush=+20%"}, False),
        ({"fault": "none", "motor_fault": "brush"}, False),
        ({"healthy": "no"}, False),
    ],
)
def test_a_run_that_names_a_fault_is_left_out(comments: dict[str, str], kept: bool) -> None:
    sound = ("sound", run())
    found, warnings = healthy([sound, ("asked", run(**comments))])
    assert [name for name, _ in found] == (["sound", "asked"] if kept else ["sound"])
    assert len(warnings) == (0 if kept else 1)


def test_nothing_is_left() -> None:
    with pytest.raises(InputError, match="all of them name a fault"):
        healthy([("one", run(motor_fault="bearing"))])
