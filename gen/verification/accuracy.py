"""The reference simulator's error against the exact solution, over whole runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.lowering.program import Program
from gen.model.exact import ExactSolution
from gen.reference.model import ReferenceModel
from gen.verification.profiles import Integers, campaign

#: A run of 10 800 s at the sample time of 0.25 s.
LENGTH = 43_200
_POINTS = 60


@dataclass(frozen=True)
class ErrorCourse:
    """How large the error becomes along a run.

    Parameters
    ----------
    time_s
        Ends of equal intervals of the run, s, shape (P,).
    error_K
        By component, the largest magnitude of the error within each interval, over all lanes, K, shape (P,).
    """

    time_s: list[float]
    error_K: dict[str, list[float]]

    def largest(self) -> dict[str, float]:
        """Give each component's largest error, K."""
        return {name: max(values) for name, values in self.error_K.items()}


def error_course(program: Program, lanes: int, length: int = LENGTH) -> ErrorCourse:
    """Compare the reference with the exact solution.

    Parameters
    ----------
    program
        What the board holds.
    lanes, length
        Of a campaign whose starts lie inside the declared domain; `length` in samples.
    """
    profile = campaign(program.model, lanes, length, seed=10_800)
    low = max(component.start_range_mK[0] for component in program.components)
    high = min(component.start_range_mK[1] for component in program.components)
    start = np.clip(profile.start_mK, low, high) // 250 * 250  # a quarter of a kelvin is exact in every format
    start = np.where(start < low, start + 250, start)
    names = program.model.component_names
    rise = dict.fromkeys(names, start / 1000.0)
    exact = ExactSolution(program.model).simulate(_in_domain(program, profile.pwm), rise)
    model = ReferenceModel(program, [int(value) for value in start])
    ends = np.linspace(0, length, min(_POINTS, length) + 1).round().astype(int)[1:]
    worst = np.zeros((len(ends), len(names)))
    interval = 0
    for step in range(length):
        model.step(profile.pwm[:, step])
        truth = np.array([exact[name][:, step + 1] for name in names])
        worst[interval] = np.maximum(worst[interval], np.abs(model.rises - truth).max(axis=1))
        interval += step + 1 == ends[interval]
    return ErrorCourse(
        (ends * program.model.sample_time).tolist(),
        {name: worst[:, number].tolist() for number, name in enumerate(names)},
    )


def _in_domain(program: Program, pwm: Integers) -> Integers:
    low, high = program.model.domain_pwm
    clamped: Integers = np.clip(np.abs(pwm), low, high)
    return clamped
