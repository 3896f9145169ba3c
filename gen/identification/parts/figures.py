"""The report's plots: inline SVG by matplotlib, the same bytes for the same data."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from gen.arrays import FloatArray
from gen.identification.parts.identify import Identified
from gen.identification.parts.uncertainty import residual_noise

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#0b62a8", "#c4520a", "#1a7f4b", "#8a3fa0", "#9a7400", "#b3234f", "#5b6570", "#3f3a9e")
_POINTS = 300
_HOUR = 3600.0
_PAD_IN = 0.12
"""Room at the sides of a plot."""


@dataclass(frozen=True)
class Drawn:
    """A chart and its legend, which stands below it as text, as large on a phone as on a desk.

    Attributes
    ----------
    svg
        Inline SVG.
    legend
        Label and colour (CSS) of each line.
    """

    svg: Markup
    legend: tuple[tuple[str, str], ...] = ()


def _figure(width: float = 5.6, height: float = 3.4) -> tuple[Figure, Axes]:
    # The object-oriented interface: no global state, no display.
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    # The reader's font may be wider than the one that is measured here: the last label of an axis keeps its end.
    figure = Figure(figsize=(width, height), layout=ConstrainedLayoutEngine(w_pad=_PAD_IN))
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    axes.grid(True, color="#d5d9dd", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return figure, axes


def _legend(axes: Axes) -> tuple[tuple[str, str], ...]:
    """The labels that lines were given, with their colours."""
    from matplotlib.colors import to_hex
    from matplotlib.container import ErrorbarContainer

    handles, labels = axes.get_legend_handles_labels()
    lines: list[Any] = [handle[0] if isinstance(handle, ErrorbarContainer) else handle for handle in handles]
    return tuple((label, to_hex(line.get_color())) for label, line in zip(labels, lines, strict=True))


def _drawn(figure: Figure, identifier: str, description: str) -> Drawn:
    import matplotlib

    stream = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": identifier, "svg.fonttype": "none", "font.size": 11}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    # Identifiers must be unique on a page with many figures, and only inline references are left.
    text = re.sub(r'id="([^"]+)"', rf'id="{identifier}-\1"', text)
    text = re.sub(r"url\(#([^)]+)\)", rf"url(#{identifier}-\1)", text)
    text = re.sub(r'xlink:href="#([^"]+)"', rf'href="#{identifier}-\1"', text)
    text = re.sub(r' xmlns:xlink="[^"]*"| xmlns="[^"]*"', "", text)
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = text.replace("<svg", f'<svg role="img" aria-label="{description}"', 1)
    return Drawn(Markup(text), _legend(figure.axes[0]))


def _thin(*arrays: FloatArray) -> tuple[FloatArray, ...]:
    keep = np.unique(np.linspace(0, len(arrays[0]) - 1, min(_POINTS, len(arrays[0]))).astype(np.int64))
    return tuple(a[keep] for a in arrays)


def fits(item: Identified) -> Drawn:
    """Measured rise (dots) and the general model's free run (lines) over time."""
    figure, axes = _figure()
    for r, record in enumerate(item.problem.records):
        colour = _COLOURS[r % len(_COLOURS)]
        time, rise, residual = _thin(record.time, record.rise, item.model.residuals[r])
        axes.plot(time / _HOUR, rise, ".", color=colour, markersize=2.5, alpha=0.5)
        axes.plot(time / _HOUR, rise - residual, "-", color=colour, linewidth=1.3, label=record.run)
    axes.set_xlabel("time (h)")
    axes.set_ylabel("rise over ambient (K)")
    return _drawn(figure, f"fit-{item.name}", f"Measured and simulated rise of {item.name}")


def residuals(item: Identified) -> Drawn:
    """Block means of measured minus model over time."""
    figure, axes = _figure()
    for r, record in enumerate(item.problem.records):
        noise = residual_noise(record, item.model.residuals[r], 0.0)
        middle = (np.arange(len(noise.blocks)) + 0.5) * noise.block_s
        axes.plot(middle / _HOUR, noise.blocks, "-", color=_COLOURS[r % len(_COLOURS)], linewidth=0.9, label=record.run)
    axes.axhline(0.0, color="#59626c", linewidth=0.8)
    axes.set_xlabel("time (h)")
    axes.set_ylabel("measured minus model (K)")
    return _drawn(figure, f"res-{item.name}", f"Residual of {item.name} over time")


def rises(item: Identified) -> Drawn:
    """Steady rise over PWM: speeds with their intervals, the schedule with its band, left-out predictions."""
    figure, axes = _figure()
    band, layout = item.band, item.fit.layout
    speeds = np.array(item.speeds, dtype=np.float64)
    if len(speeds) > 1:
        width = 1.96 * band.total_K
        axes.fill_between(
            band.pwm, band.steady - width, band.steady + width, color=_COLOURS[0], alpha=0.18, linewidth=0
        )
    axes.plot(band.pwm, band.steady, color=_COLOURS[0], linewidth=1.4, label="schedule, 95 % band")
    deviation = item.spread.deviation[layout.thetas : layout.thetas + len(speeds)]
    axes.errorbar(
        speeds,
        item.fit.steady,
        item.spread.factor * deviation,
        fmt="o",
        color=_COLOURS[1],
        markersize=4,
        label="identified",
    )
    left = item.general.chosen.left_out
    if left is not None:
        axes.plot(speeds, item.fit.steady + left.steady_K, "x", color=_COLOURS[3], label="predicted when left out")
    if item.linearity.linear is not None:
        averaged = item.fit.steady + item.linearity.averaged_K
        axes.plot(speeds, averaged, "--", color=_COLOURS[6], linewidth=0.9, label="averaged poles")
    axes.set_xlabel("|PWM| (counts)")
    axes.set_ylabel("steady rise (K)")
    return _drawn(figure, f"rise-{item.name}", f"Steady rise of {item.name} over PWM")


def times(item: Identified) -> Drawn:
    """Structure parameters over PWM with intervals and band."""
    figure, axes = _figure()
    layout = item.fit.layout
    nodes = layout.nodes.astype(np.float64)
    deviation = item.spread.deviation[: layout.thetas].reshape(-1, layout.order)
    pwm = np.arange(nodes[0], nodes[-1] + 1.0)
    theta, sd = item.model.evaluate(np.maximum(pwm, 1e-3))[0], item.model.theta_sd(np.maximum(pwm, 1e-3))
    labels = [label for label in layout.structure.labels if label != "zeta"]
    width = np.minimum(1.96 * sd, 3.0)  # a factor of 20: beyond it nothing is known
    for k, label in enumerate(labels):
        colour = _COLOURS[k]
        axes.fill_between(
            pwm, np.exp(theta[:, k] - width[:, k]), np.exp(theta[:, k] + width[:, k]), color=colour, alpha=0.18
        )
        axes.plot(pwm, np.exp(theta[:, k]), color=colour, linewidth=1.3, label=label)
        bound = np.minimum(item.spread.factor * deviation[:, k], 3.0)
        value = np.exp(item.fit.theta[:, k])
        spans = np.stack([value - value * np.exp(-bound), value * np.exp(bound) - value])
        axes.errorbar(nodes, value, spans, fmt="o", color=colour, markersize=4)
    axes.set_yscale("log")
    axes.set_xlabel("|PWM| (counts)")
    axes.set_ylabel("time constant (s)")
    return _drawn(figure, f"tau-{item.name}", f"Time constants of {item.name} over PWM")


def pole_map(item: Identified) -> Drawn:
    """Poles in the complex plane, one colour a speed, with their mean."""
    figure, axes = _figure()
    line = item.linearity
    for i, pwm in enumerate(item.speeds):
        poles = line.poles[i]
        axes.plot(
            poles.real * 1e3, poles.imag * 1e3, "x", color=_COLOURS[i % len(_COLOURS)], markersize=6, label=f"PWM {pwm}"
        )
    axes.plot(line.mean.real * 1e3, line.mean.imag * 1e3, "+", color="#1d2126", markersize=11, label="mean")
    axes.axhline(0.0, color="#59626c", linewidth=0.8)
    axes.axvline(0.0, color="#59626c", linewidth=0.8)
    axes.set_xlabel("real part (10⁻³ rad/s)")
    axes.set_ylabel("imaginary part (10⁻³ rad/s)")
    return _drawn(figure, f"map-{item.name}", f"Pole map of {item.name}")
