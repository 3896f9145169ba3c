"""Headers with coefficients for each |PWM|, as python-control discretises them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import control
import numpy as np
from numpy.typing import NDArray

from gen.model import ThermalModel

FloatArray = NDArray[np.float64]
LEVELS = 256
Q31_RISE_K, Q31_COUNTS = 512.0, 256.0
"""What 1 stands for in Q31: a rise in K, and the input in counts."""
Q31_SHARE = 4.0
"""Coefficients are held as this part of themselves."""
Word = Callable[[float], str]


def float_word(value: float) -> str:
    """Give a literal that rounds to the nearest float32."""
    return f"{np.float32(value):.9e}f"


def q31_word(value: float) -> str:
    """Give the Q31 of a coefficient's quarter, rounded to the nearest and held to the range."""
    word = round(value / Q31_SHARE * 2.0**31)
    return f"{min(max(word, -(2**31) + 1), 2**31 - 1)}L"


def sampled(model: ThermalModel, name: str, pwm: int) -> tuple[FloatArray, FloatArray]:
    """Discretise a part at one |PWM|: Ad, shape (order, order), and Bd, shape (order,), of the state (T, T', ..)."""
    a, b = model.component(name).state_matrices([pwm])
    order = a.shape[1]
    system = control.ss(a[0], b[0][:, None], np.eye(1, order), np.zeros((1, 1)))
    made = control.sample_system(system, model.sample_time, "zoh")
    return np.asarray(made.A, dtype=np.float64), np.asarray(made.B, dtype=np.float64)[:, 0]


def difference_equation(model: ThermalModel, name: str, pwm: int) -> tuple[FloatArray, FloatArray]:
    """Give a and b, shape (order,), of y[k] + sum a y[k - i] = sum b u[k - i], i from 1."""
    a, b = sampled(model, name, pwm)
    order = len(b)
    poles = np.poly(a)
    response = [b[0]]
    state = b
    for _ in range(order - 1):
        state = a @ state
        response.append(state[0])
    drive = np.convolve(poles.real, response)[:order]
    return np.asarray(poles[1:].real, dtype=np.float64), np.asarray(drive, dtype=np.float64)


def direct_form(model: ThermalModel, folder: Path) -> None:
    """Write the table of the difference equations in float32."""
    _direct(model, folder / "direct_float_table.h", float_word, 1.0)


def direct_q31(model: ThermalModel, folder: Path) -> None:
    """Write the table of the difference equations in Q31."""
    _direct(model, folder / "direct_q31_table.h", q31_word, Q31_COUNTS / Q31_RISE_K)


def _direct(model: ThermalModel, path: Path, word: Word, scale: float) -> None:
    brush, *others = model.component_names
    thirds, firsts = [], []
    for pwm in range(LEVELS):
        a, b = difference_equation(model, brush, pwm)
        thirds.append(f"{{{{{_listed(a, word)}}}, {{{_listed(b * scale, word)}}}}}")
        pairs = [difference_equation(model, name, pwm) for name in others]
        firsts.append("{" + ", ".join(f"{{{word(a[0])}, {word(b[0] * scale)}}}" for a, b in pairs) + "}")
    path.write_text(
        _array("Third BRUSH[256]", thirds) + _array(f"First OTHERS[256][{len(others)}]", firsts), encoding="utf-8"
    )


def state_space(model: ThermalModel, folder: Path) -> None:
    """Write the tables of Ad and Bd in float32."""
    brush, *others = model.component_names
    matrices = [sampled(model, brush, pwm) for pwm in range(LEVELS)]
    text = _array("float BRUSH_A[256][9]", [f"{{{_listed(a.ravel(), float_word)}}}" for a, _ in matrices])
    text += _array("float BRUSH_B[256][3]", [f"{{{_listed(b, float_word)}}}" for _, b in matrices])
    rest = [[sampled(model, name, pwm) for pwm in range(LEVELS)] for name in others]
    for part, letter in enumerate("AB"):
        rows = [
            "{" + ", ".join(f"{{{_listed(one[part].ravel(), float_word)}}}" for one in of_part) + "}"
            for of_part in rest
        ]
        text += _array(f"float OTHERS_{letter}[{len(others)}][256][1]", rows)
    (folder / "state_space_table.h").write_text(text, encoding="utf-8")


def _listed(values: FloatArray, word: Word) -> str:
    return ", ".join(word(float(value)) for value in values)


def _array(declared: str, rows: list[str]) -> str:
    return f"static const {declared} PROGMEM = {{\n" + ",\n".join(rows) + "};\n"
