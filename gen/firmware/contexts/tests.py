"""What the templates of the emitted project's own tests are told."""

from __future__ import annotations

from typing import TypedDict

from gen.firmware.vectors import Vectors, reference_vectors
from gen.lowering.program import Program


class TestsContext(TypedDict):
    """Reference vectors, a PWM to run at in both directions, and a start (in mK) that is read back."""

    vectors: Vectors
    probe: int
    start_probe: int


def tests_context(program: Program) -> TestsContext:
    """What the tests of a program's project need."""
    model = program.model
    low, high = model.domain_temperature
    rise = (low - model.domain_ambient[1], high - model.domain_ambient[0])
    return {
        "vectors": reference_vectors(program),
        "probe": min(model.domain_pwm[1], max(model.domain_pwm[0], model.full_scale // 2)),
        "start_probe": int(min(max(20_250, rise[0] * 1000), rise[1] * 1000)) // 250 * 250,
    }
