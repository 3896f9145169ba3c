"""Schedules: both ways of evaluating them, against scipy and extended precision."""

from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from gen.model import ExponentialSum, Polynomial, Schedule, Table
from gen.model.schedules import Interpolation

COUNTS = np.arange(256)
# scipy's slopes, the oracle's, divide by what lies between values: nothing so small that this overflows.
values = st.floats(-1e3, 1e3).filter(lambda value: value == 0.0 or abs(value) > 1e-200)


@st.composite
def tables(draw: st.DrawFn) -> Table:
    pwm = sorted(draw(st.sets(st.integers(0, 255), min_size=2, max_size=12)))
    kind: Interpolation = draw(st.sampled_from(["pchip", "linear"]))
    return Table(tuple(pwm), tuple(draw(values) for _ in pwm), kind)


def exact(schedule: Schedule) -> np.ndarray:
    return np.array([float(schedule.exact(int(x))) for x in COUNTS])


def test_polynomial_against_fractions_worked_by_hand() -> None:
    schedule = Polynomial((2.0, -3.0, 0.5))
    assert schedule(np.array([0.0, 2.0])).tolist() == [0.5, 2.5]
    assert schedule.exact(10) == Decimal("170.5")


def test_exponentials_against_extended_precision() -> None:
    schedule = ExponentialSum(((0.0005619, 0.01276), (-0.001848, 0.00903)))
    x = COUNTS.astype(np.longdouble)
    a, b, c, d = (np.longdouble(v) for v in (0.0005619, 0.01276, -0.001848, 0.00903))
    oracle = (a * np.exp(b * x) + c * np.exp(d * x)).astype(np.float64)
    assert np.max(np.abs(exact(schedule) / oracle - 1)) < 3e-16
    assert np.max(np.abs(schedule(COUNTS.astype(float)) / oracle - 1)) < 1e-14


@given(tables())
def test_table_is_scipys(table: Table) -> None:
    inside = np.clip(COUNTS, table.pwm[0], table.pwm[-1])
    if table.interpolation == "pchip":
        oracle = PchipInterpolator(table.pwm, table.value)(inside)
    else:
        oracle = np.interp(inside, table.pwm, table.value)
    scale = max(map(abs, table.value)) + 1e-300
    assert np.max(np.abs(table(COUNTS.astype(float)) - oracle)) <= 1e-12 * scale
    assert np.max(np.abs(exact(table) - oracle)) <= 1e-12 * scale


@given(tables())
def test_table_gives_its_points_exactly_and_holds_its_ends(table: Table) -> None:
    assert table(np.array(table.pwm, dtype=float)).tolist() == list(table.value)
    assert [float(table.exact(x)) for x in table.pwm] == list(table.value)
    assert table(np.array([-50.0, 400.0])).tolist() == [table.value[0], table.value[-1]]


@given(tables())
def test_segments_join_up(table: Table) -> None:
    segments = table.segments()
    assert [s.start for s in segments] == list(table.pwm[:-1])
    assert [s.end for s in segments] == list(table.pwm[1:])
    scale = max(map(abs, table.value)) + 1e-300
    for segment, start, end in zip(segments, table.value[:-1], table.value[1:], strict=True):
        assert len(segment.coefficients) == (4 if table.interpolation == "pchip" else 2)
        assert segment.coefficients[-1] == start
        assert abs(np.polyval(segment.coefficients, segment.end - segment.start) - end) <= 1e-11 * scale


def test_pchip_does_not_overshoot() -> None:
    table = Table((0, 50, 60, 255), (0.0, 0.0, 1.0, 1.0), "pchip")
    result = table(np.linspace(0, 255, 2000))
    assert result.min() >= 0.0
    assert result.max() <= 1.0


@pytest.mark.parametrize("shape", [(), (3,), (2, 3)])
def test_shapes(shape: tuple[int, ...]) -> None:
    x = np.full(shape, 7.0)
    for schedule in (
        Polynomial((1.0, 2.0)),
        ExponentialSum(((1.0, 0.1),)),
        Table((0, 10), (1.0, 2.0), "linear"),
    ):
        assert schedule(x).shape == shape
        assert schedule(x).dtype == np.float64
