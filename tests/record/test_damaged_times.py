"""A time that was damaged on the line costs its row, and at most a few others."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen.record import Recorder
from tests.record.boards import HEAD, record, reread


def times_from(begin_s: float, count: int) -> list[float]:
    return [begin_s + i / 4 for i in range(count)]


def rows_from(begin_s: float, count: int) -> list[bytes]:
    return [b"%.3f,0,30.25,0\r\n" % time_s for time_s in times_from(begin_s, count)]


@given(noise=st.binary(max_size=300))
def test_noise_on_the_line_costs_no_row_around_it(noise: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    recorder = record(HEAD, *rows_from(0.25, 20), noise, b"\n", *rows_from(5.75, 20), step_s=0.25)
    run = reread(recorder, tmp_path_factory.mktemp("noise"))
    assert {*times_from(0.25, 20), *times_from(5.75, 20)} <= set(run.time_s.tolist())


@given(place=st.integers(0, 199), flips=st.lists(st.tuples(st.integers(0, 17), st.integers(0, 127)), max_size=3))
def test_a_damaged_row_costs_few_others(place: int, flips: list[tuple[int, int]]) -> None:
    """Whatever bytes are put for some of a row's own, its line end left alone."""
    rows = rows_from(95.0, 200)
    damaged = bytearray(rows[place].rstrip(b"\r\n"))
    for at, byte in flips:
        damaged[min(at, len(damaged) - 1)] = byte if byte != ord("\n") else 0
    rows[place] = bytes(damaged) + b"\r\n"
    recorder = record(HEAD, *rows, step_s=0.25)
    kept = {row.split(",")[0] for part in recorder.parts for row in part.rows}
    lost = [time_s for i, time_s in enumerate(times_from(95.0, 200)) if i != place and f"{time_s:.3f}" not in kept]
    assert len(lost) <= 4  # a time that is late by no more than the clock's slack


@pytest.mark.parametrize("time", [b"9100.000", b"1e3", b"110000", b"101.9", b"999999999999", b"1e999"])
@pytest.mark.parametrize("step_s", [0.25, 0.0025, 0.0])
def test_a_time_that_is_too_late_costs_its_row_only(time: bytes, step_s: float) -> None:
    """Whether the board runs in time, a hundred times faster, or all of it comes at once after a stall."""
    rows = rows_from(0.25, 1000)
    rows[399] = time + b",0,30.25,0\r\n"
    recorder = record(HEAD, *rows, step_s=step_s)
    kept = [float(row.split(",")[0]) for row in recorder.parts[0].rows]
    assert kept == [*times_from(0.25, 399), *times_from(100.25, 600)]
    assert recorder.garbled == 1
    assert recorder.parts[0].comments[-1] == f"# garbled: after 99.750 s: {time.decode()},0,30.25,0"


@pytest.mark.parametrize("place", [0, 1, 5, 999])
def test_a_late_time_costs_its_row_only_wherever_it_stands(place: int) -> None:
    rows = rows_from(0.25, 1000)
    rows[place] = b"9" + rows[place]
    recorder = record(HEAD, *rows, step_s=0.25)
    assert [float(row.split(",")[0]) for row in recorder.parts[0].rows] == [
        time_s for i, time_s in enumerate(times_from(0.25, 1000)) if i != place
    ]


@pytest.mark.parametrize("times", [(b"9012.500", b"95012.750"), (b"95012.500", b"9012.750")])
def test_two_late_times_in_a_row_cost_their_rows_only(times: tuple[bytes, bytes]) -> None:
    rows = rows_from(0.25, 100)
    rows[49:51] = [time + b",0,30.25,0\r\n" for time in times]
    recorder = record(HEAD, *rows, step_s=0.25)
    assert (recorder.rows, recorder.garbled) == (98, 2)


def test_a_late_time_after_a_restart_costs_its_row_only() -> None:
    """Without a reset line only times tell that the board has started again; the first of them is damaged."""
    header = b"time_s,pwm,brush_degC,flags\r\n"
    after = rows_from(0.25, 100)
    after[0] = b"9000.250,0,30.25,0\r\n"
    recorder = record(header, *rows_from(0.25, 100), header, *after, step_s=0.25)
    assert recorder.parts[0].restarts == [25.25]
    assert (recorder.rows, recorder.garbled) == (199, 1)
    assert recorder.parts[0].rows[-1].startswith("50.250,")


def test_a_jump_of_the_board_s_clock_is_kept() -> None:
    """Or of the recorder's, which stands still while its computer sleeps."""
    recorder = record(HEAD, *rows_from(0.25, 100), *rows_from(5000.0, 100), step_s=0.25)
    kept = [float(row.split(",")[0]) for row in recorder.parts[0].rows]
    assert kept == [*times_from(0.25, 100), *times_from(5000.0, 100)]
    assert recorder.garbled == 0


def test_a_board_that_has_run_for_long_is_recorded_from_its_first_row_on() -> None:
    recorder = record(HEAD, *rows_from(5000.0, 100), step_s=0.25)
    assert (recorder.rows, recorder.garbled) == (100, 0)
    assert record(HEAD, *rows_from(5000.0, 1)).rows == 1


def test_rows_that_are_seconds_apart_are_kept_of_a_board_that_is_faster_than_the_clock() -> None:
    header = b"time_s,pwm\r\n"
    recorder = record(header, *(b"%d,0\r\n" % (60 * i) for i in range(100)), step_s=0.1)
    assert (recorder.rows, recorder.garbled) == (100, 0)


def test_a_board_s_slow_clock_makes_no_later_time_plausible() -> None:
    """After two hours a clock that is half a percent slow is half a minute behind; a time is twenty seconds late."""
    count, at = 4 * 7800, 4 * 7200
    recorder = Recorder()
    recorder.feed(HEAD, 0.0)
    for i in range(count):
        time_s = i / 4 + (20.0 if i == at else 0.0)
        recorder.feed(b"%.3f,0,30.25,0\r\n" % time_s, i / 4 / 0.995)
    recorder.finish()
    assert (recorder.rows, recorder.garbled) == (count - 1, 1)


def sent(rows: int, damaged: dict[int, str], clock: float = 1.0, uptime_s: float = 0.0) -> Recorder:
    """Rows every quarter of a second by the board, some with another time than they had."""
    recorder = Recorder()
    recorder.feed(HEAD, 0.0)
    for i in range(rows):
        time = damaged.get(i, f"{uptime_s + 0.25 * (i + 1):.3f}")
        recorder.feed(f"{time},153,30.25,0\r\n".encode(), 0.25 * (i + 1) / clock)
    recorder.finish()
    return recorder


@pytest.mark.parametrize("clock", [1.0, 100.0])  # an emulated board may run faster than the recorder's clock
@pytest.mark.parametrize("uptime_s", [0.0, 9000.0])  # before the recording began
@pytest.mark.parametrize("at", [0, 1, 2, 200, 399])
@pytest.mark.parametrize("time", ["99100.250", "1e999", "1e300", "123456"])
def test_a_damaged_time_costs_its_row_and_no_other(time: str, at: int, uptime_s: float, clock: float) -> None:
    recorder = sent(400, {at: time}, clock, uptime_s)
    assert (recorder.rows, recorder.garbled) == (399, 1)
    kept = [float(row.partition(",")[0]) for row in recorder.parts[0].rows]
    assert kept == [uptime_s + 0.25 * (i + 1) for i in range(400) if i != at]


def test_a_damaged_time_that_the_clock_allows_costs_a_few_rows(tmp_path: Path) -> None:
    recorder = sent(400, {200: "51.000"})  # for 50.25
    assert recorder.rows >= 396
    assert reread(recorder, tmp_path).time_s[-1] == 100.0
