"""Three hours on the board: temperatures, and how far they are from the exact solution."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gen.coefficients import load
from gen.lowering.lower import lower
from gen.lowering.recursion.guarantee import rounded_up
from gen.model.exact import ExactSolution
from gen.reference.model import ReferenceModel

COEFFICIENTS = Path(__file__).parents[2] / "examples" / "my1016" / "coeffs.json"
SAMPLES = 43_200


def figure() -> Figure:
    """A staircase of PWM: temperatures above, the board's error in microkelvin below."""
    coefficients = load(COEFFICIENTS)
    program = lower(coefficients, "fixed", "table")
    pwm = np.repeat([102, 255, 0, 153, 204, 51], SAMPLES // 6)
    exact = ExactSolution(program.model).simulate(pwm)
    model = ReferenceModel(program, [0])
    names = program.model.component_names
    board = np.zeros((len(names), SAMPLES + 1))
    for step in range(SAMPLES):
        model.step(pwm[step : step + 1])
        board[:, step + 1] = model.rises[:, 0]
    time = np.arange(SAMPLES + 1) * program.model.sample_time / 3600.0
    drawn = Figure(figsize=(9, 6), layout="constrained")
    above, below = drawn.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    for index, name in enumerate(names):
        above.plot(time[::40], board[index, ::40] + 30.0, label=name)
        below.plot(time[::40], (board[index, ::40] - exact[name][::40]) * 1e6, linewidth=0.8)
    above.step(time[:-1:40], pwm[::40] / 255.0 * 40.0 + 20.0, color="0.75", zorder=0, label="PWM (0..255 on 20..60)")
    above.set_ylabel("temperature, degC")
    above.legend(ncols=5, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, 1.15))
    bounds = [component.proof.bound_K for component in program.components if component.proof is not None]
    below.set_ylabel("board - exact, µK")
    below.set_xlabel(f"time, h   (guaranteed for any PWM sequence: at most {rounded_up(max(bounds)) * 1e6:.1f} µK)")
    for axes in (above, below):
        axes.grid(alpha=0.3)
    return drawn
