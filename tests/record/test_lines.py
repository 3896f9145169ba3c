"""Nothing that a board printed is lost, and nothing garbled becomes a row."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen.record import Recorder
from tests.record.boards import HEAD, record, reread


def test_rows_are_kept_as_printed_and_comments_come_first(tmp_path: Path) -> None:
    recorder = record(HEAD, b"0.250,0,30.25,0\r\n", b"# event: 0.300 alarm fault\r\n0.500,153,,0\r\n")
    assert recorder.parts[0].text().splitlines() == [
        "# model: my1016",
        "# reset: power",
        "# event: 0.300 alarm fault",
        "time_s,pwm,brush_degC,flags",
        "0.250,0,30.25,0",
        "0.500,153,,0",
    ]
    run = reread(recorder, tmp_path)
    assert run.pwm.tolist() == [0, 153]
    assert run.comments["model"] == "my1016"


@given(st.data())
def test_where_the_bytes_are_cut_plays_no_role(data: st.DataObject) -> None:
    rows = b"".join(b"%d.000,%d,%d.25,0\r\n" % (i, i % 256, i) for i in range(1, 30))
    stream = HEAD + rows + b"# event: 29.5 end\r\n"
    whole = record(stream)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=20)))
    pieces = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    assert record(*pieces, step_s=0.0).parts == whole.parts


@pytest.mark.parametrize(
    "line",
    [
        b"0.500,153,30.25",
        b"0.500,153,30.25,0,0",
        b"0.500,153,30.x5,0",
        b"0.500,15\xb3,30.25,0",
        b"0.500,,30.25,0",
        b"0.500,999,30.25,0",
        b"0.100,153,30.25,0",
        b"0.500,153,nan,0",
        b"0.500,1\x0053,30.25,0",
        b"0.500,153,30.25,0 0.750,153,30.25,0",
    ],
)
def test_a_garbled_row_is_a_comment_and_counted(line: bytes, tmp_path: Path) -> None:
    recorder = record(HEAD, b"0.250,0,30.25,0\r\n", line + b"\r\n", b"0.750,0,30.25,0\r\n")
    assert (recorder.rows, recorder.garbled) == (2, 1)
    run = reread(recorder, tmp_path)
    assert run.time_s.tolist() == [0.25, 0.75]
    assert run.comments["garbled"].startswith("after 0.250 s: 0.")
    assert run.comments["garbled_lines"] == "1"


def test_a_restart_goes_on_in_the_same_file_by_the_recorders_clock(tmp_path: Path) -> None:
    recorder = Recorder()
    recorder.feed(HEAD, 0.0)
    recorder.feed(b"0.250,153,40.00,0\r\n", 0.25)
    recorder.feed(b"0.500,153,40.25,0\r\n", 0.5)
    recorder.feed(b"# model: my1016\r\n# reset: watchdog\r\ntime_s,pwm,brush_degC,flags\r\n", 10.5)
    recorder.feed(b"# event: 0.100 warm start\r\n", 10.6)
    recorder.feed(b"0.250,0,41.00,0\r\n", 10.75)
    recorder.finish()
    run = reread(recorder, tmp_path)
    assert run.time_s.tolist() == [0.25, 0.5, 10.75]
    comments = recorder.parts[0].comments
    assert "# restart: 10.500 s is the board's new time 0" in comments
    assert "# after_restart: reset: watchdog" in comments
    assert "# event: 10.600 warm start" in comments
    assert sum("model" in line for line in comments) == 1
    assert recorder.parts[0].restarts == [10.5]


def test_a_restart_is_seen_without_a_reset_line_too(tmp_path: Path) -> None:
    header = b"time_s,pwm,brush_degC,flags\r\n"
    recorder = record(header, b"5.000,0,30,0\r\n", header, b"1.000,0,30,0\r\n", b"2.000,0,30,0\r\n")
    assert reread(recorder, tmp_path).time_s.tolist() == [5.0, 7.0, 8.0]
    assert recorder.garbled == 0


def test_a_header_that_was_asked_for_is_no_restart(tmp_path: Path) -> None:
    header = b"time_s,pwm,brush_degC,flags\r\n"
    recorder = record(header, b"5.000,0,30,0\r\n", header, b"6.000,0,30,0\r\n")
    assert reread(recorder, tmp_path).time_s.tolist() == [5.0, 6.0]
    assert recorder.parts[0].restarts == []


def test_another_header_begins_another_part() -> None:
    recorder = record(HEAD, b"0.250,0,30.25,0\r\n", b"# model: other\r\ntime_s,pwm,flags\r\n0.250,0,0\r\n")
    assert [part.columns for part in recorder.parts] == [
        ("time_s", "pwm", "brush_degC", "flags"),
        ("time_s", "pwm", "flags"),
    ]
    assert [part.rows for part in recorder.parts] == [["0.250,0,30.25,0"], ["0.250,0,0"]]


def test_rows_before_any_header_are_counted_and_an_unfinished_last_line_is_no_row() -> None:
    recorder = record(b"25,153,30,0\r\n7.000,153,30.0,0\r\n", HEAD, b"8.000,153,30.0,0\r\n9.000,153,30.0,1")
    assert (recorder.unheaded, recorder.rows) == (2, 1)


def test_an_endless_line_does_not_fill_the_memory() -> None:
    recorder = record(HEAD, *[b"x" * 3000] * 50, b"\r\n0.250,0,30.25,0\r\n")
    assert recorder.rows == 1
    assert recorder.garbled >= 1


def test_the_end_of_a_line_that_was_too_long_is_no_row() -> None:
    """A line end that got lost: what comes after it belongs to the same garbage, however much it looks like a row."""
    recorder = record(HEAD, b"0.250,0,30.25,0\r\n", b"x" * 5000, b"1.000,153,31.00,0\r\n", b"1.250,153,31.25,0\r\n")
    assert recorder.parts[0].rows == ["0.250,0,30.25,0", "1.250,153,31.25,0"]
    assert recorder.garbled == 1
