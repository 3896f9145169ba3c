"""A schedule that does between the identified speeds what no motor does is refused, and why is said."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gen.identification.parts.curves import Shape
from gen.identification.parts.general import guard
from gen.identification.parts.output_error import OutputErrorFit


def shape(steady: list[float]) -> Shape:
    """One with a pole of 0.01 1/s everywhere and these steady rises at PWM 0, 50, 100, 150, 200 and 255."""

    def evaluate(_: np.ndarray, pwm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.full((pwm.size, 1), np.log(100.0)), np.interp(pwm, [0, 50, 100, 150, 200, 255], steady)

    structure = SimpleNamespace(poles=lambda theta: -np.exp(-theta))
    return cast(Shape, SimpleNamespace(evaluate=evaluate, x=np.array([50.0, 255.0]), structure=structure))


@pytest.mark.parametrize(
    ("steady", "known", "said"),
    [
        ([0.0, 10.0, 14.0, 20.0, 30.0, 40.0], [10.0, 40.0], ""),
        ([0.0, 10.0, 14.0, -2.0, 30.0, 40.0], [10.0, 40.0], "the gain changes sign at PWM 150"),
        ([0.0, 10.0, 70.0, 20.0, 30.0, 40.0], [10.0, 40.0], "wiggles by more than"),
        ([0.0, -1.0, 14.0, 20.0, 30.0, 40.0], [-1.0, 40.0], ""),
        ([-9.0, 10.0, 14.0, 20.0, 30.0, 40.0], [10.0, 40.0], ""),
    ],
    ids=["grows", "changes sign", "wiggles", "a speed cools", "below what was identified"],
)
def test_what_a_schedule_does_between_the_speeds_is_judged(steady: list[float], known: list[float], said: str) -> None:
    theta = np.full((2, 1), np.log(100.0))
    fit = cast(OutputErrorFit, SimpleNamespace(theta=theta, steady=np.array(known)))
    assert guard(shape(steady), np.zeros(1), fit).startswith(said)
    assert bool(guard(shape(steady), np.zeros(1), fit)) == bool(said)
