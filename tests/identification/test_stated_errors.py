"""What the coefficient file says that its model is off by: thresholds are counted from it, so its side matters."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gen.identification.logs.records import condense
from gen.identification.parts.bands import Band
from gen.identification.parts.coefficient_file import error_bands, measured_error
from gen.identification.parts.identify import Identified


def identified(unknown_K: float) -> Identified:
    """Runs at PWM 60 and 200 that read 0.5 K over and 1 K under the model; in between the model is a guess."""
    time = np.arange(0.0, 6000.0, 2.0)
    records = [condense("run", time, np.full(time.size, pwm), 40.0 + 0.0 * time, 30.0) for pwm in (60, 200)]
    kept = [record for record in records if record is not None]
    residuals = [np.full(record.time.size, over) for record, over in zip(kept, (0.5, -1.0), strict=True)]
    pwm = np.arange(1.0, 256.0)
    between = np.where((pwm > 60) & (pwm < 200), unknown_K, 0.0)
    made = SimpleNamespace(
        problem=SimpleNamespace(records=kept),
        model=SimpleNamespace(residuals=residuals, offset_K=0.0),
        general=SimpleNamespace(chosen=SimpleNamespace(left_out=None)),
        band=Band(pwm, np.zeros(255), between, np.zeros(255)),
        speeds=[60, 200],
        range=(60, 200),
        standstill=False,
        held=True,
    )
    return cast(Identified, made)


@pytest.mark.parametrize(("pwm", "error_K"), [(60, -0.5), (200, 1.0)])
def test_a_part_that_reads_over_the_model_has_a_model_under_it(pwm: int, error_K: float) -> None:
    assert measured_error(identified(0.0), pwm) == pytest.approx((error_K, error_K))


def test_bands_meet_in_the_middle_and_are_wider_by_what_nobody_measured() -> None:
    """Two standard deviations of what is unknown around each speed, to both sides."""
    for unknown_K in (0.0, 0.3):
        bands = error_bands("part", identified(unknown_K))
        assert [band.pwm for band in bands] == [(60, 129), (130, 200)]
        for band, error_K in zip(bands, (-0.5, 1.0), strict=True):
            wanted = [error_K - 2.0 * unknown_K, error_K + 2.0 * unknown_K]
            assert band.model_minus_measured_K == pytest.approx(wanted, abs=1e-3)
