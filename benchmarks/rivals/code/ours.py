"""The emitted library, measured as the rivals are."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from benchmarks.rivals.code.row import Row, errors
from gen.coefficients import Coefficients
from gen.emulate.firmware import cache_folder
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.reference.board import record_type, reference_of
from gen.verification.profiles import Profile
from gen.verification.runners import AvrRunner, write_library

FORMS = ("fixed/table", "fixed/onboard", "float/table", "float/onboard")
LACKS = {
    "fixed/table": "small flash",
    "fixed/onboard": "fast changes of PWM",
    "float/table": "speed",
    "float/onboard": "fast changes of PWM",
}


def our_row(form: str, coefficients: Coefficients, profile: Profile, exact: dict[str, Any]) -> Row:
    """Measure one form: its error is the reference's, whose every word is compared with the board's."""
    arithmetic, schedule = form.split("/")
    program = lower(coefficients, cast(Arithmetic, arithmetic), cast(ScheduleKind, schedule))
    context = project_context(coefficients, program, coefficients.name)
    with tempfile.TemporaryDirectory(prefix="rival-") as name:
        folder = Path(name)
        runner = AvrRunner(write_library(program, context, render.library(context), folder), cache_folder())
        profile = told(program, profile)
        found = runner.run(profile)
        cost = runner.cost(profile)
    expected, rises = reference(program, profile)
    bounds = [part.proof.bound_K for part in program.parts if part.proof]
    return Row(
        f"**gen {form}**",
        LACKS[form],
        errors(rises, exact),
        max(bounds) if len(bounds) == len(program.parts) else None,
        cost.cycles_constant,
        cost.cycles_change,
        cost.flash_bytes,
        cost.ram_bytes,
        cost.stack_bytes,
        all(np.array_equal(expected[word], found[word]) for word in expected.dtype.names or ()),
    )


def told(program: Program, profile: Profile) -> Profile:
    """Give the profile with every channel of the program at its neutral value."""
    if not program.channels:
        return profile
    lanes, length = profile.pwm.shape
    neutral = np.array([channel.neutral for channel in program.channels], dtype=np.int64)
    return replace(profile, channels=np.broadcast_to(neutral, (lanes, length + 1, len(neutral))))


def reference(program: Program, profile: Profile) -> tuple[Any, Any]:
    """Run the reference: its records, shape (L, N), and its rises in K, shape (L, N, components)."""
    channels = None if profile.channels is None else profile.channels[:, 0].T
    model = reference_of(program, [int(start) for start in profile.start_mK], channels)
    records = np.zeros(profile.pwm.shape, dtype=record_type(program))
    rises = np.zeros((*profile.pwm.shape, len(program.parts)))
    for step in range(profile.pwm.shape[1]):
        model.step(profile.pwm[:, step])
        records[:, step] = model.record()
        rises[:, step] = model.rises.T
    return records, rises
