"""Small line charts as inline SVG: the same bytes everywhere, coloured by the page's style sheet.

A chart is drawn in a box of 440 x 270 units and scales with the page.  Coordinates are printed with one decimal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, log10

from markupsafe import Markup, escape

WIDTH, HEIGHT = 440.0, 270.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 58.0, 12.0, 42.0, 44.0
_LEGEND_Y = 33.0
LETTER = 6.1
_SHORTLY = 0.1
"""Of what the data span: how far behind 0 an axis begins there."""
"""Width of one, on average."""
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Series:
    """One line, or dots.

    Attributes
    ----------
    label
        For the legend; empty for none.
    x, y
        As many numbers each.
    style
        Which of the page's line styles, 0..7.
    dots
        Draw dots instead of a line.
    """

    label: str
    x: Sequence[float]
    y: Sequence[float]
    style: int = 0
    dots: bool = False


@dataclass(frozen=True)
class Chart:
    """A chart of several lines over one axis.

    Attributes
    ----------
    identifier
        Unique on the page.
    title, description
        What is shown; the description is for those who do not see it.
    x_label, y_label, y_unit
        Axis names; the unit gets a power of ten where the numbers need one.
    series
        What is drawn.
    log_y
        Whether the vertical axis is logarithmic; every y is then positive.
    shade
        A range of x with a background, or None.
    """

    identifier: str
    title: str
    description: str
    x_label: str
    y_label: str
    y_unit: str
    series: tuple[Series, ...]
    log_y: bool = False
    shade: tuple[float, float] | None = None


def plain(value: float) -> str:
    """A tick's number, with a true minus sign."""
    return f"{value:.6g}".replace("-", "−")


def scientific(value: float) -> str:
    """Four significant digits, with a power of ten where the number is small."""
    mantissa, _, exponent = f"{value:.4g}".replace("-", "−").partition("e")
    if not exponent:
        return mantissa
    return f"{mantissa} × {power(10, int(exponent.replace('−', '-')))}"


def power(base: int, exponent: int) -> str:
    """``base`` with a raised exponent."""
    return f"{base}{str(exponent).translate(SUPERSCRIPT)}"


def ticks(low: float, high: float, about: int = 5, least: int = 0) -> list[float]:
    """Round numbers from low to high, their distance 1, 2 or 5 times a power of ten; finer where there are too few."""
    raw = (high - low) / about
    power = 10.0 ** floor(log10(raw))
    step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= raw * (1.0 - 1e-9))
    first, last = ceil(low / step - 1e-6), floor(high / step + 1e-6)
    if last - first + 1 < least:
        return ticks(low, high, about + 1, least)
    return [float(f"{k * step:.9g}") + 0.0 for k in range(first, last + 1)]


def reaching_zero(low: float, high: float) -> tuple[float, float]:
    """An axis that would begin shortly after 0 begins there, so that it has a tick at 0.

    Parameters
    ----------
    low, high
        From where to where the data go.
    """
    return (0.0 if 0.0 < low <= _SHORTLY * (high - low) else low, high)


def inside(x: float, label: str, width: float) -> float:
    """Give where the middle of a label has to be, so that a drawing of that width does not cut its end."""
    return min(x, width - 0.5 * LETTER * len(label))


def log_ticks(low: float, high: float) -> list[float]:
    """1, 2 and 5 times powers of ten from low to high; powers alone when there are many."""
    powers = range(floor(log10(low)), ceil(log10(high)) + 1)
    factors = (1.0, 2.0, 5.0) if log10(high / low) < 2.5 else (1.0,)
    values = (float(f"{factor}e{power}") for power in powers for factor in factors)
    return [value for value in values if low * 0.999 <= value <= high * 1.001]


def svg(chart: Chart) -> Markup:
    """Draw a chart: one ``svg`` element, its text escaped."""
    return _Drawing(chart).markup()


class _Drawing:
    def __init__(self, chart: Chart) -> None:
        self._chart = chart
        values = [value for series in chart.series for value in series.y]
        positions = [value for series in chart.series for value in series.x]
        self._exponent = 0 if chart.log_y else _exponent(max(map(abs, values)))
        first, last = min(positions), max(positions)
        self._x_range = reaching_zero(first, last) if last > first else (first, first + 1.0)
        self._y_range = self._vertical([value / 10.0**self._exponent for value in values])

    def _vertical(self, values: list[float]) -> tuple[float, float]:
        low, high = min(values), max(values)
        if self._chart.log_y:
            return (low / 1.3, high * 1.3)
        if low >= 0.0:
            return (0.0, high * 1.06 or 1.0)
        if high <= 0.0:
            return (low * 1.06, 0.0)
        margin = 0.06 * (high - low)
        return (low - margin, high + margin)

    def _x(self, value: float) -> float:
        low, high = self._x_range
        return _LEFT + (value - low) / (high - low) * (WIDTH - _LEFT - _RIGHT)

    def _y(self, value: float) -> float:
        low, high = self._y_range
        share = log10(value / low) / log10(high / low) if self._chart.log_y else (value - low) / (high - low)
        return HEIGHT - _BOTTOM - share * (HEIGHT - _TOP - _BOTTOM)

    def markup(self) -> Markup:
        chart = self._chart
        title, description = f"{chart.identifier}-title", f"{chart.identifier}-desc"
        parts = [
            f'<svg viewBox="0 0 {WIDTH:.0f} {HEIGHT:.0f}" role="img" aria-labelledby="{title} {description}">',
            f'<title id="{title}">{escape(chart.title)}</title>',
            f'<desc id="{description}">{escape(chart.description)}</desc>',
            _text(0.0, 14.0, chart.title, "chart-title"),
            *self._shade(),
            *self._axes(),
            *self._legend(),
            *(self._series(series) for series in chart.series),
            "</svg>",
        ]
        return Markup("\n".join(parts))

    def _shade(self) -> list[str]:
        if self._chart.shade is None:
            return []
        left, right = (self._x(min(max(end, self._x_range[0]), self._x_range[1])) for end in self._chart.shade)
        height = HEIGHT - _TOP - _BOTTOM
        return [f'<rect class="valid" x="{left:.1f}" y="{_TOP:.1f}" width="{right - left:.1f}" height="{height:.1f}"/>']

    def _axes(self) -> list[str]:
        chart, bottom, right = self._chart, HEIGHT - _BOTTOM, WIDTH - _RIGHT
        parts = []
        rows = log_ticks(*self._y_range) if chart.log_y else ticks(*self._y_range)
        for value in rows:
            y = self._y(value)
            kind = "zero" if value == 0.0 else "grid"
            parts.append(f'<path class="{kind}" d="M{_LEFT:.1f} {y:.1f}H{right:.1f}"/>')
            parts.append(_text(_LEFT - 6.0, y + 4.0, plain(value), "tick end"))
        for value in ticks(*self._x_range, about=6):
            x = self._x(value)
            parts.append(f'<path class="grid" d="M{x:.1f} {bottom:.1f}v4"/>')
            parts.append(_text(inside(x, plain(value), WIDTH), bottom + 16.0, plain(value), "tick middle"))
        parts.append(f'<path class="axis" d="M{_LEFT:.1f} {_TOP:.1f}V{bottom:.1f}H{right:.1f}"/>')
        parts.append(_text((_LEFT + right) / 2.0, HEIGHT - 8.0, chart.x_label, "label middle"))
        scale = f"{power(10, self._exponent)} " if self._exponent else ""
        unit = f"{chart.y_label} ({scale}{chart.y_unit})"
        centre = (_TOP + bottom) / 2.0
        parts.append(
            f'<text class="label middle" transform="translate(12.0 {centre:.1f}) rotate(-90)">{escape(unit)}</text>'
        )
        return parts

    def _legend(self) -> list[str]:
        parts, x = [], _LEFT
        for series in self._chart.series:
            if not series.label:
                continue
            if series.dots:
                parts.append(f'<circle class="d{series.style}" cx="{x + 9.0:.1f}" cy="{_LEGEND_Y - 4.0:.1f}" r="2"/>')
            else:
                parts.append(f'<path class="line s{series.style}" d="M{x:.1f} {_LEGEND_Y - 4.0:.1f}h18"/>')
            parts.append(_text(x + 22.0, _LEGEND_Y, series.label, "tick"))
            x += 22.0 + LETTER * len(series.label) + 12.0
        return parts

    def _series(self, series: Series) -> str:
        scale = 10.0**self._exponent
        points = [(self._x(x), self._y(y / scale)) for x, y in zip(series.x, series.y, strict=True)]
        if series.dots:
            marks = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in points)
            return f'<path class="dots d{series.style}" d="{marks}"/>'
        line = "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
        return f'<path class="line s{series.style}" d="M{line}"/>'


def _exponent(largest: float) -> int:
    """A multiple of 3 that takes numbers like this one to 1..1000, 0 for such that need none."""
    if largest == 0.0 or 0.05 <= largest < 1e5:
        return 0
    return 3 * floor(log10(largest) / 3.0)


def _text(x: float, y: float, text: str, kind: str) -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}">{escape(text)}</text>'
