"""Panels over one another with one axis of time, as inline SVG, coloured by the page's style sheet.

Drawn in a box of 360 units' width, about the width of a phone, so that letters stay readable there. What a line is
(``measured``, ``before``, ``after``, ``drive``, ``band``) is its class; the page gives colours and dashes to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from gen.pages.charts import inside, plain, reaching_zero, ticks

WIDTH = 360.0
_LEFT, _RIGHT, _TOP, _BOTTOM, _GAP = 54.0, 12.0, 24.0, 34.0, 13.0
_LEAST = 3
"""Ticks of an axis: fewer do not tell its scale."""


@dataclass(frozen=True)
class Course:
    """One quantity over time.

    Attributes
    ----------
    role
        What it is: the class of its path.
    x, y
        As many numbers each.
    shape
        "line", "dots", "steps" for what is held until the next point, or "area" for the outline of a surface.
    """

    role: str
    x: Sequence[float]
    y: Sequence[float]
    shape: str = "line"


@dataclass(frozen=True)
class Panel:
    """Courses over one vertical axis.

    Attributes
    ----------
    label
        Of the axis, with the unit.
    courses
        What is drawn, the last one on top.
    height
        In units.
    from_zero
        Whether zero belongs to the axis.
    reaching
        Values that belong to it as well, so that several drawings have one scale.
    """

    label: str
    courses: tuple[Course, ...]
    height: float
    from_zero: bool = False
    reaching: tuple[float, ...] = ()


@dataclass(frozen=True)
class Panels:
    """Panels from the top down.

    Attributes
    ----------
    identifier
        Unique on the page.
    title, description
        What is shown; the description is for those who do not see it.
    x_label
        Of the axis of time.
    panels
        At least one, with at least one point in each.
    """

    identifier: str
    title: str
    description: str
    x_label: str
    panels: tuple[Panel, ...]


def panels_svg(drawing: Panels) -> Markup:
    """Draw the panels: one ``svg`` element, its text escaped."""
    every = [x for panel in drawing.panels for course in panel.courses for x in course.x]
    across = _Scale(*reaching_zero(min(every), max(every)), _LEFT, WIDTH - _RIGHT)
    title, description = f"{drawing.identifier}-title", f"{drawing.identifier}-desc"
    parts = [
        f'<title id="{title}">{escape(drawing.title)}</title>',
        f'<desc id="{description}">{escape(drawing.description)}</desc>',
        _text(0.0, 13.0, drawing.title, "chart-title"),
    ]
    top = _TOP
    for panel in drawing.panels:
        parts += _panel(panel, across, top)
        top += panel.height + _GAP
    bottom = top - _GAP
    for value in ticks(across.low, across.high, about=5):
        x = across(value)
        parts.append(f'<path class="grid" d="M{x:.1f} {bottom:.1f}v4"/>')
        parts.append(_text(inside(x, plain(value), WIDTH), bottom + 15.0, plain(value), "tick middle"))
    parts.append(_text((_LEFT + WIDTH - _RIGHT) / 2.0, bottom + 30.0, drawing.x_label, "label middle"))
    head = f'<svg viewBox="0 0 {WIDTH:.0f} {bottom + _BOTTOM:.0f}" role="img" aria-labelledby="{title} {description}">'
    return Markup("\n".join([head, *parts, "</svg>"]))


@dataclass(frozen=True)
class _Scale:
    """Numbers from low to high on the units from start to end."""

    low: float
    high: float
    start: float
    end: float

    def __call__(self, value: float) -> float:
        span = self.high - self.low or 1.0
        return self.start + (value - self.low) / span * (self.end - self.start)


def _panel(panel: Panel, across: _Scale, top: float) -> list[str]:
    bottom = top + panel.height
    low, high = _range(panel)
    up = _Scale(low, high, bottom, top)
    parts = []
    for value in ticks(low, high, about=max(3, round(panel.height / 30.0)), least=_LEAST):
        y = up(value)
        parts.append(
            f'<path class="{"zero" if value == 0.0 else "grid"}" d="M{_LEFT:.1f} {y:.1f}H{WIDTH - _RIGHT:.1f}"/>'
        )
        parts.append(_text(_LEFT - 5.0, y + 4.0, plain(value), "tick end"))
    parts.append(f'<path class="axis" d="M{_LEFT:.1f} {top:.1f}V{bottom:.1f}H{WIDTH - _RIGHT:.1f}"/>')
    middle = (top + bottom) / 2.0
    turned = f'transform="translate(11.0 {middle:.1f}) rotate(-90)"'
    parts.append(f'<text class="label middle" {turned}>{escape(panel.label)}</text>')
    return [*parts, *(_course(course, across, up) for course in panel.courses)]


def _range(panel: Panel) -> tuple[float, float]:
    """From the least to the largest value, with a margin of a twentieth where it does not end at zero."""
    values = [y for course in panel.courses for y in course.y] + [0.0] * panel.from_zero + list(panel.reaching)
    low, high = min(values), max(values)
    margin = 0.05 * (high - low) or 0.5
    if not panel.from_zero:
        return low - margin, high + margin
    return (low - margin if low < 0.0 else 0.0), (high + margin if high > 0.0 or low == 0.0 else 0.0)


def _course(course: Course, across: _Scale, up: _Scale) -> str:
    points = [(across(x), up(y)) for x, y in zip(course.x, course.y, strict=True)]
    if course.shape == "dots":
        return f'<path class="{course.role}" d="{"".join(f"M{x:.1f} {y:.1f}h0" for x, y in points)}"/>'
    if course.shape == "steps":
        (x, y), *rest = points
        return f'<path class="{course.role}" d="M{x:.1f} {y:.1f}{"".join(f"H{x:.1f}V{y:.1f}" for x, y in rest)}"/>'
    end = "Z" if course.shape == "area" else ""
    return f'<path class="{course.role}" d="M{"L".join(f"{x:.1f} {y:.1f}" for x, y in points)}{end}"/>'


def _text(x: float, y: float, text: str, kind: str) -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}">{escape(text)}</text>'
