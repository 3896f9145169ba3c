"""Where the study's own figures disagree with each other: each statement computed from the tables."""

from __future__ import annotations

import numpy as np

from examples.my1016.study.reproduce import Entry
from examples.my1016.study.tables import STEADY_S, TRANSIENT_S, Study
from gen.model import ThermalModel


def disagreements(study: Study, entries: list[Entry], variable: ThermalModel) -> list[str]:
    """Say in words what does not fit together, with the figures."""
    return [
        *(_off(entry) for entry in entries if not entry.agrees),
        _final_values([entry for entry in entries if entry.table == "4.1"]),
        _lower_order_wins(study),
        _acceptance(study, variable),
        _pair(study),
        _below_the_speeds(variable),
    ]


def _off(entry: Entry) -> str:
    return (
        f"Table {entry.table}, {entry.component} at {entry.what}: printed {entry.printed:+.1f}, from its own transfer "
        f"functions {entry.computed:+.1f}: the measured point lies {entry.difference:.0f} K above the identified curve."
    )


def _final_values(entries: list[Entry]) -> str:
    least, *_, most = sorted(entries, key=lambda entry: -entry.difference)
    return (
        f"Table 4.1 (measured at {STEADY_S} s) lies {-least.difference:.1f} to {-most.difference:.1f} K above the ends "
        f"of the curves of Table 4.3 in all {len(entries)} places, most at {most.component} {most.what.split(',')[0]}; "
        "yet the fits' root mean square errors (Table 4.2) are 0.3 to 0.6 K: the curves miss most where the runs end."
    )


def _lower_order_wins(study: Study) -> str:
    worse = [
        (high.mse / low.mse, name, low, high)
        for name, functions in study.transfer_functions.items()
        for low in functions
        for high in functions
        if high.speed_percent == low.speed_percent and high.order == low.order + 1 and high.mse > 1.05 * low.mse
    ]
    _, name, low, high = max(worse, key=lambda case: case[0])
    return (
        f"In {len(worse)} of 60 cases one more pole makes the mean square error larger (worst: {name} "
        f"{low.speed_percent} %, order {low.order}: {low.mse:.3g}, order {high.order}: {high.mse:.3g} K^2). "
        "Orders are nested, so those did not converge."
    )


def _acceptance(study: Study, variable: ThermalModel) -> str:
    functions = study.kept("bearing")
    gains = np.array([g.numerator for g in functions])
    fitted = variable.component("bearing").raw_gain([g.pwm for g in functions])
    return (
        "A fit of a schedule counts as good when its SSE is under 1e-5, but a gain of 1e-4 that was fitted as "
        f"zero would have an SSE of {np.sum(gains**2):.1e}: the bearing's has {np.sum((fitted - gains) ** 2):.1e} and "
        f"is off by up to {np.max(np.abs(fitted / gains - 1)):.0%}."
    )


def _pair(study: Study) -> str:
    fastest = study.kept("brush")[-1]
    return (
        f"The brush is modelled with a complex pair of poles; at {fastest.speed_percent} % its three are real "
        f"({', '.join(f'{p.real:.3g}' for p in fastest.poles)} rad/s), "
        "and the CV counts the scatter of the imaginary part against the real part's mean."
    )


def _below_the_speeds(variable: ThermalModel) -> str:
    pwm = np.arange(1, 51)
    negative = pwm[variable.component("brush").raw_gain(pwm) < 0.0]
    tau = 1.0 / variable.component("bearing").denominator([0])[0, -1]
    return (
        f"Below the identified speeds the brush's gain is negative at PWM {', '.join(map(str, negative))}, and the "
        f"bearing's time constant at standstill is {tau:.0f} s: its cooling was never measured (the errors at "
        f"{TRANSIENT_S} s and {STEADY_S} s are of heating alone)."
    )
