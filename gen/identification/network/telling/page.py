"""The report of a network's identification: one HTML file without outside links."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from jinja2 import Environment
from markupsafe import Markup

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.identification.choice.decision import Decision
from gen.identification.network.identify import NetworkFound, curves
from gen.identification.network.telling.as_json import as_json
from gen.identification.network.telling.rises import steady_rise_title
from gen.identification.network.telling.summary import Summary
from gen.identification.network.telling.text import by_input, by_temperature, in_still_air
from gen.pages.charts import Chart, Series
from gen.pages.environment import page_environment
from gen.pages.network_drawing import DrawnNode, DrawnPath, network_svg
from gen.version import __version__

_POINTS, _DOTS = 240, 60
"""Points of a line and dots of a measured course in one chart."""
_DETERMINED = 0.5
"""A parameter counts as determined when the runs, and not its prior, say at least this share of it."""
_STYLES = 8
_LONG_S = 5400.0
"""Runs longer than this are drawn over hours, others over minutes."""


def network_report(result: NetworkFound, coefficients: Coefficients, choice: Decision | None = None) -> str:
    """Write the report.

    Parameters
    ----------
    result
        What was identified.
    coefficients
        The coefficient file that was made of it.
    choice
        Why it is this kind of model, where that was not asked for.
    """
    whole = as_json(Summary(result))
    return (
        _environment()
        .get_template("network_identification.html.j2")
        .render(
            version=__version__,
            coefficients=coefficients,
            whole=whole,
            rise_title=steady_rise_title(result),
            choice=choice,
            drawings=_drawings(whole),
            by_input=by_input(whole["heats_go_with"]),
            still_air=in_still_air(whole["natural_convection"]),
            by_temperature=by_temperature(whole["heat_grows"]),
            runs=[
                (name, _courses(number, name, time, columns), _residuals(number, name, time, columns))
                for number, (name, (time, columns)) in enumerate(curves(result).items())
                if any(np.isfinite(values).any() for values in columns.values())  # one may hold the input alone
            ],
        )
    )


_SPEEDS = {"at_half_speed": "half speed", "at_full_speed": "full speed"}


@cache
def _environment() -> Environment:
    # A minus sign, and not a hyphen, at which a line may end.
    return page_environment(g3=lambda value: f"{value:.3g}".replace("-", "\N{MINUS SIGN}"))


def _drawings(whole: Mapping[str, Any]) -> list[Markup]:
    """The network at half and at full speed, in one arrangement."""
    names = [node["name"] for node in whole["nodes"]]
    arrangement = _paths(whole, names, "at_full_speed")
    made = []
    for key, said in _SPEEDS.items():
        heats = {heat["node"]: heat["power_W"][key] for heat in whole["heats"]}
        nodes = [
            DrawnNode(node["name"], node["sensed"], heats.get(node["name"], 0.0), _determined(node))
            for node in whole["nodes"]
        ]
        title = f"The network at {said}: W/K by thickness"
        made.append(network_svg(f"network-{key}", title, nodes, _paths(whole, names, key), arrangement))
    return made


def _paths(whole: Mapping[str, Any], names: list[str], key: str) -> list[DrawnPath]:
    made = []
    for path in whole["paths"]:
        first, second = path["between"]
        conductance = path["conductance_W_per_K"][key]
        if conductance > 0.0:
            other = None if second == "ambient" else names.index(second)
            made.append(DrawnPath(names.index(first), other, conductance, _determined(path)))
    return made


def _determined(part: Mapping[str, Any]) -> bool:
    return bool(part["determined_share"] >= _DETERMINED)


def _courses(number: int, name: str, time: FloatArray, columns: Mapping[str, FloatArray]) -> Chart:
    """Measured as dots, modelled as lines."""
    lines, dots = [], []
    unit, time = _axis(time)
    parts = [column.removesuffix("_model_degC") for column in columns if column.endswith("_model_degC")]
    for k, part in enumerate(parts):
        modelled, measured = columns[f"{part}_model_degC"], columns[f"{part}_degC"]
        lines.append(_series(part, time, modelled, k, _POINTS))
        dots.append(_series("", time, measured, k, _DOTS, dots=True))
    known = [series for series in (*lines, *dots) if series.x]
    said = ", ".join(parts)
    text = f"Measured and modelled temperatures of {said} along {name}."
    return Chart(f"run-{number}", name, text, f"time ({unit})", "temperature", "°C", tuple(known))


def _residuals(number: int, name: str, time: FloatArray, columns: Mapping[str, FloatArray]) -> Chart:
    unit, time = _axis(time)
    parts = [column.removesuffix("_model_degC") for column in columns if column.endswith("_model_degC")]
    lines = [
        _series(part, time, columns[f"{part}_degC"] - columns[f"{part}_model_degC"], k, _POINTS)
        for k, part in enumerate(parts)
    ]
    text = f"Measured less modelled temperature of each part along {name}."
    known = tuple(series for series in lines if series.x)
    return Chart(f"residual-{number}", f"{name}: residual", text, f"time ({unit})", "measured − model", "K", known)


def _axis(time: FloatArray) -> tuple[str, FloatArray]:
    """Hours, or minutes of a short run."""
    unit, seconds = ("h", 3600.0) if time[-1] > _LONG_S else ("min", 60.0)
    return unit, time / seconds


def _series(label: str, time: FloatArray, values: FloatArray, style: int, most: int, *, dots: bool = False) -> Series:
    """At most so many points, evenly among those that were read."""
    read = np.flatnonzero(np.isfinite(values))
    if read.size > most:
        read = read[np.unique(np.linspace(0, read.size - 1, most).round().astype(int))]
    return Series(label, time[read].tolist(), values[read].tolist(), style % _STYLES, dots=dots)
