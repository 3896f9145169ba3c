"""What a fleet's pages draw."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from gen.fleet.folder.store import Store
from gen.fleet.report import pages_of


def test_a_sparkline_stands_in_the_middle_of_its_picture_with_0_K_at_the_bottom(tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    course = [0.0, 0.4, None, 0.8, 0.2]
    state = {"motor": "a", "state": "ok", "said": "", "course_K": course, "days": ["2026-01-01"] * 5}
    store.write("watch.json", json.dumps({"motors": [state], "common": [], "limit": 4.0, "level": 0.01}).encode())
    page = pages_of(store)["index.html"]
    size = re.search(r'viewBox="0 0 (\d+) (\d+)"', page)
    drawn = re.search(r'<polyline points="([^"]*)"', page)
    assert size is not None
    assert drawn is not None
    width, height = float(size[1]), float(size[2])
    points = [tuple(map(float, point.split(","))) for point in drawn[1].split()]
    x, y = zip(*points, strict=True)
    assert min(x) == pytest.approx(width - max(x))  # as much room on the left as on the right ..
    assert min(y) == pytest.approx(height - max(y))  # .. and above as below
    assert y[0] == max(y)
    assert y[2] == min(y)
    assert y[1] == pytest.approx(0.5 * (max(y) + min(y)), abs=0.051)
    assert x[2] - x[1] == pytest.approx(2.0 * (x[1] - x[0]), abs=0.21)  # the run without an error leaves its place
