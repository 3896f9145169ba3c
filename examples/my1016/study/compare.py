"""The study's schedules beside those that identification chooses, on the same data.

The data are the step responses of Table 4.3's transfer functions at the five speeds, read with the study's sensor
resolution. They stand in for the recordings, which are not published.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import control
import numpy as np
import pandas as pd
from numpy.typing import NDArray

import gen
from examples.my1016.study.reproduce import rises
from examples.my1016.study.tables import STEADY_S, Study, counts
from gen.identification.parts.forms import FULL, Form
from gen.model import Component, ExponentialSum, Pole, Polynomial, Schedule, ThermalModel

FloatArray = NDArray[np.float64]
RESOLUTION_K = 0.25
SAMPLE_S = 1.0


@dataclass(frozen=True, eq=False)
class Comparison:
    """Errors in K of both models, model minus identified curve; a row a speed in percent.

    Attributes
    ----------
    study, ours
        Columns (component, time in s).
    study_left_out, ours_left_out
        Error of the steady rise at each speed when the schedules are fitted without it; a column a component.
    forms
        By component what identification chose.
    """

    study: pd.DataFrame
    ours: pd.DataFrame
    study_left_out: pd.DataFrame
    ours_left_out: pd.DataFrame
    forms: dict[str, str]


def recordings(study: Study) -> list[pd.DataFrame]:
    """Give the five recordings as runs."""
    time = np.arange(0.0, STEADY_S + SAMPLE_S / 2.0, SAMPLE_S)
    runs = []
    for speed in study.speeds:
        pwm = counts(speed)
        run = pd.DataFrame({"pwm": pwm}, index=pd.Index(time, name="time_s"))
        for name in study.components:
            degrees = study.ambient + pwm * control.step_response(study.identified(name, pwm), time).outputs
            run[f"{name}_degC"] = np.round(degrees / RESOLUTION_K) * RESOLUTION_K
        run.attrs["name"] = f"step_{speed}_percent"
        runs.append(run)
    return runs


def compare(study: Study, variable: ThermalModel) -> Comparison:
    """Identify on the study's data, and compare with the study's own variable-pole model."""
    ours = gen.identify(recordings(study), name="my1016", ambient=study.ambient, model="parts")
    left_out = {}
    for name, item in ours.found.items():
        error = item.general.chosen.left_out
        assert error is not None  # five speeds
        left_out[name] = error.steady_K
    curves = rises(study, study.identified)
    return Comparison(
        rises(study, variable.transfer_function) - curves,
        rises(study, ours.model.transfer_function) - curves,
        pd.DataFrame({c.name: study_left_out(study, c) for c in variable.components}, index=list(study.speeds)),
        pd.DataFrame(left_out, index=list(study.speeds)),
        {
            name: f"order {item.fit.layout.structure.name}; {item.general.chosen.name}"
            for name, item in ours.found.items()
        },
    )


def study_left_out(study: Study, component: Component) -> FloatArray:
    """Fit the study's own forms to four speeds, by sums of squares of the coefficients, and predict the fifth.

    Gives the errors of the steady rise, K |PWM| / A(0), at the speeds, shape (5,), K.
    """
    functions = study.kept(component.name)
    pwm = np.array([g.pwm for g in functions])
    gains = np.array([g.numerator for g in functions])
    poles = np.stack([g.poles for g in functions])
    measured = gains * pwm / [g.denominator[-1] for g in functions]
    predicted = np.empty(len(pwm))
    for i in range(len(pwm)):
        kept = np.delete(np.arange(len(pwm)), i)
        refitted = replace(
            component,
            gain=refit(component.gain, pwm[kept], gains[kept]),
            poles=tuple(
                Pole(
                    refit(pole.real, pwm[kept], values.real[kept]),
                    refit(pole.imag, pwm[kept], values.imag[kept]) if pole.imag else None,
                )
                for pole, values in zip(component.poles, poles.T, strict=True)
            ),
        )
        predicted[i] = refitted.steady_rise([pwm[i]])[0]
    return np.asarray(predicted - measured)


def refit(schedule: Schedule, pwm: NDArray[np.int64], values: FloatArray) -> Schedule:
    """Fit a schedule of the same form to values at some |PWM|."""
    if isinstance(schedule, Polynomial):
        return Polynomial(tuple(np.polyfit(pwm, values, len(schedule.coefficients) - 1).tolist()))
    assert isinstance(schedule, ExponentialSum)  # the study has no other
    weights = np.full(len(values), 1.0 / np.max(np.abs(values)))
    a, b, c, d = Form("as is", "exp2").fit(pwm.astype(np.float64), values, weights)
    return ExponentialSum(((a, b / FULL), (c, d / FULL)))
