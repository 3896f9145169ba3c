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
    low = max(part.start_range_mK[0] for part in program.parts)
    high = min(part.start_range_mK[1] for part in program.parts)
    return {
        "vectors": reference_vectors(program),
        "probe": min(model.domain_pwm[1], max(model.domain_pwm[0], model.full_scale // 2)),
        "start_probe": min(max(20_250, low), high) // 250 * 250,
    }
