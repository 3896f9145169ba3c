"""The study's schedules beside those that `gen identify` chooses, on the same data.

The data are the step responses of Table 4.3's transfer functions at the five speeds, read with the study's sensor
resolution. They stand in for the recordings, which are not published.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import control
import numpy as np
from numpy.typing import NDArray

from gen.coefficients import parse
from gen.loop.identify.coefficients import Settings, coefficient_text
from gen.loop.identify.data import Source, make_data
from gen.loop.identify.forms import Form
from gen.loop.identify.identify import identify
from gen.runs import Run
from gen.study.reproduce import identified_rise, model_rise
from gen.study.tables import STEADY_S, TRANSIENT_S, FloatArray, Study, variable_model

ComplexArray = NDArray[np.complex128]
RESOLUTION_K = 0.25
SAMPLE_S = 1.0


@dataclass(frozen=True, eq=False)
class Comparison:
    """Errors in K of both general models, model minus identified curve.

    Attributes
    ----------
    study, ours
        By component and time at the five speeds, shape (5,).
    study_left_out, ours_left_out
        By component: error of the steady rise at each speed when the schedules are fitted without it, shape (5,).
    forms
        By component what `gen identify` chose.
    """

    study: dict[str, dict[int, FloatArray]]
    ours: dict[str, dict[int, FloatArray]]
    study_left_out: dict[str, FloatArray]
    ours_left_out: dict[str, FloatArray]
    forms: dict[str, str]


def study_runs(study: Study) -> list[Source]:
    """Give the five recordings as run files in memory."""
    time = np.arange(0.0, STEADY_S + SAMPLE_S / 2.0, SAMPLE_S)
    sources = []
    for i, speed in enumerate(study.speeds):
        temps = {}
        for name in study.components:
            g = study.kept(name)[i]
            system = control.tf2ss(control.TransferFunction([g.numerator * g.pwm], list(g.denominator)))
            degrees = study.ambient + control.step_response(system, T=time).outputs
            temps[name] = np.round(degrees / RESOLUTION_K) * RESOLUTION_K
        pwm = np.full(len(time), round(speed * 2.55), dtype=np.int64)
        sources.append(Source(f"step_{speed}_percent.csv", Run(time, pwm, temps)))
    return sources


def compare(study: Study, progress: Callable[[str], None]) -> Comparison:
    """Identify on the study's data and compare."""
    data = make_data(study_runs(study), study.ambient)
    found = identify(data, progress)
    text, _ = coefficient_text(data, found, Settings("my1016"))
    identified = {name: identified_rise(study, name) for name in study.components}
    left_out = {}
    for name, item in found.items():
        error = item.general.chosen.left_out
        assert error is not None  # five speeds
        left_out[name] = error.steady_K
    return Comparison(
        _minus(model_rise(variable_model(study), study), identified),
        _minus(model_rise(parse(text.encode()).model, study), identified),
        {name: study_left_out(study, name) for name in study.components},
        left_out,
        {name: f"order {item.fit.layout.structure.name}; {item.general.chosen.name}" for name, item in found.items()},
    )


def _minus(
    model: dict[str, dict[int, FloatArray]], identified: dict[str, dict[int, FloatArray]]
) -> dict[str, dict[int, FloatArray]]:
    return {
        name: {time: model[name][time] - identified[name][time] for time in (TRANSIENT_S, STEADY_S)} for name in model
    }


def study_left_out(study: Study, name: str) -> FloatArray:
    """Fit the study's own forms to four speeds, by sums of squares of the coefficients, and predict the fifth, K.

    Only the steady rise is compared, K |PWM| / A(0).
    """
    functions = study.kept(name)
    pwm = np.array([g.pwm for g in functions], dtype=np.float64)
    gain = np.array([g.numerator for g in functions])
    poles = np.stack([g.poles for g in functions])
    forms = _forms(study, name)
    errors = np.empty(len(pwm))
    for i in range(len(pwm)):
        kept = np.delete(np.arange(len(pwm)), i)
        values = {}
        for key, (form, column) in forms.items():
            source = gain if key == "gain" else column(poles)
            parameters = form.fit(pwm[kept], source[kept], np.full(len(kept), 1.0 / np.max(np.abs(source))))
            values[key] = form.evaluate(parameters, pwm[kept], pwm[i : i + 1])[0]
        if "pole" in values:
            constant = -values["pole"]
        else:
            first = complex(values["pole1_real"], values["pole1_imag"])
            second = complex(values["pole2_real"], values["pole2_imag"])
            constant = float(np.real(-first * second * values["pole3_real"]))
        errors[i] = values["gain"] * pwm[i] / constant - gain[i] * pwm[i] / functions[i].denominator[-1]
    return errors


def _forms(study: Study, name: str) -> dict[str, tuple[Form, Callable[[ComplexArray], FloatArray]]]:
    """The study's forms by their names, with the poles that they describe."""
    result = {}
    for key, entry in study.schedules[name].items():
        if key == "sse":
            continue
        form = Form("as is", "poly", len(entry["poly"]) - 1) if "poly" in entry else Form("as is", "exp2")
        index = int(key[4]) - 1 if key.startswith("pole") and key != "pole" else 0
        imaginary = key.endswith("imag")
        result[key] = (form, _part(index, imaginary=imaginary))
    return result


def _part(index: int, *, imaginary: bool) -> Callable[[ComplexArray], FloatArray]:
    def part(poles: ComplexArray) -> FloatArray:
        return poles[:, index].imag if imaginary else poles[:, index].real

    return part
