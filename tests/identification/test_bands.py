"""Bands of the general model, against a covariance whose propagation is known in closed form."""

from types import SimpleNamespace
from typing import cast

import numpy as np
from pytest import approx

from gen.identification.parts.bands import COMPARABLE, band
from gen.identification.parts.curves import Shape
from gen.identification.parts.forms import Form
from gen.identification.parts.general import General
from gen.identification.parts.joint import Model
from gen.identification.parts.structure import Structure


def test_bands_come_back_from_parameters_that_hardly_determine_themselves() -> None:
    """Rates and rises at four speeds are independent; exp2 and the numerators hold the same, in odd units."""
    nodes = np.array([51, 110, 180, 255])
    x = nodes / 255.0
    rise, rise_sd, log_sd = np.array([30.0, 50.0, 52.0, 40.0]), np.array([0.1, 0.2, 0.1, 0.3]), 0.01
    a, b, c, d = 6e-3, -2.0, -3e-3, -3.0
    rate = a * np.exp(b * x) + c * np.exp(d * x)
    numerator = rise * rate / nodes
    # Change of the rates and of the numerators with exp2's four parameters, then with logarithm of rate and rise.
    by_parameter = np.stack([np.exp(b * x), a * x * np.exp(b * x), np.exp(d * x), c * x * np.exp(d * x)], axis=1)
    by_rate = np.linalg.solve(by_parameter, np.diag(rate))
    whole = np.block([[by_rate, np.zeros((4, 4))], [np.diag(numerator), np.diag(rate / nodes)]])
    covariance = whole @ np.diag(np.concatenate([np.full(4, log_sd), rise_sd]) ** 2) @ whole.T
    shape = Shape(Structure(1), Form("rate", "exp2"), Form("numerator", "pchip"), nodes, standstill=False)
    model = Model(shape, np.concatenate([[a, b, c, d], numerator]), covariance, 0.0, ())
    at = nodes.astype(np.float64)
    assert model.evaluate(at)[1] == approx(rise)
    assert model.steady_sd(at) == approx(rise_sd, rel=1e-3)
    assert model.theta_sd(at)[:, 0] == approx(np.full(4, log_sd), rel=1e-3)


def test_a_form_counts_by_its_squared_left_out_error() -> None:
    """The spread of the possible forms about the chosen one: at an error half as large again, four ninths."""

    def option(score: float, off_K: float, *, rejected: str = "") -> SimpleNamespace:
        shape = SimpleNamespace(evaluate=lambda _, pwm: (pwm, pwm + off_K))
        return SimpleNamespace(score=score, shape=shape, vector=None, rejected=rejected, left_out=0.0)

    options = [option(1.0, 0.0), option(1.5, 3.0), option(1.0, 90.0, rejected="wiggles"), option(COMPARABLE + 9, 90.0)]
    general = cast(General, SimpleNamespace(options=options, chosen=options[0]))
    model = cast(Model, SimpleNamespace(evaluate=lambda pwm: (pwm, pwm), steady_sd=lambda pwm: 0.0 * pwm))
    found = band(general, model, 50, 255)
    assert found.forms_K == approx(np.sqrt(4.0 / 9.0 * 3.0**2 / (1.0 + 4.0 / 9.0)), rel=2e-3)
    assert found.pwm[[0, -1]].tolist() == [50.0, 255.0]
