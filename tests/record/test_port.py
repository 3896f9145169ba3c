"""`gen log` through a pseudo-terminal: nothing that the other end writes is lost."""

from __future__ import annotations

import array
import fcntl
import os
import pty
import select
import signal
import subprocess
import termios
import threading
import time
import tty
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import serial

from gen.cli import main
from gen.errors import InputError
from gen.record import port as port_module
from gen.record.lines import Recorder
from gen.record.port import Commander, Recording, _listen, record_port, write_parts
from gen.record.profile import parse_profile
from gen.runs import read_run
from tests.command import GEN
from tests.work import HANGS_S

HEAD = b"# model: my1016\r\ntime_s,pwm,brush_degC,flags\r\n"
ROWS = 3000


@pytest.fixture
def ends() -> Iterator[tuple[int, str]]:
    master, slave = pty.openpty()
    tty.setraw(slave)
    name = os.ttyname(slave)
    os.close(slave)
    yield master, name
    os.close(master)


@pytest.fixture
def listening(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Set once a recording of this process has discarded what stood in the port before."""
    event = threading.Event()
    listen = port_module._listen

    def told(*arguments: Any) -> None:  # noqa: ANN401
        event.set()
        listen(*arguments)

    monkeypatch.setattr(port_module, "_listen", told)
    return event


def wait_until_asked(master: int) -> None:
    """Wait until another process that records asks the silent board for its header."""
    hung_up = select.poll()
    hung_up.register(master, 0)
    while hung_up.poll(0):
        time.sleep(0.05)
    assert os.read(master, 2) == b"?\n"


def write_all(master: int, data: bytes) -> None:
    while data:
        data = data[os.write(master, data[:512]) :]


def wait_until_read(port: str) -> None:
    """Wait until nothing that was written waits for its reader."""
    unread = array.array("i", [1])
    with open(os.open(port, os.O_RDWR | os.O_NOCTTY), "rb", buffering=0) as line:  # noqa: PTH123
        while unread[0]:
            time.sleep(0.1)
            fcntl.ioctl(line, termios.FIONREAD, unread)
    time.sleep(0.3)


def row(i: int) -> bytes:
    return b"%d.%03d,%d,%d.25,0\r\n" % (i // 4, i % 4 * 250, i % 256, i % 100)


def log(port: str, out: Path, *options: str) -> subprocess.Popen[str]:
    command = [*GEN, "log", port, "--out", str(out), *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_every_row_arrives(ends: tuple[int, str], tmp_path: Path) -> None:
    master, port = ends
    out = tmp_path / "run.csv"
    done = log(port, out)
    wait_until_asked(master)
    write_all(master, HEAD + b"".join(map(row, range(ROWS))))
    wait_until_read(port)
    done.terminate()
    stdout, stderr = done.communicate(timeout=HANGS_S)
    assert (done.returncode, stderr) == (0, "")
    assert f"{ROWS} rows" in stdout and "0 garbled" in stdout
    run = read_run(out, ["brush"])
    assert len(run.time_s) == ROWS
    assert run.pwm.tolist() == [i % 256 for i in range(ROWS)]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_keeps_what_came(ends: tuple[int, str], tmp_path: Path, number: signal.Signals) -> None:
    master, port = ends
    out = tmp_path / "run.csv"
    done = log(port, out)
    wait_until_asked(master)
    write_all(master, HEAD)
    write_all(master, b"".join(map(row, range(100))) + b"25.000,3")
    wait_until_read(port)
    done.send_signal(number)
    done.communicate(timeout=HANGS_S)
    assert done.returncode == 0
    assert len(read_run(out).time_s) == 100
    assert [path.name for path in tmp_path.iterdir()] == ["run.csv"]


def test_a_silent_board_is_asked_for_its_header(
    ends: tuple[int, str], listening: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    master, port = ends
    monkeypatch.setattr(port_module, "_ASK_AFTER_S", 0.8)

    def board() -> None:
        assert listening.wait(HANGS_S)
        write_all(master, row(8))
        assert os.read(master, 2) == b"?\n"
        write_all(master, HEAD + row(9) + row(10))

    thread = threading.Thread(target=board)
    thread.start()
    recording = record_port(port, duration_s=0.5)
    thread.join()
    assert (recording.recorder.rows, recording.recorder.unheaded) == (2, 1)


def test_the_profile_is_commanded_and_repeated_after_a_restart(
    ends: tuple[int, str], listening: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    master, port = ends
    heard: list[bytes] = []
    clock = [100.0]  # the recording's, which goes on when the board has heard what it waits for
    monkeypatch.setattr(port_module, "time", SimpleNamespace(monotonic=lambda: clock[0]))

    def board() -> None:
        assert listening.wait(HANGS_S)
        write_all(master, HEAD + row(1))
        heard.append(os.read(master, 16))
        clock[0] += 0.5
        heard.append(os.read(master, 16))
        write_all(master, b"# reset: watchdog\r\n" + HEAD + row(1))
        heard.append(os.read(master, 16))
        clock[0] += 1.0

    thread = threading.Thread(target=board)
    thread.start()
    recording = record_port(port, duration_s=1.0, profile=((0.0, 153), (0.4, -20)))
    thread.join()
    assert heard == [b"arm\n153\n", b"-20\n", b"-20\n"]  # a board that restarts is not armed by a recorder
    assert recording.recorder.rows == 2


def test_the_other_end_of_a_pseudo_terminal_ends_the_recording_in_order(tmp_path: Path) -> None:
    master, slave = pty.openpty()
    port = os.ttyname(slave)
    os.close(slave)
    link = tmp_path / "port"
    link.symlink_to(port)
    out = tmp_path / "run.csv"
    done = log(str(link), out)
    wait_until_asked(master)
    write_all(master, HEAD + row(1) + row(2))
    wait_until_read(port)
    link.unlink()
    os.close(master)
    stdout, stderr = done.communicate(timeout=HANGS_S)
    assert (done.returncode, stderr) == (0, "")
    assert "  the line was closed after " in stdout.splitlines()[-1]
    assert len(read_run(out).time_s) == 2


def test_a_lost_board_ends_the_recording_as_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A board whose plug is pulled: the read fails as a closed pseudo-terminal's does."""
    master, slave = pty.openpty()
    port = os.ttyname(slave)
    os.close(slave)
    monkeypatch.setattr("gen.record.port._PSEUDO_TERMINALS", ("/dev/none/",))
    out = tmp_path / "run.csv"

    def board() -> None:
        wait_until_asked(master)
        write_all(master, HEAD + row(1) + row(2))
        wait_until_read(port)
        os.close(master)

    thread = threading.Thread(target=board)
    thread.start()
    monkeypatch.setattr("sys.argv", ["gen", "log", port, "--out", str(out)])
    with pytest.raises(SystemExit) as ended:
        main()
    thread.join()
    assert ended.value.code == 1
    assert "the port was lost" in capsys.readouterr().err
    assert len(read_run(out).time_s) == 2


def test_no_such_port_is_one_message_and_exit_2(tmp_path: Path) -> None:
    done = log("/dev/no-such-port", tmp_path / "run.csv")
    _, stderr = done.communicate(timeout=HANGS_S)
    assert done.returncode == 2
    assert stderr.startswith("error: /dev/no-such-port: cannot be opened")
    assert len(stderr.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_nothing_is_written_when_nothing_came(
    ends: tuple[int, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("gen.record.port._ASK_AFTER_S", 0.1)
    monkeypatch.setattr("gen.record.port._ASK_EVERY_S", 0.1)
    _, port = ends
    monkeypatch.setattr("sys.argv", ["gen", "log", port, "--out", str(tmp_path / "run.csv"), "--duration", "0.1"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 1
    assert "no row came" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_profile_of_pairs_or_of_a_file(tmp_path: Path) -> None:
    assert parse_profile("0:153, 3600:-20,3600.5:0") == ((0.0, 153), (3600.0, -20), (3600.5, 0))
    file = tmp_path / "steps.csv"
    file.write_text("time_s,pwm\n0,51\n7.5,0\n", encoding="utf-8")
    assert parse_profile(str(file)) == ((0.0, 51), (7.5, 0))


@pytest.mark.parametrize("text", ["", "0:256", "5:1,5:2", "0;153", "0:1.5", "no-such-file.csv", "1:2:3"])
def test_a_bad_profile_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--profile"):
        parse_profile(text)


def test_a_step_is_commanded_once() -> None:
    commander = Commander(((0.0, 1), (10.0, 2), (10.2, 3)))
    assert [commander.due(t) for t in (0.0, 5.0, 10.1, 11.0)] == [b"arm\n1\n", b"", b"2\n", b"3\n"]
    commander.repeat()
    assert commander.due(12.0) == b"3\n"


def test_the_motor_is_armed_when_it_is_to_turn() -> None:
    commander = Commander(((0.0, 0), (10.0, 20), (20.0, 0), (30.0, 40)))
    assert [commander.due(t) for t in (0.0, 10.0, 20.0, 30.0)] == [b"0\n", b"arm\n20\n", b"0\n", b"40\n"]


def test_the_duration_counts_from_the_board_s_header(monkeypatch: pytest.MonkeyPatch) -> None:
    """A board that checks itself for three seconds first is recorded for as long as any other."""
    clock = [100.0]
    monkeypatch.setattr("gen.record.port.time.monotonic", lambda: clock[0])

    def read(_: int) -> bytes:
        clock[0] += 0.1
        said = clock[0] - 100.0
        if said < 3.0:
            return b""
        return HEAD if said < 3.1 else row(round(10.0 * said))

    line = SimpleNamespace(in_waiting=0, read=read, write=len)
    recording = Recording()
    _listen(cast(serial.Serial, line), recording, 5.0, (), lambda _: None, threading.Event())
    assert recording.seconds == pytest.approx(8.0, abs=0.21)
    assert recording.recorder.rows == pytest.approx(50, abs=2)


def test_a_board_that_never_says_its_header_is_given_up_but_not_before_the_duration(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It may check itself for three seconds, and is asked again every two."""
    clock = [100.0]
    monkeypatch.setattr("gen.record.port.time.monotonic", lambda: clock[0])

    def read(_: int) -> bytes:
        clock[0] += 0.1
        return b""

    asked: list[float] = []
    line = SimpleNamespace(in_waiting=0, read=read, write=lambda _: asked.append(clock[0] - 100.0))
    recording = Recording()
    _listen(cast(serial.Serial, line), recording, 10.0, (), lambda _: None, threading.Event())
    assert 13.0 <= recording.seconds <= 18.0
    assert asked[0] == pytest.approx(3.0, abs=0.11)
    assert np.diff(asked) == pytest.approx(2.0, abs=0.11)


def test_a_further_part_takes_no_measured_run_s_name(tmp_path: Path) -> None:
    """Another firmware's columns begin a file of their own; one of that name from another day stays."""
    older = tmp_path / "run.2.csv"
    older.write_text("time_s,pwm,casing_degC\n0,0,21\n", encoding="utf-8")
    recorder = Recorder()
    recorder.feed(b"time_s,pwm,a_degC\n0,0,20\ntime_s,pwm,b_degC\n0,0,22\n", 0.0)
    assert [path.name for path in write_parts(recorder, tmp_path / "run.csv")] == ["run.csv", "run.3.csv"]
    assert older.read_text(encoding="utf-8") == "time_s,pwm,casing_degC\n0,0,21\n"
