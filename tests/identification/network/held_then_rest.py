"""Two parts from cold: PWM held, then rest."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.bins import binned
from gen.identification.network.fitting.inputs import inputs_of
from gen.identification.network.fitting.priors import prior_of
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.structure import Structure
from gen.runs import Run

NAMES = ("a", "b")


def problem_of(structure: Structure, pwm: int, hours: float, ambient: float) -> Problem[Structure]:
    """Give the problem of one run, half of it driven; its readings say nothing."""
    time = 10.0 * np.arange(round(360.0 * hours), dtype=np.float64)
    temps = dict.fromkeys(NAMES, np.full(time.size, ambient))
    run = Run(time, np.where(time < 0.5 * time[-1], pwm, 0), temps)
    inputs = inputs_of([binned("r", run, NAMES, ambient, 255)])
    return Problem(structure, inputs, prior_of(structure, inputs, Scale(np.full(2, 1500.0), np.full(2, 40.0))))


def numbers_about_the_prior(problem: Problem[Structure]) -> FloatArray:
    """Give parameters near the prior's, and starts at the ambient, shape (P,)."""
    vector = problem.prior.mean + np.random.default_rng(4).normal(0.0, 0.2, problem.size)
    vector[problem.structure.size :] = 0.0
    return np.asarray(vector)
