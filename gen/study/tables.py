"""The study's numbers: ``examples/my1016/study.json``, typed."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, ValidationError

from gen.errors import InputError
from gen.model import Component, ExponentialSum, Pole, Polynomial, Schedule, ThermalModel

FloatArray = NDArray[np.float64]
STEADY_S, TRANSIENT_S = 10_800, 2_160
"""The two times at which the study compares model and measurement, in s."""


class _Part(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)


class TransferFunction(_Part):
    """numerator / polyval(denominator, s): input PWM counts, output rise in K; mse in K^2."""

    speed_percent: int
    order: int
    numerator: float
    denominator: tuple[float, ...]
    mse: float

    @property
    def pwm(self) -> int:
        """The step's PWM in counts."""
        return round(self.speed_percent * 2.55)

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Poles in rad/s, fastest first, the one above the real axis before the one below."""
        roots = np.roots(self.denominator)
        return np.asarray(roots[np.lexsort((-roots.imag, np.round(roots.real, 12)))], dtype=np.complex128)


class Averaged(_Part):
    """Table 4.5, one component."""

    numerator: float
    denominator: tuple[float, ...]


class PoleFigures(_Part):
    """Table 4.4, one component: mean as [real, imaginary] per pole, variance where printed, CV."""

    mean: tuple[tuple[float, float], ...]
    cv: tuple[float, ...]
    variance: tuple[float, ...] | None = None


class Study(_Part):
    """All tables."""

    source: str
    measured_steady_degC: dict[str, tuple[float, ...]]
    transfer_functions: dict[str, tuple[TransferFunction, ...]]
    kept_order: dict[str, int]
    poles: dict[str, PoleFigures]
    averaged_pole: dict[str, Averaged]
    averaged_minus_measured: dict[str, dict[str, tuple[float, ...]]]
    variable_minus_measured: dict[str, dict[str, tuple[float, ...]]]
    schedules: dict[str, dict[str, dict[str, Any]]]
    experiment: dict[str, Any]
    motor: dict[str, Any]

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


def read_study(path: Path) -> Study:
    """Read the study's tables.

    Raises
    ------
    InputError
        With the file and the place in it.
    """
    try:
        return Study.model_validate(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise InputError("there is no such file; expected the study's tables", file=str(path)) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read: {error}", file=str(path)) from error
    except json.JSONDecodeError as error:
        raise InputError(f"is not JSON: {error.msg}", file=str(path), place=f"line {error.lineno}") from error
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(["$", *map(str, first["loc"])])
        raise InputError(f"{first['msg'].lower()}, expected the study's tables", file=str(path), place=place) from error


@dataclass(frozen=True)
class _Scheduled:
    """The schedules of one component by the study's names."""

    entries: dict[str, dict[str, Any]]

    def schedule(self, key: str) -> Schedule:
        entry = self.entries[key]
        if "poly" in entry:
            return Polynomial(tuple(entry["poly"]))
        a, b, c, d = entry["exp2"]
        return ExponentialSum(((a, b), (c, d)))

    def poles(self) -> tuple[Pole, ...]:
        if "pole" in self.entries:
            return (Pole(self.schedule("pole")),)
        pairs = tuple(Pole(self.schedule(f"pole{i}_real"), self.schedule(f"pole{i}_imag")) for i in (1, 2))
        return (*pairs, Pole(self.schedule("pole3_real")))


def variable_model(study: Study) -> ThermalModel:
    """Build the study's variable-pole model from Table 4.10."""
    components = []
    for name in study.components:
        entries = _Scheduled(study.schedules[name])
        poles = entries.poles()
        components.append(Component(name, len(poles), entries.schedule("gain"), poles, (51, 255)))
    return thermal_model("study_variable", tuple(components), study)


def averaged_model(study: Study) -> ThermalModel:
    """Build the study's averaged-pole model from the printed Table 4.5."""
    components = []
    for name in study.components:
        printed = study.averaged_pole[name]
        poles = tuple(
            Pole(Polynomial((float(p.real),)), Polynomial((float(p.imag),)) if p.imag else None)
            for p in np.roots(printed.denominator)
        )
        components.append(Component(name, len(poles), Polynomial((printed.numerator,)), poles, (51, 255)))
    return thermal_model("study_averaged", tuple(components), study)


def thermal_model(name: str, components: tuple[Component, ...], study: Study) -> ThermalModel:
    """Put components into a model with the study's sample time and ambient."""
    return ThermalModel(
        name=name,
        sample_time=float(study.experiment["sample_time_s"]),
        full_scale=255,
        validity=(51, 255),
        outside="extrapolate",
        domain_pwm=(0, 255),
        domain_ambient=(-10.0, 50.0),
        domain_temperature=(-10.0, 150.0),
        ambient_fixed=study.ambient,
        ambient_channel=None,
        components=components,
    )
