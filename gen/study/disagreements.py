"""Where the study's own figures disagree with each other: each statement computed from the tables."""

from __future__ import annotations

import numpy as np

from gen.study.reproduce import Entry, pole_statistics
from gen.study.tables import STEADY_S, TRANSIENT_S, Study, variable_model


def disagreements(study: Study, entries: list[Entry]) -> list[str]:
    """Say in words what does not fit together, with the figures."""
    return [
        *(f"Table {e.table}, {e.component} {_off(e)}: {e.note}." for e in entries if not e.agrees),
        _final_values(entries),
        _lower_order_wins(study),
        _acceptance(study),
        _pair(study),
        _negative_gain(study),
    ]


def _off(entry: Entry) -> str:
    return f"at {entry.what}: printed {entry.printed:+.1f}, from its own transfer functions {entry.computed:+.1f}"


def _final_values(entries: list[Entry]) -> str:
    gaps = [(-e.difference, e) for e in entries if e.table == "4.1"]
    worst, entry = max(gaps, key=lambda pair: pair[0])
    least = min(gap for gap, _ in gaps)
    return (
        f"Table 4.1 (measured at {STEADY_S} s) lies {least:.1f} to {worst:.1f} K above the ends of the curves of "
        f"Table 4.3 in all {len(gaps)} places, most at {entry.component} {entry.what.split(',')[0]}; yet the fits' "
        f"root mean square errors (Table 4.2) are 0.3 to 0.6 K: the curves miss most where the runs end."
    )


def _lower_order_wins(study: Study) -> str:
    worse = [
        (name, low.speed_percent, low.order, low.mse, high.order, high.mse)
        for name, functions in study.transfer_functions.items()
        for low in functions
        for high in functions
        if high.speed_percent == low.speed_percent and high.order == low.order + 1 and high.mse > 1.05 * low.mse
    ]
    name, speed, order, mse, higher, other = max(worse, key=lambda w: w[5] / w[3])
    return (
        f"In {len(worse)} of 60 cases one more pole makes the mean square error larger (worst: {name} {speed} %, "
        f"order {order}: {mse:.3g}, order {higher}: {other:.3g} K^2). Orders are nested, so those did not converge."
    )


def _acceptance(study: Study) -> str:
    name = "bearing"
    gains = np.array([g.numerator for g in study.kept(name)])
    pwm = np.array([g.pwm for g in study.kept(name)], dtype=np.float64)
    fitted = np.polyval(study.schedules[name]["gain"]["poly"], pwm)
    sse, relative = float(np.sum((fitted - gains) ** 2)), float(np.max(np.abs(fitted / gains - 1)))
    return (
        f"A fit of a schedule counts as good when its SSE is under 1e-5, but a gain of 1e-4 that was fitted as "
        f"zero would have an SSE of {float(np.sum(gains**2)):.1e}: "
        f"the {name}'s has {sse:.1e} and is off by up to {relative:.0%}."
    )


def _pair(study: Study) -> str:
    poles = pole_statistics(study, "brush").poles
    last = poles[-1]
    return (
        "The brush is modelled with a complex pair of poles; "
        f"at {study.speeds[-1]} % its three are real ({', '.join(f'{p.real:.3g}' for p in last)} rad/s), "
        "and the CV counts the scatter of the imaginary part against the real part's mean."
    )


def _negative_gain(study: Study) -> str:
    model = variable_model(study).component("brush")
    pwm = np.arange(1, 51)
    negative = pwm[model.raw_gain(pwm) < 0.0]
    tau = 1.0 / -variable_model(study).component("bearing").poles[0].real(np.array([0.0]))[0]
    return (
        f"Below the identified speeds the brush's gain is negative at PWM {', '.join(map(str, negative))}, and the "
        f"bearing's time constant at standstill is {tau:.0f} s: its cooling was never measured (the errors at "
        f"{TRANSIENT_S} s and {STEADY_S} s are of heating alone)."
    )
