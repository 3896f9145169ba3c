"""What a page shows of what a board printed: bands, alarms and sensors by name, and lines that are no rows."""

from __future__ import annotations

import json
import math

import pytest

from gen.coefficients import load
from gen.live.known import Known, known_of
from gen.live.view import View
from tests.examples import ROOT

HEADER = "time_s,pwm,coil_degC,case_degC,coil_model_degC,flags,sensors,alarms\n"
KNOWN = Known(
    rules=("coil_hot", "case_hot"),
    channels=("coil", "case"),
    bands={"coil": ((0, 0, -1.0, 2.0), (1, 255, -3.0, 0.5))},
)


def fed(*lines: str, known: Known = KNOWN) -> View:
    view = View(known)
    view.feed((HEADER + "".join(f"{line}\n" for line in lines)).encode("latin-1"), 0.0)
    return view


def test_a_band_is_where_the_measured_temperature_is_expected() -> None:
    """Model minus measured is known to lie in [low, high], so measured lies in [model - high, model - low]."""
    view = fed("0,0,30,29,30,0,00,0", "1,200,30,29,40,0,00,0", "2,-200,30,,,0,00,0")
    assert view.columns()[-2:] == ["coil_low", "coil_high"]
    assert [row[-2:] for row in view.since(0)] == [[28.0, 31.0], [39.5, 43.0], [None, None]]
    assert view.since(2)[0][3] is None


def test_alarms_and_sensors_have_their_names() -> None:
    status = fed("0,0,30,29,30,0,00,0", "1,0,30,29,30,4,15,2").status()
    assert status["alarms"] == ["case_hot"]
    assert status["sensors"] == [{"channel": "coil", "state": "open"}, {"channel": "case", "state": "jump"}]
    assert status["flags"] == 4


def test_what_nobody_named_has_a_number() -> None:
    status = fed("0,0,30,29,30,0,01,5", known=Known()).status()
    assert status["alarms"] == ["rule 1", "rule 3"]
    assert [sensor["channel"] for sensor in status["sensors"]] == ["sensor 1", "sensor 2"]


def test_lines_that_are_no_rows_are_counted_and_shown_as_they_are() -> None:
    hostile = '1,0,<img src=x onerror="alert(1)">,29,30,0,00,0'
    view = fed(
        "0,0,30,29,30,0,00,0", hostile, "2,0,30,29", "\x1b[2Jgone", "# event: 2.5 alarm </pre><script>1</script>"
    )
    status = view.status()
    assert (status["rows"], status["garbled"]) == (1, 3)
    shown = "\n".join(status["lines"])
    assert f"no row: after 0.000 s: {hostile}" in shown
    assert "\\x1b[2Jgone" in shown
    assert "2.5 s: alarm </pre><script>1</script>" in shown
    assert all(line.isprintable() for line in status["lines"])


def test_lines_before_the_first_header_are_lost_and_counted() -> None:
    view = View(KNOWN)
    view.feed(b"half a row\n1,2,3\n", 0.0)
    assert view.status()["garbled"] == 2
    assert view.history(100) == {"part": 0, "next": 0, "columns": [], "curves": {}}


def test_a_note_is_in_every_part_from_then_on() -> None:
    view = View(KNOWN)
    view.note("motor_fault", "brush")
    view.feed(HEADER.encode() + b"0,0,30,29,30,0,00,0\ntime_s,pwm,coil_degC\n0,5,31\n", 0.0)
    view.note("sensor_coil_fault", "open")
    first, second = (part.comments for part in view.recorder.parts)
    assert first == ["# motor_fault: brush"]
    assert second[-2:] == ["# motor_fault: brush", "# sensor_coil_fault: open"]


def test_a_number_that_json_has_not_is_none() -> None:
    view = fed("0,0,1e999,29,30,0,00,1e999")
    assert view.since(0)[0][2] is None
    assert view.status()["alarms"] == []
    json.dumps([view.status(), view.history(100)], allow_nan=False)


def test_rows_of_other_columns_are_a_part_of_their_own() -> None:
    view = fed("0,0,30,29,30,0,00,0")
    view.feed(b"time_s,pwm,coil_degC\n0,5,31\n", 1.0)
    assert (view.part, view.columns(), view.since(0)) == (2, ["time_s", "pwm", "coil_degC"], [[0.0, 5.0, 31.0]])


def test_hours_of_rows_come_in_few_points_with_their_extremes() -> None:
    rows = [f"{k / 4:.2f},100,{40 + math.sin(k / 5000):.2f},29,40,0,00,0" for k in range(40_000)]
    rows[12_345] = "3086.25,100,99.5,29,40,0,00,0"
    history = fed(*rows).history(1000)
    assert history["next"] == 40_000
    assert set(history["curves"]) == {"pwm", "coil_degC", "case_degC", "coil_model_degC", "coil_low", "coil_high"}
    times, values = history["curves"]["coil_degC"]
    assert len(times) == len(values) <= 1000
    assert (3086.25, 99.5) in zip(times, values, strict=True)


def test_a_coefficient_file_names_them() -> None:
    coefficients = load(ROOT / "examples" / "my1016_rig" / "coeffs.json")
    document, known = coefficients.document, known_of(coefficients)
    assert known.rules[:2] == ("casing_hot", "brush_hot")
    assert known.channels == ("brush", "bearing", "magnet", "casing", "ambient")
    first = next(band for band in document.provenance.error if band.component == "brush")  # type: ignore[union-attr]
    assert known.bands["brush"][0] == (*first.pwm, *first.model_minus_measured_K)


@pytest.mark.parametrize("cut", [1, 7, 50])
def test_bytes_may_come_cut_anywhere(cut: int) -> None:
    whole = (HEADER + "0,0,30,29,30,0,00,0\n1,0,31,29,30,0,00,1\n").encode()
    view = View(KNOWN)
    for start in range(0, len(whole), cut):
        view.feed(whole[start : start + cut], 0.0)
    assert view.since(0) == fed("0,0,30,29,30,0,00,0", "1,0,31,29,30,0,00,1").since(0)
