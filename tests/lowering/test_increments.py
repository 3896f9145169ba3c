"""The increment form against the poles it must have and the differential equation it must follow."""

from __future__ import annotations

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.lowering.recursion import increments
from gen.lowering.recursion.dynamics import domain_rows
from gen.lowering.recursion.series import delta_series, weight
from gen.model.exact import ExactSolution
from tests.examples import example

SAMPLE_TIME = 0.25
POLES: dict[int, list[complex]] = {
    1: [-0.01],
    2: [-0.003 + 0.004j, -0.003 - 0.004j],
    3: [-0.0039, -0.0022, -0.0005],
    4: [-0.02, -0.0035 + 0.002j, -0.0035 - 0.002j, -0.0004],
}


def polynomial(order: int) -> FloatArray:
    return np.asarray(np.real(np.poly(POLES[order])), dtype=np.float64)


@pytest.mark.parametrize("order", POLES)
def test_the_discrete_poles_are_exact(order: int) -> None:
    denominator = polynomial(order)[None, :]
    b = increments.delta_polynomial(denominator, SAMPLE_TIME)
    form = increments.transition(increments.feedback(b))[0]
    found = np.sort_complex(np.linalg.eigvals(form))
    wanted = np.sort_complex(np.exp(np.array(POLES[order]) * SAMPLE_TIME))
    # Eigenvalues of a matrix this close to a Jordan block carry some 1e-16^(1/n) of their own error.
    assert np.abs(found - wanted).max() < 1e-9
    assert np.allclose(np.poly(np.exp(np.array(POLES[order]) * SAMPLE_TIME) - 1.0)[1:].real, b[0], rtol=1e-9)


@pytest.mark.parametrize("order", POLES)
def test_the_nested_rates_invert(order: int) -> None:
    b = increments.delta_polynomial(polynomial(order)[None, :], SAMPLE_TIME)
    c = increments.feedback(b)
    assert np.allclose(increments.from_rates(increments.rates(c)), c, rtol=1e-14)


@pytest.mark.parametrize("order", POLES)
def test_the_series_converges_to_the_delta_polynomial(order: int) -> None:
    denominator = polynomial(order)
    alpha = [denominator[k] * SAMPLE_TIME**k for k in range(1, order + 1)]
    exact = increments.delta_polynomial(denominator[None, :], SAMPLE_TIME)[0]
    for k, series in enumerate(delta_series(order, 4)):
        assert all(k + 1 <= weight(exponents) <= k + 5 for exponents in series)
        value = sum(float(f) * np.prod([a**e for a, e in zip(alpha, m, strict=True)]) for m, f in series.items())
        assert value == pytest.approx(exact[k], rel=1e-9)


@pytest.mark.parametrize(("name", "substeps"), [("my1016", 1), ("my1016_averaged", 1), ("two_mass", 4)])
def test_the_form_follows_the_differential_equation_through_any_switching(name: str, substeps: int) -> None:
    """In float64 and with the carry, a new random PWM at every sample leaves some 1e-7 K."""
    model = example(name).model
    pwm = np.random.default_rng(5).integers(0, model.full_scale + 1, 20_000)
    exact = ExactSolution(model).simulate(pwm)
    rows = domain_rows(model)
    for component in model.components:
        b = increments.delta_polynomial(component.denominator(rows), model.sample_time / substeps)
        c = increments.feedback(b)
        form = increments.transition(c)
        steady = component.steady_rise(rows)
        n = component.order
        x = np.zeros(n)
        offset = np.zeros(n)
        worst = 0.0
        for step, now in enumerate(pwm):
            offset[0] = steady[now]
            if n > 1:
                previous = 0.0 if step == 0 else -c[pwm[step - 1]] @ (x - steady[pwm[step - 1]] * np.eye(n)[0])
                q = -c[now] @ (x - offset)
                x[n - 2] += (q - previous) * increments.CARRY
            for _ in range(substeps):
                x = form[now] @ (x - offset) + offset
            worst = max(worst, abs(x[0] - exact[component.name][step + 1]))
        assert worst < 3e-6, component.name
