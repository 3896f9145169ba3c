"""The picture of a run, by what stands in its SVG."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from gen.drawing.interactive import figure_of
from gen.drawing.picture import picture
from gen.drawing.section import Bar, Curve, Panel, Section


def run(length_s: float, rows: int = 50) -> Section:
    time_s = np.linspace(0.0, length_s, rows)
    warm = 30.0 + time_s / length_s * 20.0
    seen = np.where(np.arange(rows) == 7, np.nan, warm + 1.0)
    temperatures = (
        Curve("ambient", "measured", None, np.full(rows, 25.0)),
        Curve("brush", "measured", 0, seen),
        Curve("brush", "model", 0, warm),
        Curve("casing", "model", 1, warm - 5.0),
    )
    panels = (Panel("temperature, °C", temperatures, 4.0), Panel("a" * 200, temperatures[1:2], 1.0))
    bars = (Bar("brush_hot", "recorded", length_s / 2, length_s),)
    return Section("a motor", (), time_s, panels, bars, (("brush", 0), ("casing", 1)))


def text(section: Section) -> list[str]:
    return re.findall(r"<text[^>]*>([^<]*)</text>", picture([section], "svg").decode())


@pytest.mark.parametrize(("length_s", "unit"), [(60.0, "s"), (600.0, "min"), (7200.0, "min"), (10_800.0, "h")])
def test_the_time_axis_suits_the_run(length_s: float, unit: str) -> None:
    found = text(run(length_s))
    assert f"time, {unit}" in found
    assert {"a motor", "brush", "casing", "ambient", "brush_hot", "measured", "model"} <= set(found)


@pytest.mark.parametrize("begin_s", [0.2, 30.0])
def test_a_run_that_begins_shortly_after_0_is_drawn_from_0(begin_s: float) -> None:
    drawn = run(1200.0)
    late = replace(drawn, time_s=drawn.time_s + begin_s)
    assert "0.0" in text(late) or "0" in text(late)
    layout = figure_of(late, gl=False, most=1000)["layout"]
    assert layout["xaxis"]["range"][0] == 0.0
    much_later = replace(drawn, time_s=drawn.time_s + 600.0)
    assert figure_of(much_later, gl=False, most=1000)["layout"]["xaxis"]["range"][0] == 10.0


def test_the_same_run_gives_the_same_picture() -> None:
    assert picture([run(600.0)], "svg") == picture([run(600.0)], "svg")


@pytest.mark.parametrize(
    ("label", "lines"),
    [
        ("temperature, °C", ("temperature, °C",)),
        ("electrical_power, W (255 = 5)", ("electrical_power,", "W (255 = 5)")),
        ("duty_of_the_second_heater_percent", ("duty_of_the_", "second_heater_", "percent")),
        ("a" * 30, ("a" * 17, "a" * 13)),
        ("b " * 90, (*[" ".join("b" * 9)] * 5, f"{' '.join('b' * 8)} …")),
        ("", ("",)),
    ],
)
def test_a_label_is_whole_in_lines_that_its_axis_has_room_for(label: str, lines: tuple[str, ...]) -> None:
    assert Panel(label, (), 1.0).label_lines == lines


def test_a_long_name_of_the_input_is_whole_in_the_picture() -> None:
    assert "a" * 17 in text(run(600.0))
