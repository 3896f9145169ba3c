"""Runs as one HTML page that needs nothing else: it holds the plot library, and fetches nothing."""

from __future__ import annotations

import html
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import plotly.graph_objects as go
from jinja2 import Environment
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from gen.arrays import FloatArray
from gen.drawing.palette import BAR_NAMES, BARS, COLOURS, INK, colour
from gen.drawing.section import Curve, Panel, Section
from gen.drawing.thinning import line, lonely, steps
from gen.pages.charts import reaching_zero
from gen.pages.environment import page_environment
from gen.version import __version__

MOST_POINTS = 20_000
"""Of a curve: more than a screen is wide, so that there is something to zoom into."""
_FEW = 4
"""So many runs are drawn by the graphics card; a browser lends it to some sixteen drawings, and a run takes three."""
_POINTS_OF_MANY = 4_000
_PANEL_PX, _ROW_PX, _HEAD_PX, _FOOT_PX, _GAP_PX = 95, 22, 60, 55, 14
_LINE_PX = 15
"""Of a label of an axis."""


def page_html(sections: Sequence[Section], title: str) -> str:
    """Draw runs.

    Parameters
    ----------
    sections
        The runs; each a drawing of its own, one over the other.
    title
        Of the page.

    Returns
    -------
    str
        The page. No curve has more than :data:`MOST_POINTS` points.
    """
    few = len(sections) <= _FEW
    made = [
        {
            "title": section.title,
            "notes": section.notes,
            "bars": [(BARS[kind], BAR_NAMES[kind]) for kind in dict.fromkeys(bar.kind for bar in section.bars)],
            "model": any(curve.role == "model" for panel in section.panels for curve in panel.curves),
            "band": any(curve.role == "band" for panel in section.panels for curve in panel.curves),
            "figure": _json(figure_of(section, gl=few, most=MOST_POINTS if few else _POINTS_OF_MANY)),
        }
        for section in sections
    ]
    return (
        _environment()
        .get_template("plot.html.j2")
        .render(title=title, sections=made, version=__version__, library=Markup(get_plotlyjs()))  # our own dependency
    )


@cache
def _environment() -> Environment:
    return page_environment()


def _json(figure: go.Figure) -> Markup:
    """The figure as JSON that may stand in a script element: no text of a run file can end it."""
    text: str = figure.to_json()
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def figure_of(section: Section, *, gl: bool, most: int) -> go.Figure:
    """Draw one run.

    Parameters
    ----------
    section
        The run.
    gl
        Whether the graphics card draws.
    most
        Points of a curve at most.
    """
    traces: list[dict[str, Any]] = []
    layout, domains = _layout(section)
    named: set[str] = set()
    for number, panel in enumerate(section.panels):
        axis = "y" if number == 0 else f"y{number + 1}"
        layout[f"yaxis{axis[1:]}"] = _axis(panel, domains[number])
        for curve in panel.curves:
            traces += _traces(section, panel, curve, axis, named, gl=gl, most=most)
        if panel.zero:
            layout["shapes"].append(_zero(axis))
    if section.rows:
        axis = f"y{len(section.panels) + 1}"
        layout[f"yaxis{axis[1:]}"] = _bar_axis(section, domains[-1])
        traces += _bars(section, axis)
    return go.Figure({"data": traces, "layout": layout}, skip_invalid=False)


def _layout(section: Section) -> tuple[dict[str, Any], list[tuple[float, float]]]:
    """The layout without the vertical axes, and their places from the top down."""
    heights = [panel.weight * _PANEL_PX for panel in section.panels]
    heights += [_ROW_PX * len(section.rows)] if section.rows else []
    inner = sum(heights) + _GAP_PX * (len(heights) - 1)
    domains, top = [], float(inner)
    for height in heights:
        domains.append((max(0.0, (top - height) / inner), top / inner))
        top -= height + _GAP_PX
    unit, seconds = section.unit
    first, last = float(section.time_s[0]) / seconds, float(section.time_s[-1]) / seconds
    lowest = len(heights)
    layout: dict[str, Any] = {
        "height": inner + _HEAD_PX + _FOOT_PX,
        "margin": {
            "l": 55 + _LINE_PX * max(len(panel.label_lines) for panel in section.panels),
            "r": 20,
            "t": _HEAD_PX,
            "b": _FOOT_PX,
        },
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": INK, "activecolor": COLOURS[0]},
        "hovermode": "x unified",
        "hoversubplots": "axis",
        "legend": {
            "orientation": "h",
            "x": 0,
            "y": 1.0 + 12.0 / inner,
            "yanchor": "bottom",
            "groupclick": "togglegroup",
        },
        "xaxis": {
            "anchor": "y" if lowest == 1 else f"y{lowest}",
            "title": {"text": f"time, {unit}"},
            "unifiedhovertitle": {"text": f"%{{x}} {unit}"},
            "range": [*reaching_zero(first, last)] if last > first else [first - 1.0, first + 1.0],
        },
        "shapes": [],
    }
    return layout, domains


def _axis(panel: Panel, domain: tuple[float, float]) -> dict[str, Any]:
    label = "<br>".join(_text(line) for line in panel.label_lines)
    return {"domain": domain, "anchor": "x", "title": {"text": label, "font": {"size": 12}}}


def _text(name: str) -> str:
    """A name as the plot library shows it: neither its tags nor its templates are read in it."""
    return html.escape(name, quote=False).replace("{", "&#123;")


def _traces(
    section: Section, panel: Panel, curve: Curve, axis: str, named: set[str], *, gl: bool, most: int
) -> list[dict[str, Any]]:
    _, seconds = section.unit
    x, y = (steps if curve.is_held else line)(section.time_s, curve.values, most)
    own = _text(curve.name)
    base: dict[str, Any] = {
        "type": "scattergl" if gl and curve.role != "band" else "scatter",
        "yaxis": axis,
        "name": own,
        "legendgroup": own,
        "showlegend": False,
        "hoverinfo": "skip",
    }
    trace = base | {"x": x / seconds, "y": y, "mode": "lines", "line": _line_style(curve)}
    modelled = _has_model(panel, curve)
    if curve.role == "measured" and modelled:
        trace["opacity"] = 0.6
    if curve.role != "band":
        suffix = " model" if curve.role == "model" else ""
        del trace["hoverinfo"]
        trace["hovertemplate"] = f"%{{y:.6~g}}<extra>{own}{suffix}</extra>"
    if panel is section.panels[0] and (curve.role == "model" or not modelled) and own not in named:
        named.add(own)
        trace["showlegend"] = True
    made = [trace]
    alone = lonely(y)
    if curve.role == "measured" and alone.any():
        dots = {"mode": "markers", "marker": {"color": colour(curve.colour), "size": 3}}
        made.append(base | dots | {"x": x[alone] / seconds, "y": y[alone]})
    return made


def _has_model(panel: Panel, curve: Curve) -> bool:
    return any(other.role == "model" and other.colour == curve.colour for other in panel.curves)


def _line_style(curve: Curve) -> dict[str, Any]:
    widths = {"measured": 1.1, "model": 2.4, "band": 1.2, "held": 1.3}
    return {
        "color": colour(curve.colour),
        "width": widths[curve.role],
        "dash": "dot" if curve.role == "band" else "solid",
    }


def _zero(axis: str) -> dict[str, Any]:
    return {
        "type": "line",
        "xref": "paper",
        "x0": 0,
        "x1": 1,
        "yref": axis,
        "y0": 0,
        "y1": 0,
        "line": {"color": INK, "width": 1},
        "layer": "below",
    }


def _bar_axis(section: Section, domain: tuple[float, float]) -> dict[str, Any]:
    count = len(section.rows)
    return {
        "domain": domain,
        "anchor": "x",
        "tickvals": list(range(count)),
        "ticktext": [_text(name) for name in section.rows],
        "range": [count - 0.5, -0.5],
        "fixedrange": True,
        "zeroline": False,
        "automargin": True,
    }


def _bars(section: Section, axis: str) -> list[dict[str, Any]]:
    """A thick line for each bar: one curve for each kind and row, parted by gaps."""
    _, seconds = section.unit
    traces = []
    for row, name in enumerate(section.rows):
        for kind in dict.fromkeys(bar.kind for bar in section.bars if bar.name == name):
            own = [bar for bar in section.bars if bar.name == name and bar.kind == kind]
            x: FloatArray = np.array([[bar.from_s, bar.to_s, np.nan] for bar in own]).ravel() / seconds
            both = len({bar.kind for bar in section.bars if bar.name == name}) > 1
            at = row + (0.0 if not both else -0.2 if kind == "recorded" else 0.2)
            traces.append(
                {
                    "type": "scatter",
                    "yaxis": axis,
                    "x": x,
                    "y": np.full(x.size, at),
                    "mode": "lines",
                    "line": {"color": BARS[kind], "width": 5 if both else 9},
                    "name": BAR_NAMES[kind],
                    "showlegend": False,
                    "hovertemplate": f"{BAR_NAMES[kind]}<extra>{_text(name)}</extra>",
                }
            )
    return traces
