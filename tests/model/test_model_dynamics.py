"""Components and the model: against the study's numbers, extended precision and python-control."""

from dataclasses import replace

import control
import numpy as np
import pytest

from gen.model import Component, ExponentialSum, Pole, Polynomial
from tests.model.examples import NAMES, model
from tests.model.published import AVERAGED

COUNTS = np.arange(256)


def test_brush_denominator_is_real_part_of_poly() -> None:
    """Extended precision, with the schedules written out again."""
    x = COUNTS.astype(np.longdouble)

    def exp2(a: float, b: float, c: float, d: float) -> np.ndarray:
        a_, b_, c_, d_ = (np.longdouble(v) for v in (a, b, c, d))
        return np.asarray(a_ * np.exp(b_ * x) + c_ * np.exp(d_ * x))

    def poly(*p: float) -> np.ndarray:
        return np.asarray(np.polyval(np.array(p, dtype=np.longdouble), x))

    p1 = exp2(0.0005619, 0.01276, -0.001848, 0.00903) + 1j * poly(-1.969e-07, 4.718e-05, 0.0007725)
    p2 = exp2(0.0006881, 0.01372, -0.002001, 0.009904) + 1j * poly(1.969e-07, -4.718e-05, -0.0007725)
    p3 = poly(1.289e-08, -4.812e-06, -0.0001109)
    oracle = np.stack([np.ones_like(x), -(p1 + p2 + p3), p1 * p2 + (p1 + p2) * p3, -p1 * p2 * p3], axis=1)
    brush = model("my1016").component("brush")
    assert np.max(np.abs(brush.denominator(COUNTS) / oracle.real - 1)) < 4e-16
    dropped = brush.dropped_imaginary(COUNTS)
    assert np.max(np.abs(dropped - oracle.imag) / oracle.real) < 1e-17
    assert 0.06 < np.max(np.abs(dropped) / brush.denominator(COUNTS)) < 0.07


@pytest.mark.parametrize("name", AVERAGED)
def test_averaged_model_has_the_printed_coefficients(name: str) -> None:
    numerator, denominator = AVERAGED[name]
    component = model("my1016_averaged").component(name)
    assert np.max(np.abs(component.denominator([0, 130, 255]) / np.array(denominator) - 1)) < 1e-14
    assert set(component.effective_gain(COUNTS)) == {numerator}


def test_negative_gain_is_zero_outside_the_validity_range_only() -> None:
    brush = model("my1016").component("brush")
    assert np.flatnonzero(brush.raw_gain(COUNTS) < 0).tolist() == [0, 1, 2]
    assert brush.effective_gain([0, 1, 2]).tolist() == [0.0, 0.0, 0.0]
    assert np.array_equal(brush.effective_gain(COUNTS[3:]), brush.raw_gain(COUNTS[3:]))
    untreated = replace(brush, negative_gain=None)
    assert (untreated.effective_gain([1]) < 0).all()


def test_negative_gain_is_zero_above_the_validity_range_as_below_it() -> None:
    falling = replace(
        model("my1016").component("bearing"),
        gain=Polynomial((-1e-6, 2.2e-4)),
        validity=(51, 210),
        negative_gain="zero",
    )
    assert falling.raw_gain([221])[0] < 0.0
    assert falling.effective_gain([221, 255]).tolist() == [0.0, 0.0]
    assert falling.effective_gain([219])[0] == falling.raw_gain([219])[0] > 0.0


def test_hold_keeps_gain_and_poles_but_not_the_input() -> None:
    component = replace(model("my1016").component("bearing"), outside="hold")
    assert np.array_equal(component.denominator([0, 50]), component.denominator([51, 51]))
    assert component.effective_gain([7])[0] == component.effective_gain([51])[0]
    assert component.steady_rise([17])[0] == pytest.approx(component.steady_rise([51])[0] / 3, rel=1e-15)


@pytest.mark.parametrize("example", NAMES)
def test_state_matrices_are_those_of_the_transfer_function(example: str) -> None:
    thermal = model(example)
    for component in thermal.components:
        a, b = component.state_matrices(COUNTS)
        assert a.shape == (256, component.order, component.order)
        assert b.shape == (256, component.order)
        rise = np.linalg.solve(a[1:], -b[1:, :, None] * COUNTS[1:, None, None])[:, 0, 0]
        assert rise == pytest.approx(component.steady_rise(COUNTS[1:]), rel=1e-9, abs=1e-12)
        for x in (51, 200):
            characteristic = np.poly(a[x])
            assert characteristic == pytest.approx(component.denominator([x])[0], rel=1e-6)


@pytest.mark.parametrize("example", NAMES)
def test_control_objects(example: str) -> None:
    thermal = model(example)
    for name in thermal.component_names:
        component = thermal.component(name)
        continuous = thermal.transfer_function(name, -200)
        sampled = thermal.sampled(name, 200)
        assert isinstance(continuous, control.TransferFunction)
        assert sampled.dt == thermal.sample_time
        expected = component.steady_rise([200])[0] / 200
        assert control.dcgain(continuous) == pytest.approx(expected, rel=1e-12)
        zpk = thermal.zpk(name, 200)
        assert zpk(0.001j) == pytest.approx(continuous(0.001j), rel=1e-9)
        # The textbook's sampled transfer function loses digits with slow poles; that is its nature.
        poles = np.exp(continuous.poles() * thermal.sample_time)
        # (Not `sampled.poles()`, which takes its numerator apart as well: SciPy 1.18 warns of its small coefficients.)
        of_sampled = np.roots(sampled.den[0][0])
        assert np.sort(np.abs(of_sampled)) == pytest.approx(np.sort(np.abs(poles)), abs=1e-4)


def test_two_mass_has_a_conjugate_pair_and_slow_and_fast_poles() -> None:
    thermal = model("two_mass")
    assert [c.order for c in thermal.components] == [2, 4]
    roots = np.roots(thermal.component("housing").denominator([128])[0])
    assert np.sum(np.abs(roots.imag) > 1e-4) == 2
    for component in thermal.components:
        assert 0 < component.steady_rise(COUNTS).max() < 120
        assert np.max(np.abs(component.dropped_imaginary(COUNTS))) < 1e-40


@pytest.mark.parametrize("pwm", [[256], [-1], [1.5]])
def test_wrong_counts_are_refused(pwm: list[float]) -> None:
    with pytest.raises((ValueError, TypeError), match=r"\|PWM\|"):
        model("my1016").component("brush").denominator(pwm)


def test_unknown_component() -> None:
    with pytest.raises(KeyError, match="no component 'rotor'; there are brush, bearing"):
        model("my1016").component("rotor")


def test_order_four_with_widely_spread_poles_is_correctly_rounded() -> None:
    poles = (-1e-5, -3e-4, -0.02, -0.3)
    component = Component("spread", 4, Polynomial((1.0,)), tuple(Pole(ExponentialSum(((p, 0.003),))) for p in poles))
    x = np.exp(np.longdouble(0.003) * np.arange(256, dtype=np.longdouble))
    oracle = np.ones((256, 1), dtype=np.longdouble)
    for pole in poles:
        root = (np.longdouble(pole) * x)[:, None]
        oracle = np.concatenate([oracle, np.zeros_like(root)], axis=1) - root * np.concatenate(
            [np.zeros_like(root), oracle], axis=1
        )
    assert np.max(np.abs(component.denominator(COUNTS) / oracle - 1)) < 2e-16
