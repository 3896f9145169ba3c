"""What is called good of transfer functions, part by part."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gen.identification.parts.identify import Identified
from gen.identification.parts.summary import verdict


def part(error_K: float, left_out_K: float = 0.1) -> dict[str, Identified]:
    """A casing that rises by 40 K at three speeds, every run settled, with so much error in its own runs."""
    record = SimpleNamespace(raw_rise=np.array([0.0, 40.0]), noise_K=0.1, quantum_K=0.25)
    chosen = SimpleNamespace(rejected=(), left_out=object(), score=left_out_K)
    item = SimpleNamespace(
        name="casing",
        speeds=[50, 150, 250],
        settled={50: 0.99, 150: 0.99, 250: 0.99},
        choice=SimpleNamespace(chosen=SimpleNamespace(rejected=())),
        general=SimpleNamespace(chosen=chosen),
        problem=SimpleNamespace(records=(record,)),
        tests={"run": SimpleNamespace(rms_K=error_K)},
    )
    return {"casing": cast(Identified, item)}


@pytest.mark.parametrize(
    ("error_K", "begins"),
    [
        (0.1, "Good: every run settled"),
        (2.4, "Fair: in the runs that it was fitted to it misses casing by 2.4 K (6% of what it moves by, 2"),
        (5.5, "Not good yet: in the runs that it was fitted to it misses casing by 5.5 K (14% of"),
    ],
)
def test_parts_are_graded_by_what_they_miss_of_their_own_runs(error_K: float, begins: str) -> None:
    assert verdict(part(error_K)).startswith(begins)


def test_what_a_left_out_speed_is_missed_by_is_told() -> None:
    said = verdict(part(0.1, 2.4))
    assert said == "Good at the measured speeds; speeds that were left out it misses, casing by 2.4 K."
