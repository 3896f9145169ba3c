"""What a page is made of: which sources know of a coefficient file, and which one has the control of the pace."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gen.coefficients import load, parse
from gen.errors import InputError
from gen.live.making import Emulation, make_sources
from tests.examples import ROOT

EXAMPLE = ROOT / "examples" / "my1016" / "coeffs.json"
BAUD = 115_200


@pytest.fixture
def runs(tmp_path: Path) -> list[Path]:
    paths = [tmp_path / "first.csv", tmp_path / "second.csv"]
    for path in paths:
        path.write_text("time_s,pwm,brush_degC\n0,0,30\n1,90,31\n", encoding="utf-8")
    return paths


def test_runs_are_read_with_the_coefficient_file_or_without_one(runs: list[Path]) -> None:
    model = load(EXAMPLE)
    (bare,) = make_sources(runs[:1], None, [], 1.0, BAUD)
    (told,) = make_sources(runs[:1], model, [], 1.0, BAUD)
    assert bare.view.known.channels == ()
    assert told.view.known.channels == ("brush", "bearing", "magnet", "casing", "ambient")
    assert told.view.known.rules == tuple(rule.name for rule in model.document.alarms)


def test_the_first_run_alone_has_the_control_of_the_pace(runs: list[Path]) -> None:
    paced = [[control.name for control in source.controls()] for source in make_sources(runs, None, [], 1.0, BAUD)]
    assert ["pace" in names for names in paced] == [True, False]


def test_a_board_without_thermocouples_is_nothing_to_emulate(tmp_path: Path) -> None:
    tree = json.loads(EXAMPLE.read_text(encoding="utf-8"))
    tree["wiring"]["thermocouples"] = []
    bare = Emulation(parse(json.dumps(tree).encode()), tmp_path / "coeffs.json", None, 20.0, "")
    with pytest.raises(InputError, match="has no thermocouples"):
        make_sources([], None, [bare], 1.0, BAUD)
