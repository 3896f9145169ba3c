"""Axes of the reports' own charts: enough ticks to tell the scale, and no label that the drawing's edge cuts."""

from __future__ import annotations

import re

import pytest

from gen.pages.charts import LETTER, WIDTH, Chart, Series, svg, ticks
from gen.pages.panels import WIDTH as PANELS_WIDTH
from gen.pages.panels import Course, Panel, Panels, panels_svg

MIDDLE = re.compile(r'<text class="tick middle" x="([\d.]+)" y="[\d.]+">([^<]*)<')
END = re.compile(r'<text class="tick end"[^>]*>([^<]*)<')


@pytest.mark.parametrize(("low", "high"), [(60.3, 99.0), (0.0, 210.0), (-241.0, 134.0), (20.05, 22.1), (-1e-3, 3e-3)])
def test_an_axis_has_three_ticks_at_least(low: float, high: float) -> None:
    course = Course("after", (0.0, 3600.0), (low, high))
    drawn = str(panels_svg(Panels("a", "casing", "", "time (s)", (Panel("°C", (course,), 48.0),))))
    assert len(END.findall(drawn)) >= 3
    assert ticks(low, high, least=3)[0] >= low


@pytest.mark.parametrize("last", [14_400.0, 15_000.0, 200_000.0])
def test_the_last_label_of_an_axis_of_time_is_whole(last: float) -> None:
    course = Course("after", (0.0, last), (1.0, 2.0))
    drawn = str(panels_svg(Panels("a", "casing", "", "time (s)", (Panel("°C", (course,), 130.0),))))
    chart = str(svg(Chart("b", "casing", "", "time (s)", "rise", "K", (Series("", (0.0, last), (1.0, 2.0), 0),))))
    for text, width in ((drawn, PANELS_WIDTH), (chart, WIDTH)):
        found = MIDDLE.findall(text)
        assert len(found) >= 3
        assert all(float(x) + 0.5 * LETTER * len(label) <= width + 0.1 for x, label in found)


@pytest.mark.parametrize(("first", "zero"), [(0.0, True), (0.25, True), (90.0, True), (2000.0, False)])
def test_an_axis_that_would_begin_shortly_after_0_begins_there(first: float, zero: bool) -> None:
    last = first + 3600.0
    course = Course("after", (first, last), (1.0, 2.0))
    drawn = str(panels_svg(Panels("a", "casing", "", "time (s)", (Panel("°C", (course,), 130.0),))))
    chart = str(svg(Chart("b", "casing", "", "time (s)", "rise", "K", (Series("", (first, last), (1.0, 2.0), 0),))))
    for text in (drawn, chart):
        assert ("0" in [label for _, label in MIDDLE.findall(text)]) == zero
