"""Runs as one SVG or PNG, for a report or a paper."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, SubFigure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text

from gen.drawing.palette import BAR_NAMES, BARS, INK, colour
from gen.drawing.section import Curve, Panel, Section
from gen.drawing.thinning import line, lonely, steps
from gen.pages.charts import reaching_zero

MOST_POINTS = 4_000
"""Of a curve: a line of so many is as the whole one at any size of paper."""
_WIDTH_IN, _PANEL_IN, _ROW_IN, _REST_IN = 10.0, 0.8, 0.2, 1.1
_DPI = 150
_PANEL_PT = 45.0
"""What the names beside a panel share, of its height."""


def picture(sections: Sequence[Section], kind: Literal["svg", "png"]) -> bytes:
    """Draw runs, one under the other.

    Parameters
    ----------
    sections
        The runs.
    kind
        The file's form.

    Returns
    -------
    bytes
        The file; the same runs give the same bytes. No curve has more than :data:`MOST_POINTS` points.
    """
    heights = [_height_in(section) for section in sections]
    with _style():
        figure = Figure(figsize=(_WIDTH_IN, sum(heights)), layout="constrained")
        FigureCanvasAgg(figure)
        places = figure.subfigures(len(sections), 1, height_ratios=heights, squeeze=False)[:, 0]
        for section, place in zip(sections, places, strict=True):
            _draw(section, place)
        made = io.BytesIO()
        if kind == "png":
            figure.savefig(made, format="png", dpi=_DPI, metadata={"Software": None})
            return made.getvalue()
        figure.savefig(made, format="svg", metadata={"Date": None, "Creator": None})
    return _numbered(made.getvalue().decode("utf-8")).encode()


@contextmanager
def _style() -> Iterator[None]:
    with mpl.rc_context({"svg.hashsalt": "gen", "svg.fonttype": "none", "font.size": 9}), warnings.catch_warnings():
        # A name may have letters that the font lacks: the picture then has a box for each, or the reader's own font.
        warnings.filterwarnings("ignore", message="Glyph .* missing from", category=UserWarning)
        yield


def _height_in(section: Section) -> float:
    panels = sum(panel.weight for panel in section.panels) * _PANEL_IN
    return _REST_IN + panels + 0.12 * len(section.panels) + _ROW_IN * len(section.rows)


def _draw(section: Section, place: SubFigure) -> None:
    ratios = [panel.weight * _PANEL_IN for panel in section.panels]
    ratios += [_ROW_IN * len(section.rows) + 0.05] if section.rows else []
    columns = place.subplots(len(ratios), 1, sharex=True, height_ratios=ratios, squeeze=False)[:, 0]
    unit, seconds = section.unit
    for panel, axes in zip(section.panels, columns, strict=False):
        _panel(section, panel, axes, seconds)
        if panel.weight <= 1.0 and len(panel.curves) > 1:
            _own_legend(panel, axes)
    if section.rows:
        _bars(section, columns[-1], seconds)
    for axes in columns:
        axes.grid(alpha=0.3)
        axes.margins(x=0.0)
    first, last = float(section.time_s[0]), float(section.time_s[-1])
    if reaching_zero(first, last)[0] < first:
        columns[-1].set_xlim(left=0.0)
    columns[-1].set_xlabel(f"time, {unit}")
    _plain(place.suptitle("", fontsize=10), section.title)
    _legend(section, place)


def _plain(text: Text, content: str) -> None:
    """Show what a file named as it is: a dollar sign begins no formula."""
    text.set_parse_math(False)
    text.set_text(content)


def _panel(section: Section, panel: Panel, axes: Axes, seconds: float) -> None:
    if panel.zero:
        axes.axhline(0.0, color="0.5", linewidth=0.8, zorder=1)
    modelled = {curve.colour for curve in panel.curves if curve.role == "model"}
    for curve in panel.curves:
        x, y = (steps if curve.is_held else line)(section.time_s, curve.values, MOST_POINTS)
        faint = curve.role == "measured" and curve.colour in modelled
        ink = colour(curve.colour)
        axes.plot(x / seconds, y, color=ink, alpha=0.6 if faint else 1.0, **_look(curve))
        alone = lonely(y)
        if curve.role == "measured" and alone.any():
            axes.plot(x[alone] / seconds, y[alone], ".", color=ink, markersize=2.0, markeredgewidth=0.0)
    _plain(axes.yaxis.label, "\n".join(panel.label_lines))
    axes.yaxis.label.set_fontsize(9 if panel.weight > 1.0 else 7)
    axes.yaxis.set_major_locator(
        mpl.ticker.MaxNLocator(nbins=max(2, round(2.0 * panel.weight)), min_n_ticks=2, steps=[1, 2, 2.5, 5, 10])
    )


def _look(curve: Curve) -> dict[str, Any]:
    widths = {"measured": 0.8, "model": 1.6, "band": 0.9, "held": 0.9}
    return {
        "linewidth": widths[curve.role],
        "linestyle": ":" if curve.role == "band" else "-",
        "zorder": 3.0 if curve.role == "model" else 2.0,
    }


def _bars(section: Section, axes: Axes, seconds: float) -> None:
    rows = section.rows
    for bar in section.bars:
        both = len({other.kind for other in section.bars if other.name == bar.name}) > 1
        at = rows.index(bar.name) + (0.0 if not both else -0.17 if bar.kind == "recorded" else 0.17)
        width = max(bar.to_s - bar.from_s, 0.0) / seconds
        axes.barh(at, width, left=bar.from_s / seconds, height=0.28 if both else 0.5, color=BARS[bar.kind])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_yticks(np.arange(len(rows)), rows)
    for label in axes.get_yticklabels():
        label.set_parse_math(False)
    axes.tick_params(axis="y", labelsize=8)


def _legend(section: Section, place: SubFigure) -> None:
    handles = [Line2D([], [], color=colour(number), linewidth=1.6) for _, number in section.parts]
    names = [name for name, _ in section.parts]
    roles = [curve.role for panel in section.panels for curve in panel.curves]
    if any(curve.colour is None and curve.role == "measured" for curve in section.panels[0].curves):
        handles.append(Line2D([], [], color=INK, linewidth=0.8))
        names.append("ambient")
    if "model" in roles:
        handles += [Line2D([], [], color="0.2", linewidth=width) for width in (0.8, 1.6)]
        names += ["measured", "model"]
    if "band" in roles:
        handles.append(Line2D([], [], color="0.2", linewidth=0.9, linestyle=":"))
        names.append("alarm begins")
    for kind in dict.fromkeys(bar.kind for bar in section.bars):
        handles.append(Line2D([], [], color=BARS[kind], linewidth=4.0))
        names.append(BAR_NAMES[kind].replace(", ", ",\n"))
    if not handles:
        return
    legend: Legend = place.legend(handles, [" "] * len(handles), loc="outside right upper", fontsize=8, frameon=False)
    for text, name in zip(legend.get_texts(), names, strict=True):
        _plain(text, name)


def _own_legend(panel: Panel, axes: Axes) -> None:
    """Beside a panel of several channels, which have no colour in the section's legend."""
    handles = [Line2D([], [], color=colour(curve.colour), linewidth=1.6) for curve in panel.curves]
    legend = axes.legend(
        handles,
        [" "] * len(handles),
        loc="upper left",
        bbox_to_anchor=(1.0, 1.0),
        fontsize=min(7.0, _PANEL_PT / len(handles)),
        frameon=False,
        borderaxespad=0.2,
        labelspacing=0.2,
    )
    for text, curve in zip(legend.get_texts(), panel.curves, strict=True):
        _plain(text, curve.name)


def _numbered(svg: str) -> str:
    """The picture with its identifiers numbered as they come: matplotlib makes some of memory addresses."""
    names = dict.fromkeys(re.findall(r'\bid="(\w+)"', svg))
    numbers = {name: f"i{number}" for number, name in enumerate(names)}
    return re.sub(r'(\bid="|#)(\w+)(?=["\)])', lambda found: found[1] + numbers.get(found[2], found[2]), svg)
