"""The reference's networks against the exact solution: errors stay below what is guaranteed."""

from __future__ import annotations

import numpy as np
import pytest

from gen.lowering.kinds import Arithmetic
from gen.lowering.network.lower import lower_network
from gen.model.network_solution import NetworkSolution
from gen.reference.network import ReferenceNetwork
from tests.examples import example

LANES, SAMPLES = 6, 400


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_a_networks_words_stay_within_the_guaranteed_bound_of_the_exact_solution(arithmetic: Arithmetic) -> None:
    coefficients = example("network")
    model = coefficients.model
    assert model.network is not None
    program, exact = lower_network(coefficients, arithmetic), NetworkSolution(model)
    rng = np.random.default_rng(5)
    holds = [1, 2, 7, 50, 200, 400]
    pwm = np.stack([np.repeat(rng.integers(-255, 256, SAMPLES // hold + 1), hold)[:SAMPLES] for hold in holds])
    told = np.stack(
        [
            np.stack(
                [np.repeat(rng.integers(c.low, c.high + 1, SAMPLES // hold + 2), hold)[: SAMPLES + 1] for hold in holds]
            )
            for c in program.channels
        ]
    )
    starts = {reading.name: rng.integers(-5000, 60_000, LANES).tolist() for reading in program.readings}
    board = ReferenceNetwork(program, model.domain_pwm, model.validity, starts, told[:, :, 0])
    low, high = program.start_mC
    given = {name: np.clip(np.asarray(rise) + told[0, :, 0], low, high) / 1000.0 for name, rise in starts.items()}
    state = exact.start(given, told[0, :, 0] / 1000.0)
    bounds = np.array([part.proof.bound_K for part in program.components()])
    largest = 0.0
    for k in range(SAMPLES):
        now = told[:, :, k + 1]
        board.set_channels(now)
        board.step(pwm[:, k])
        columns = {c.column: now[i + 1] / 1000.0 for i, c in enumerate(model.network.channels)}
        step = exact.steps(np.abs(pwm[:, k]), np.full(LANES, model.sample_time), columns)
        state = (
            state
            + np.einsum("lij,lj->li", step.increment, state)
            + step.ambient * (now[0] / 1000.0)[:, None]
            + step.heat
        )
        shown = np.array(list(exact.shown(state, now[0] / 1000.0).values()))
        error = np.abs(board.readings - shown).max(axis=1)
        assert (error <= bounds).all()
        largest = max(largest, float(error.max()))
    assert largest < 3e-6  # the guarantee is for the worst case
