"""Draw the README's picture: `python docs/figures.py`, needs nothing but the installed package."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

from gen.coefficients import load
from gen.lowering.lower import lower
from gen.lowering.recursion.guarantee import rounded_up
from gen.model.exact import ExactSolution
from gen.reference.model import ReferenceModel

ROOT = Path(__file__).parent.parent
SAMPLES = 43_200


def main() -> None:
    """Three hours of a staircase: temperatures above, the board's error in microkelvin below."""
    coefficients = load(ROOT / "examples" / "my1016" / "coeffs.json")
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
    figure, (above, below) = plt.subplots(2, 1, figsize=(9, 6), sharex=True, height_ratios=(3, 2))
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
    figure.savefig(ROOT / "docs" / "my1016.svg", bbox_inches="tight", metadata={"Date": None})


if __name__ == "__main__":
    main()
