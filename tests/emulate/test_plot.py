"""The picture of a run, by what stands in its SVG."""

from __future__ import annotations

import re

import numpy as np
import pytest

from gen.emulate.plot import _means, plot_svg
from gen.emulate.results import Alarm, Results


def run(length_s: float, rows: int = 50) -> Results:
    time_s = np.linspace(0.0, length_s, rows)
    warm = 30.0 + time_s / length_s * 20.0
    columns = {
        "time_s": time_s,
        "pwm": np.full(rows, 153.0),
        "brush_degC": np.where(np.arange(rows) == 7, np.nan, warm + 1.0),
        "brush_model_degC": warm,
        "casing_model_degC": warm - 5.0,
        "ambient_degC": np.full(rows, 25.0),
    }
    return Results(columns, [Alarm("brush_hot", length_s / 2, None, None)], [], [], 0)


def text(svg: str) -> list[str]:
    return re.findall(r"<text[^>]*>([^<]*)</text>", svg)


@pytest.mark.parametrize(("length_s", "unit"), [(60.0, "s"), (600.0, "min"), (7200.0, "min"), (10_800.0, "h")])
def test_the_time_axis_suits_the_run(length_s: float, unit: str) -> None:
    svg = plot_svg(run(length_s), "a motor")
    assert f"time, {unit}" in text(svg)
    assert {"a motor", "brush", "casing", "ambient", "brush_hot", "dots: measured"} <= set(text(svg))


def test_the_same_run_gives_the_same_picture() -> None:
    assert plot_svg(run(600.0), "a motor") == plot_svg(run(600.0), "a motor")


def test_a_run_without_rows_says_so() -> None:
    empty = Results({name: np.zeros(0) for name in ("time_s", "pwm")}, [], [], [], 0)
    assert "no rows" in text(plot_svg(empty, "nothing"))


def test_means_leave_out_what_was_not_measured() -> None:
    values = np.repeat([1.0, 2.0, np.nan], 120)
    values[0] = np.nan
    assert _means(values)[[0, 19]].tolist() == [1.0, 1.0]
    assert np.isnan(_means(values)[-20:]).all() and len(_means(values)) == 60
