"""`gen plot`: what is in the pictures, that they need nothing else, and that names in a run file stay text."""

from __future__ import annotations

import base64
import json
import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from gen.arrays import FloatArray
from gen.cli import cli
from gen.coefficients import load
from gen.drawing import interactive, picture
from gen.drawing.content import section_of
from gen.drawing.faults import declared
from gen.drawing.interactive import figure_of
from gen.drawing.section import Section
from gen.errors import InputError
from gen.runs import Run, read_run, write_run
from tests.examples import ROOT

RIG = ROOT / "examples" / "my1016_rig" / "coeffs.json"
NETWORK = ROOT / "examples" / "network" / "coeffs.json"
HOSTILE = "</script><script>alert(1)</script><img src=http://x.org/a.png onerror=alert(2)>$\\frac%{x}&amp;"


def plot(*arguments: str | Path) -> str:
    done = CliRunner().invoke(cli, ["plot", *(str(argument) for argument in arguments)], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


def rig_run(path: Path, hours: float = 3.0, step_s: float = 1.0, fault_K: float = 0.0) -> Path:
    """The rig's parts near their model, with a board's columns; after an hour one is off by a fault."""
    time = np.arange(0.0, hours * 3600.0, step_s)
    pwm = np.where(time % 7200.0 < 5400.0, 150, 60)
    rng = np.random.default_rng(0)
    rise = 20.0 * -np.expm1(-time / 2000.0)
    temps = {name: 25.0 + rise + rng.normal(0.0, 0.2, time.size) for name in ("brush", "bearing", "magnet", "casing")}
    temps["casing"] = temps["casing"] + np.where(time > 3600.0, fault_K, 0.0)
    temps["magnet"][100:400] = np.nan
    extras = {"speed_rpm": pwm * 10.0, "current_A": pwm / 50.0 + rng.normal(0.0, 0.05, time.size)}
    write_run(path, Run(time, pwm, temps, np.full(time.size, 25.0), extras, {"fault": "bearing from 3600 s"}))
    return path


class Elements(HTMLParser):
    """Tags with their attributes, and the text of each script element."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.scripts: list[str] = []
        self.shown = ""
        self._in_script = False
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, {key: value or "" for key, value in attributes}))
        self._in_script = tag == "script"
        if self._in_script:
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        self._in_script = False

    def handle_data(self, data: str) -> None:
        if self._in_script:
            self.scripts[-1] += data
        else:
            self.shown += data


def figures(page: Path) -> list[dict[str, Any]]:
    found = Elements(page.read_text(encoding="utf-8"))
    types = [attributes.get("type") for tag, attributes in found.tags if tag == "script"]
    return [json.loads(text) for text, kind in zip(found.scripts, types, strict=True) if kind == "application/json"]


def numbers(packed: dict[str, str] | list[float]) -> FloatArray:
    """An array as the plot library packs it."""
    if isinstance(packed, list):
        return np.array(packed, dtype=np.float64)
    return np.frombuffer(base64.b64decode(packed["bdata"]), dtype=packed["dtype"]).astype(np.float64)


def trace(figure: dict[str, Any], name: str, extra: str) -> tuple[FloatArray, FloatArray]:
    """Time in the axis's unit and values of the first curve whose hover text ends so."""
    for found in figure["data"]:
        if found["name"] == name and str(found.get("hovertemplate", "")).endswith(f"<extra>{extra}</extra>"):
            return numbers(found["x"]), numbers(found["y"])
    raise AssertionError(f"no curve {name}")


@pytest.mark.parametrize("coefficients", [RIG, NETWORK], ids=["transfer functions", "network"])
def test_the_modelled_curve_is_what_simulate_writes(coefficients: Path, tmp_path: Path) -> None:
    run = rig_run(tmp_path / "run.csv")
    text = run.read_text().splitlines()
    head = next(i for i, row in enumerate(text) if row.startswith("time_s"))
    run.write_text(
        "\n".join(row + (",fan_percent" if i == head else ",40" if i > head else "") for i, row in enumerate(text))
    )
    plot(run, "--model", coefficients, "--out", tmp_path / "run.html")
    simulated = ["simulate", str(coefficients), str(run), "--arithmetic", "exact", "--out", str(tmp_path / "model.csv")]
    assert CliRunner().invoke(cli, simulated).exit_code == 0
    written = pd.read_csv(tmp_path / "model.csv", comment="#")
    (figure,) = figures(tmp_path / "run.html")
    measured = read_run(run)
    for part in load(coefficients).model.component_names:
        x, y = trace(figure, part, f"{part} model")
        np.testing.assert_allclose(np.interp(x * 3600.0, written["time_s"], written[f"{part}_degC"]), y, atol=1e-9)
        (residual,) = [
            numbers(found["y"])
            for found in figure["data"]
            if (found["name"], found["yaxis"]) == (part, "y2") and "hovertemplate" in found
        ]
        difference = measured.temps[part] - written[f"{part}_degC"].to_numpy()
        assert np.nanmax(residual) == pytest.approx(np.nanmax(difference), abs=1e-9)
        assert np.nanmin(residual) == pytest.approx(np.nanmin(difference), abs=1e-9)


@pytest.mark.parametrize(("ends_s", "unit"), [(180.0, "s"), (181.0, "min"), (7200.0, "min"), (7201.0, "h")])
def test_the_axis_has_the_unit_of_the_whole_run(ends_s: float, unit: str) -> None:
    """Also where a gap is most of it."""
    section = Section("", (), np.array([0.0, ends_s - 1.0, ends_s]), (), (), ())
    assert section.unit[0] == unit


def test_columns_of_one_unit_share_an_axis_and_those_without_have_their_own(tmp_path: Path) -> None:
    """A controller's output of 0 to 1 beside its set point of 60 would be a line along the bottom."""
    names = ("current_A", "other_A", "output", "setpoint", "channel_1", "channel_2")
    rows = [f"{k},100,{25 + k}," + ",".join(str(n * 10 + k % 2) for n in range(len(names))) for k in range(10)]
    path = tmp_path / "run.csv"
    path.write_text("\n".join(["time_s,pwm,casing_degC," + ",".join(names), *rows]) + "\n", encoding="utf-8")
    labels = [panel.label for panel in section_of(path, None).panels]
    assert labels[2:] == ["current_A, other_A", "output", "setpoint", "channel_1", "channel_2"]


def test_channels_that_share_an_axis_are_told_apart_in_a_picture(tmp_path: Path) -> None:
    run = tmp_path / "run.csv"
    run.write_text("time_s,pwm,winding_degC,motor_A,battery_A\n0,0,20,1,2\n60,0,20,1,2\n", encoding="utf-8")
    plot(run, "--out", tmp_path / "run.svg")
    texts = [
        element.text for element in ET.parse(tmp_path / "run.svg").getroot().iter() if element.tag.endswith("text")
    ]
    assert {"motor_A", "battery_A"} <= set(texts)


def test_a_day_at_4_hz_is_drawn_with_as_many_points_as_can_be_seen(tmp_path: Path) -> None:
    path = rig_run(tmp_path / "day.csv", hours=24.0, step_s=0.25)
    section = section_of(path, load(RIG))
    assert section.time_s.size == 24 * 3600 * 4
    figure = figure_of(section, gl=True, most=interactive.MOST_POINTS)
    assert max(len(found.x) for found in figure.data) <= interactive.MOST_POINTS
    measured = read_run(path).temps["casing"]
    own = [found for found in figure.data if found.name == "casing" and found.yaxis == "y"]
    drawn = np.concatenate([np.asarray(found.y) for found in own])
    assert measured.max() in drawn
    assert figure.layout.xaxis.range == (0.0, pytest.approx(24.0, abs=0.01))
    assert measured.min() in drawn
    svg = picture.picture([section], "svg").decode()
    assert max(points.count("L") for points in re.findall(r' d="([^"]+)"', svg)) <= picture.MOST_POINTS


def test_a_gap_is_a_gap_in_the_page(tmp_path: Path) -> None:
    plot(rig_run(tmp_path / "run.csv"), "--out", tmp_path / "run.html")
    x, y = trace(figures(tmp_path / "run.html")[0], "magnet", "magnet")
    (gap,) = np.flatnonzero(np.isnan(y))
    np.testing.assert_allclose(np.array([x[gap - 1], x[gap + 1]]) * 3600.0, [99.0, 400.0])


def test_the_page_holds_all_that_it_needs(tmp_path: Path) -> None:
    plot(rig_run(tmp_path / "run.csv"), "--model", RIG, "--out", tmp_path / "run.html")
    found = Elements((tmp_path / "run.html").read_text(encoding="utf-8"))
    loads = {"src", "href", "data", "srcset", "poster", "action"}
    assert not [tag for tag, attributes in found.tags if loads & set(attributes) or tag in ("link", "iframe", "object")]
    (policy,) = [own["content"] for tag, own in found.tags if tag == "meta" and "http-equiv" in own]
    assert policy.startswith("default-src 'none';")
    assert "http" not in policy
    assert sum("plotly.js v" in script for script in found.scripts) == 1


def hostile(path: Path) -> Path:
    name = HOSTILE.replace(",", "")
    rows = "".join(f"{i},{i % 200},{30 + i % 7},{i % 5},{i % 3}\n" for i in range(50))
    path.write_text(
        f"# fault: {name} from 5 s\n# {name}: {name}\ntime_s,pwm,{name}_degC,{name}_A,_hidden\x01_A\n{rows}"
    )
    return path


def test_names_in_a_run_file_stay_text_in_the_page(tmp_path: Path) -> None:
    plot(hostile(tmp_path / "<b>run.csv"), "--out", tmp_path / "run.html")
    text = (tmp_path / "run.html").read_text(encoding="utf-8")
    found = Elements(text)
    expected = [
        "html",
        "head",
        "meta",
        "meta",
        "meta",
        "meta",
        "title",
        "style",
        "body",
        "h1",
        "p",
        "section",
        "p",
        "span",
    ]
    assert [tag for tag, _ in found.tags] == [*expected, "div", "script", "script", "script"]
    assert "<b>run" in found.shown
    (figure,) = figures(tmp_path / "run.html")
    named = [item["name"] for item in figure["data"]]
    named += [
        str(item.get("hovertemplate", "")).partition("<extra>")[2].removesuffix("</extra>") for item in figure["data"]
    ]
    named += [item for axis in figure["layout"].values() if isinstance(axis, dict) for item in axis.get("ticktext", [])]
    assert any("alert" in name for name in named)
    # The plot library knows tags of its own, and templates: neither is left in a name.
    assert not [name for name in named if re.search(r"<|%\{", name)]


def test_names_in_a_run_file_stay_text_in_the_picture(tmp_path: Path) -> None:
    for form in ("svg", "png"):
        plot(hostile(tmp_path / "run.csv"), "--out", tmp_path / f"run.{form}")
    root = ET.parse(tmp_path / "run.svg").getroot()
    assert not [element for element in root.iter() if element.tag.endswith(("script", "image", "img"))]
    texts = "".join("".join(element.itertext()) for element in root.iter() if element.tag.endswith("text"))
    assert HOSTILE[:40] in texts
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


def test_several_runs_stand_one_after_the_other_and_the_same_input_gives_the_same_bytes(tmp_path: Path) -> None:
    runs = [rig_run(tmp_path / f"run{i}.csv", hours=1.0 + i) for i in range(2)]
    for form in ("svg", "html"):
        made = []
        for _ in range(2):
            plot(*runs, "--model", RIG, "--out", tmp_path / f"two.{form}")
            made.append((tmp_path / f"two.{form}").read_bytes())
        assert made[0] == made[1]
    assert len(figures(tmp_path / "two.html")) == 2
    texts = [
        element.text for element in ET.parse(tmp_path / "two.svg").getroot().iter() if element.tag.endswith("text")
    ]
    assert texts.index("run0") < texts.index("run1")


def test_without_out_a_page_is_written_beside_the_first_run(tmp_path: Path) -> None:
    said = plot(rig_run(tmp_path / "run.csv"))
    assert (tmp_path / "run.html").is_file()
    assert f"{tmp_path / 'run.html'}: 1 run drawn" in said


def test_a_part_without_a_measurement_is_said(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("time_s,pwm,brush_degC,casing_degC,ambient_degC\n0,9,25,,25\n60,9,26,,25\n")
    said = plot(tmp_path / "run.csv", "--model", RIG, "--out", tmp_path / "run.png")
    assert "run: casing: the run has no measured temperature (column casing_degC)." in said
    assert "run: bearing: the run has no measured temperature (column bearing_degC)." in said
    assert "brush: the run" not in said


def bars(section: Section, kind: str) -> dict[str, float]:
    return {bar.name: bar.from_s for bar in section.bars if bar.kind == kind}


def with_rule(path: Path, rule: dict[str, object]) -> Path:
    path.write_text(json.dumps(json.loads(RIG.read_text()) | {"alarms": [{"name": "too_hot", **rule}]}))
    return path


def test_the_rules_alarms_come_after_the_fault_and_never_without_one(tmp_path: Path) -> None:
    limit = {"kind": "over_temperature", "component": "casing", "limit_degC": 60.0, "persistence_s": 30.0}
    model = load(with_rule(tmp_path / "rules.json", limit | {"look_ahead": False}))
    healthy = section_of(rig_run(tmp_path / "healthy.csv"), model)
    assert bars(healthy, "derived") == {}
    run = rig_run(tmp_path / "faulty.csv", fault_K=40.0)
    faulty = section_of(run, model)
    # Beyond the limit from the row after 3600 s on; the condition holds in a further 120 samples.
    assert bars(faulty, "derived") == {"too_hot": pytest.approx(3631.0, abs=0.25)}
    assert bars(faulty, "fault") == {"fault: bearing": 3600.0}
    # By default each whole kelvin beyond the limit lets a sample count for one more of the 121.
    log = pd.read_csv(run, comment="#")
    beyond_K = int(log.loc[log["time_s"] == 3601.0, "casing_degC"].item() - 60.0)
    assert beyond_K > 10
    early = section_of(run, load(with_rule(tmp_path / "early.json", limit)))
    assert bars(early, "derived") == {"too_hot": pytest.approx(3601.0 + 0.25 * (121 / (1 + beyond_K) - 1), abs=0.25)}


def test_recorded_alarms_have_the_names_that_the_board_said(tmp_path: Path) -> None:
    rows = "".join(f"{i},100,30,{0 if i < 4 else 2 if i < 7 else 6}\n" for i in range(10))
    head = "# event: 3.250 alarm casing_hot\n# event: 6.750 alarm brush_fault\ntime_s,pwm,casing_degC,alarms\n"
    (tmp_path / "run.csv").write_text(head + rows)
    assert bars(section_of(tmp_path / "run.csv", None), "recorded") == {"casing_hot": 4.0, "brush_fault": 7.0}
    (tmp_path / "silent.csv").write_text(head.splitlines()[-1] + "\n" + rows)
    assert bars(section_of(tmp_path / "silent.csv", None), "recorded") == {"alarm 2": 4.0, "alarm 3": 7.0}


@pytest.mark.parametrize(
    ("comments", "expected"),
    [
        ({"fault": "bearing"}, [("fault: bearing", 10.0)]),
        ({"motor_fault": "brush from 1800 s", "power_on": "-1.50 s"}, [("fault: brush", 1798.5)]),
        ({"motor_fault": "none"}, []),
        ({"fault": "None"}, []),
        ({"healthy": "no"}, [("fault: not healthy", 10.0)]),
        ({"healthy": "yes"}, []),
        ({"fault": "x from 9e999 s"}, [("fault: x", 2000.0)]),
        ({"fault": "x from 1.2.3 s"}, [("fault: x from 1.2.3 s", 10.0)]),
    ],
)
def test_a_declared_fault_lasts_from_when_it_says(comments: dict[str, str], expected: list[tuple[str, float]]) -> None:
    assert [(bar.name, bar.from_s) for bar in declared(comments, 10.0, 2000.0)] == expected


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["missing.csv"], "missing.csv: there is no such file; expected a run file"),
        (["row.csv"], "row.csv: line 3, column pwm"),
        (["good.csv", "--out", "x.pdf"], "x.pdf: expected a name that ends with .html, .svg or .png"),
        (["good.csv", "--out", "no/such.html"], "no/such.html: cannot be written"),
        (["good.csv", "good.csv"], "good.csv: is given twice"),
        (["good.csv", "--model", "row.csv"], "row.csv: line 1, column 1: not valid JSON"),
        (["good.csv", "--model", str(RIG)], "good.csv: header: the column ambient_degC is missing"),
    ],
)
def test_what_cannot_be_drawn_is_told_and_nothing_written(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("good.csv").write_text("time_s,pwm,brush_degC\n0,9,20\n5,9,21\n")
    Path("row.csv").write_text("time_s,pwm,brush_degC\n0,9,20\n5,fast,21\n")
    with pytest.raises(InputError) as caught:
        CliRunner().invoke(cli, ["plot", *arguments], catch_exceptions=False)
    assert str(caught.value).startswith(message)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["good.csv", "row.csv"]
