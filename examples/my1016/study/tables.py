"""The study's numbers: ``study.json`` and the two models that the coefficient files hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import control
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from gen.coefficients import load
from gen.model import ThermalModel

EXAMPLES = Path(__file__).parents[2]
STUDY = EXAMPLES / "my1016" / "study.json"
VARIABLE = EXAMPLES / "my1016" / "coeffs.json"
"""The variable-pole model, Table 4.10."""
AVERAGED = EXAMPLES / "my1016_averaged" / "coeffs.json"
"""The averaged-pole model, Table 4.5."""
STEADY_S, TRANSIENT_S = 10_800, 2_160
"""The two times at which the study compares model and measurement, in s."""


class TransferFunction(BaseModel):
    """numerator / polyval(denominator, s): input PWM counts, output rise in K; mse in K^2."""

    speed_percent: int
    order: int
    numerator: float
    denominator: tuple[float, ...]
    mse: float

    @property
    def pwm(self) -> int:
        """The step's PWM in counts."""
        return counts(self.speed_percent)

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Poles in rad/s, fastest first, the one above the real axis before the one below."""
        roots = np.roots(self.denominator)
        return np.asarray(roots[np.lexsort((-roots.imag, np.round(roots.real, 12)))], dtype=np.complex128)


class Averaged(BaseModel):
    """Table 4.5, one component."""

    numerator: float
    denominator: tuple[float, ...]


class PoleFigures(BaseModel):
    """Table 4.4, one component: mean as [real, imaginary] per pole, variance where printed, CV."""

    mean: tuple[tuple[float, float], ...]
    cv: tuple[float, ...]
    variance: tuple[float, ...] | None = None


class Study(BaseModel):
    """All tables; errors in K, model minus measured, by time in s and component at the five speeds."""

    source: str
    measured_steady_degC: dict[str, tuple[float, ...]]
    transfer_functions: dict[str, tuple[TransferFunction, ...]]
    kept_order: dict[str, int]
    poles: dict[str, PoleFigures]
    averaged_pole: dict[str, Averaged]
    averaged_minus_measured: dict[int, dict[str, tuple[float, ...]]]
    variable_minus_measured: dict[int, dict[str, tuple[float, ...]]]
    experiment: dict[str, Any]

    @property
    def components(self) -> tuple[str, ...]:
        """The components' names."""
        return tuple(self.kept_order)

    @property
    def speeds(self) -> tuple[int, ...]:
        """The speeds in percent."""
        return tuple(self.experiment["speed_steps_percent"])

    @property
    def ambient(self) -> float:
        """The ambient temperature in degC."""
        return float(self.experiment["ambient_degC"])

    def kept(self, component: str) -> tuple[TransferFunction, ...]:
        """Give Table 4.3: the transfer functions that the study keeps, by speed."""
        return tuple(g for g in self.transfer_functions[component] if g.order == self.kept_order[component])

    def identified(self, component: str, pwm: int) -> control.TransferFunction:
        """Give the kept transfer function of one speed as python-control's object."""
        g = next(g for g in self.kept(component) if g.pwm == pwm)
        return control.TransferFunction([g.numerator], list(g.denominator))


def counts(percent: int) -> int:
    """Give the PWM counts of a speed in percent."""
    return round(2.55 * percent)


def read_study() -> Study:
    """Read the study's tables."""
    return Study.model_validate_json(STUDY.read_text(encoding="utf-8"))


def variable_model() -> ThermalModel:
    """Load the study's variable-pole model."""
    return load(VARIABLE).model


def averaged_model() -> ThermalModel:
    """Load the study's averaged-pole model."""
    return load(AVERAGED).model
