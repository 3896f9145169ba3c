"""A run as a picture: what was measured, what the model said, and when an alarm came."""

from __future__ import annotations

import io

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gen.emulate.results import Results

_POINTS = 1500


def plot_svg(results: Results, title: str) -> str:
    """Draw a run: temperatures, measured minus model, PWM; alarms as vertical lines.

    Parameters
    ----------
    results
        The run.
    title
        Stands above.

    Returns
    -------
    str
        An SVG; the same run gives the same text.
    """
    columns = results.columns
    every = max(1, len(columns["time_s"]) // _POINTS)
    hours = columns["time_s"][::every] / 3600.0
    names = [name.removesuffix("_model_degC") for name in columns if name.endswith("_model_degC")]
    with mpl.rc_context({"svg.hashsalt": "gen", "svg.fonttype": "none", "font.size": 9}):
        figure = Figure(figsize=(9.0, 8.0), layout="constrained")
        above, middle, below = figure.subplots(3, 1, sharex=True, height_ratios=(4, 3, 1))
        for index, name in enumerate(names):
            colour = f"C{index}"
            model = columns[f"{name}_model_degC"][::every]
            above.plot(hours, model, color=colour, linewidth=1.4, label=f"{name}, model")
            if f"{name}_degC" in columns:
                measured = columns[f"{name}_degC"][::every]
                above.plot(hours, measured, color=colour, linewidth=0.7, linestyle=":", label=f"{name}, measured")
                middle.plot(hours, measured - model, color=colour, linewidth=0.8, label=name)
        if "ambient_degC" in columns:
            above.plot(hours, columns["ambient_degC"][::every], color="0.6", linewidth=0.7, label="ambient")
        below.step(hours, columns["pwm"][::every], where="post", color="0.3", linewidth=0.9)
        for alarm in results.alarms:
            for axes in (above, middle, below):
                axes.axvline(alarm.raised_s / 3600.0, color="crimson", linewidth=1.0, alpha=0.8)
            above.annotate(
                alarm.rule,
                (alarm.raised_s / 3600.0, 1.0),
                xycoords=("data", "axes fraction"),
                rotation=90,
                va="top",
                ha="right",
                color="crimson",
                fontsize=8,
            )
        above.set_title(title)
        above.set_ylabel("temperature, degC")
        middle.set_ylabel("measured - model, K")
        middle.axhline(0.0, color="0.7", linewidth=0.8, zorder=0)
        below.set_ylabel("PWM")
        below.set_xlabel("time, h")
        above.legend(ncols=3, fontsize=7)
        for axes in (above, middle, below):
            axes.grid(alpha=0.3)
            axes.margins(x=0.0)
        if np.size(hours) == 0:
            above.text(0.5, 0.5, "no rows", transform=above.transAxes, ha="center")
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()
