"""Processor time of one sample in each simulator, as a multiple of what the compiled library takes with its pipe."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.rivals.code.ours import told
from benchmarks.rivals.host.process import ROOT, taken
from gen.arrays import IntArray
from gen.coefficients import load
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.model import ExactSolution
from gen.reference.board import reference_of
from gen.verification.profiles import Profile
from gen.verification.runners import HostRunner, write_library

MY1016 = ROOT / "examples" / "my1016" / "coeffs.json"
LANES = 64
ARITHMETICS: tuple[Arithmetic, ...] = ("fixed", "float")


@dataclass(frozen=True)
class Rate:
    """How long a sample takes, as a multiple of the compiled library's."""

    title: str
    multiple: float


def rates(length: int) -> list[Rate]:
    """Time all simulators on random PWM.

    Parameters
    ----------
    length
        Samples of each of `LANES` lanes, and of the one lane; the compiled library runs twenty times as many.
    """
    model = load(MY1016).model
    pwm = np.random.default_rng(7).integers(-255, 256, (LANES, length))
    found: dict[str, float] = {}
    for arithmetic in ARITHMETICS:
        program = lower(load(MY1016), arithmetic, "table")
        found[f"{arithmetic}: emitted library, g++ -O2"] = _library(program, np.tile(pwm, (1, 20)))
        found[f"{arithmetic}: reference, {LANES} lanes at once"] = _reference(program, pwm)
        found[f"{arithmetic}: reference, one lane"] = _reference(program, pwm[:1])
    exact = ExactSolution(model)
    exact.simulate(pwm)  # the exponentials are made
    found[f"exact solution, {LANES} lanes at once"] = taken(lambda: exact.simulate(pwm)) / pwm.size
    unit = found["fixed: emitted library, g++ -O2"]
    return [Rate(title, seconds / unit) for title, seconds in found.items()]


def _library(program: Program, pwm: IntArray) -> float:
    """Processor time of a sample of the compiled library, s."""
    coefficients = load(MY1016)
    context = project_context(coefficients, program, coefficients.name)
    profile = told(program, Profile(pwm, np.zeros(len(pwm), dtype=np.int64)))
    with tempfile.TemporaryDirectory(prefix="rivals-") as folder:
        runner = HostRunner(write_library(program, context, render.library(context), Path(folder)), "g++ -O2")
        return taken(lambda: runner.run(profile)) / profile.samples


def _reference(program: Program, pwm: IntArray) -> float:
    """Processor time of a sample of the reference, s."""
    model = reference_of(program, [0] * len(pwm))

    def run() -> None:
        for step in range(pwm.shape[1]):
            model.step(pwm[:, step])

    return taken(run) / pwm.size
