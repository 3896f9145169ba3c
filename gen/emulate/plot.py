"""A run as a picture: what was measured, what the model said, and when an alarm came."""

from __future__ import annotations

import io
import re

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gen.emulate.results import Array, Results

_POINTS = 1500
_MEANS = 60
_UNITS = ((180.0, "s", 1.0), (7200.0, "min", 60.0), (float("inf"), "h", 3600.0))
"""Up to which length of a run, s: the axis's unit, and how many seconds it has."""

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f3c8d", "#8c564b")
"""One for each component; told apart with defective colour vision, too (Okabe and Ito's first)."""

_MODEL, _MEASURED = 3, 2  # the model's lines lie above the measured dots


def plot_svg(results: Results, title: str) -> str:
    """Draw a run: temperatures, measured minus model with its mean, PWM; alarms as vertical lines.

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
    columns = {name: values[:: _every(results)] for name, values in results.columns.items()}
    unit, seconds = _unit(results.columns["time_s"])
    time = columns["time_s"] / seconds
    with mpl.rc_context({"svg.hashsalt": "gen", "svg.fonttype": "none", "font.size": 9}):
        figure = Figure(figsize=(9.0, 8.0), layout="constrained")
        above, middle, below = figure.subplots(3, 1, sharex=True, height_ratios=(4, 3, 1))
        _temperatures(above, time, columns)
        _differences(middle, time, columns)
        below.step(time, columns["pwm"], where="post", color="0.3", linewidth=0.9)
        for axes in (above, middle, below):
            axes.grid(alpha=0.3)
            axes.margins(x=0.0)
            for alarm in results.alarms:
                axes.axvline(alarm.raised_s / seconds, color="crimson", linewidth=1.0, alpha=0.8)
        for alarm in results.alarms:
            _name_alarm(above, alarm.rule, alarm.raised_s / seconds)
        above.set_ylabel("temperature, degC")
        middle.set_ylabel("measured - model, K")
        below.set_ylabel("PWM")
        below.set_xlabel(f"time, {unit}")
        if time.size == 0:
            above.text(0.5, 0.5, "no rows", transform=above.transAxes, ha="center")
        figure.suptitle(title)
        handles = _legend(_components(columns), "ambient_degC" in columns)
        figure.legend(handles=handles, loc="outside right upper", fontsize=8, frameon=False)
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return _numbered(text.getvalue())


def _numbered(svg: str) -> str:
    """The picture with its identifiers numbered as they come: matplotlib makes some of memory addresses."""
    names = dict.fromkeys(re.findall(r'\bid="(\w+)"', svg))
    numbers = {name: f"i{number}" for number, name in enumerate(names)}
    return re.sub(r'(\bid="|#)(\w+)(?=["\)])', lambda found: found[1] + numbers.get(found[2], found[2]), svg)


def _every(results: Results) -> int:
    return max(1, len(results.columns["time_s"]) // _POINTS)


def _unit(time_s: Array) -> tuple[str, float]:
    """Unit of the time axis, and how many seconds it has."""
    length_s = float(time_s[-1] - time_s[0]) if time_s.size else 0.0
    return next((unit, seconds) for most_s, unit, seconds in _UNITS if length_s <= most_s)


def _components(columns: dict[str, Array]) -> dict[str, str]:
    """Colour of each component that has a model."""
    names = [name.removesuffix("_model_degC") for name in columns if name.endswith("_model_degC")]
    return {name: _COLOURS[i % len(_COLOURS)] for i, name in enumerate(names)}


def _temperatures(axes: Axes, time: Array, columns: dict[str, Array]) -> None:
    for name, colour in _components(columns).items():
        axes.plot(time, columns[f"{name}_model_degC"], color=colour, linewidth=1.3, zorder=_MODEL)
        if f"{name}_degC" in columns:
            _dots(axes, time, columns[f"{name}_degC"], colour)
    if "ambient_degC" in columns:
        axes.plot(time, columns["ambient_degC"], color="0.5", linewidth=0.8, zorder=_MEASURED)


def _differences(axes: Axes, time: Array, columns: dict[str, Array]) -> None:
    axes.axhline(0.0, color="0.5", linewidth=0.8, zorder=1)
    for name, colour in _components(columns).items():
        if f"{name}_degC" in columns:
            difference = columns[f"{name}_degC"] - columns[f"{name}_model_degC"]
            _dots(axes, time, difference, colour)
            axes.plot(_means(time), _means(difference), color=colour, linewidth=1.1, zorder=_MODEL)


def _means(values: Array) -> Array:
    """Means of what was measured over a sixtieth of the run each; without the last, incomplete one."""
    size = max(1, len(values) // _MEANS)
    blocks = values[: len(values) // size * size].reshape(-1, size)
    present = ~np.isnan(blocks)
    count = present.sum(axis=1)
    total = np.where(present, blocks, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _dots(axes: Axes, time: Array, measured: Array, colour: str) -> None:
    size = 2.0 if len(time) > _POINTS // 3 else 4.0
    axes.plot(time, measured, ".", color=colour, markersize=size, markeredgewidth=0.0, alpha=0.5, zorder=_MEASURED)


def _name_alarm(axes: Axes, rule: str, at: float) -> None:
    axes.annotate(
        rule,
        (at, 1.0),
        xycoords=("data", "axes fraction"),
        rotation=90,
        va="top",
        ha="right",
        color="crimson",
        fontsize=8,
    )


def _legend(components: dict[str, str], ambient: bool) -> list[Line2D]:
    handles = [Line2D([], [], color=colour, linewidth=1.3, label=name) for name, colour in components.items()]
    if ambient:
        handles.append(Line2D([], [], color="0.5", linewidth=0.8, label="ambient"))
    handles.append(Line2D([], [], color="0.2", linewidth=1.3, label="line: model;\nbelow: mean"))
    handles.append(
        Line2D(
            [], [], color="0.2", linestyle="", marker=".", markersize=4.0, markeredgewidth=0.0, label="dots: measured"
        )
    )
    return handles
