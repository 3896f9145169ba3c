"""One step of the model as CasADi generates it: classical Runge-Kutta, the schedule symbolic in |PWM|."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.rivals.missing import library
from gen.model import ThermalModel


def write(model: ThermalModel, folder: Path) -> list[str]:
    """Write ``casadi_step.c`` into a folder.

    Returns
    -------
    list of str
        Macros for the wrapper: how much room the function's work vectors need.

    Raises
    ------
    LibraryMissing
        When CasADi is not installed.
    """
    casadi = library("casadi")
    state, pwm = casadi.SX.sym("x", 6), casadi.SX.sym("pwm")
    step = casadi.Function("motor_step", [state, pwm], [_runge_kutta(casadi, model.sample_time, state, pwm)])
    generator = casadi.CodeGenerator(
        "casadi_step.c", {"casadi_real": "float", "casadi_int": "int", "cpp": False, "with_header": False}
    )
    generator.add(step)
    generator.generate(f"{folder}/")
    return [
        f"CASADI_WORK={max(1, step.sz_w())}",
        f"CASADI_INDICES={max(1, step.sz_iw())}",
        f"CASADI_ARGUMENTS={step.sz_arg()}",
        f"CASADI_RESULTS={step.sz_res()}",
    ]


def _slope(casadi: Any, state: Any, u: Any) -> Any:  # noqa: ANN401
    """The study's schedule and equations (Table 4.10) in CasADi's symbols."""
    re1 = 0.0005619 * casadi.exp(0.01276 * u) - 0.001848 * casadi.exp(0.00903 * u)
    re2 = 0.0006881 * casadi.exp(0.01372 * u) - 0.002001 * casadi.exp(0.009904 * u)
    im = (-1.969e-07 * u + 4.718e-05) * u + 0.0007725
    re3 = (1.289e-08 * u - 4.812e-06) * u - 0.0001109
    pair = re1 * re2 + im * im
    gain = casadi.fmax((-2.586e-13 * u + 6.931e-11) * u - 1.912e-10, 0.0)
    third = gain * u + (re1 + re2 + re3) * state[2] - (pair + (re1 + re2) * re3) * state[1] + pair * re3 * state[0]
    a = [
        0.0007722 * casadi.exp(-0.001092 * u) - 0.0006995 * casadi.exp(-0.01156 * u),
        0.0008783 * casadi.exp(-0.001394 * u) - 0.0007423 * casadi.exp(-0.009215 * u),
        0.0009327 * casadi.exp(-0.001456 * u) - 0.0007804 * casadi.exp(-0.008379 * u),
    ]
    gains = [-4.721e-07 * u + 0.0001946, -4.685e-07 * u + 0.0001932, -4.598e-07 * u + 0.0001896]
    first = [gains[i] * u - a[i] * state[i + 3] for i in range(3)]
    return casadi.vertcat(state[1], state[2], third, *first)


def _runge_kutta(casadi: Any, step: float, state: Any, u: Any) -> Any:  # noqa: ANN401
    one = _slope(casadi, state, u)
    two = _slope(casadi, state + step / 2 * one, u)
    three = _slope(casadi, state + step / 2 * two, u)
    four = _slope(casadi, state + step * three, u)
    return state + step / 6 * (one + 2 * two + 2 * three + four)
