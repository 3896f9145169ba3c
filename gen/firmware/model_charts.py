"""Charts of a model: schedules, step responses, the course of an error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from gen.firmware.step_responses import Responses
from gen.model import Component, ThermalModel
from gen.pages.charts import SUPERSCRIPT, Chart, Series

_DOTS = 15
"""Dots on a step response."""


def schedule_charts(model: ThermalModel, component: Component) -> list[Chart]:
    """Time constants, poles, gain and steady rise of a component over its domain of |PWM|."""
    low, high = model.domain_pwm
    pwm = sorted({*range(low, high + 1, 3), high, *model.validity})
    roots = [np.roots(row) for row in component.denominator(pwm)]
    decays = np.array([np.sort(-row.real) for row in roots])
    turns = np.array([np.sort(np.where(np.abs(row.imag) > 1e-7 * np.abs(row), row.imag, 0.0))[::-1] for row in roots])
    name = component.name
    order = component.order
    unit = f"K/{f's{order}'.translate(SUPERSCRIPT) if order > 1 else 's'} per count"

    def chart(kind: str, title: str, y: tuple[str, str], lines: list[Series], *, log_y: bool = False) -> Chart:
        text = f"{title} of {name} over |PWM| {low} to {high}; the validity range is {model.validity[0]} to "
        text += f"{model.validity[1]}. {ends_text(lines)}"
        return Chart(
            f"{kind}-{name}", title, text, "|PWM| (counts)", *y, tuple(lines), log_y=log_y, shade=model.validity
        )

    # Where two lines are the same everywhere (a complex pair), one is drawn for both.
    kept = [i for i in range(order) if not i or np.any(np.abs(decays[:, i] - decays[:, i - 1]) > 1e-6 * decays[:, i])]
    numbers = [", ".join(str(k + 1) for k in range(i, j)) for i, j in pairwise([*kept, order])]
    named = [(f"pole {text}" if order > 1 else "", i) for text, i in zip(numbers, kept, strict=True)]
    charts = [
        chart(
            "tau",
            "Time constants" if order > 1 else "Time constant",
            ("−1/Re", "s"),
            [Series(label, pwm, (1.0 / decays[:, i]).tolist(), i) for label, i in named],
            log_y=True,
        )
    ]
    if order > 1:
        real = [Series(label.replace("pole", "Re"), pwm, (-decays[:, i]).tolist(), i) for label, i in named]
        imag = [Series("±Im", pwm, turns[:, i].tolist(), 4 + i) for i in range(order // 2) if turns[:, i].any()]
        charts.append(chart("poles", "Poles: real and imaginary parts", ("pole", "rad/s"), real + imag))
    gain, steady = component.effective_gain(pwm).tolist(), component.steady_rise(pwm).tolist()
    charts.append(chart("gain", "Gain", ("K", unit), [Series("", pwm, gain, 3)]))
    charts.append(chart("steady", "Steady rise S", ("rise", "K"), [Series("", pwm, steady, 5)]))
    return charts


def response_charts(name: str, labels: Sequence[str], found: Responses) -> list[Chart]:
    """Step responses, exact and as far as the board's reference ran, and its error in µK."""
    lines = [Series(label, found.times, [float(v) for v in found.exact[i]], i) for i, label in enumerate(labels)]
    every = -(-(len(found.ran) - 1) // _DOTS)
    dots = [Series("", found.ran[::every], values[::every], i, dots=True) for i, values in enumerate(found.own)]
    errors = [
        Series(label, found.ran, [float(error * 10**6) for error in found.errors[i]], i)
        for i, label in enumerate(labels)
    ]
    over = f"of {name} at {', '.join(labels)} PWM"
    ran = f"up to {found.ran[-1]:g} s"
    text = f"Rise {over}: the exact solution as lines, the board's reference as dots {ran}. {ends_text(lines)}"
    wrong = f"The board's reference less the exact solution {over}, {ran}. {ends_text(errors)}"
    return [
        Chart(f"step-{name}", "Step responses", text, "time (s)", "rise", "K", (*lines, *dots)),
        Chart(f"error-{name}", "Error of the board", wrong, "time (s)", "error", "µK", tuple(errors)),
    ]


def course_chart(times: Sequence[float], errors: Mapping[str, Sequence[float]]) -> Chart:
    """The largest error of each component within each interval of a run, in µK; `times` (s) are the intervals' ends."""
    lines = [
        Series(name, times, [value * 1e6 for value in values], i % 8) for i, (name, values) in enumerate(errors.items())
    ]
    text = f"Largest error of every component over a run of {times[-1]:g} s. {ends_text(lines)}"
    return Chart("course", "Largest error over the run", text, "time (s)", "error", "µK", tuple(lines))


def ends_text(lines: list[Series]) -> str:
    """What the lines are at both ends, for those who do not see them."""
    return " ".join(f"{line.label or 'Value'}: {line.y[0]:.3g} to {line.y[-1]:.3g}." for line in lines)
