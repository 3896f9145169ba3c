"""Reading a board's serial port, and telling it the PWM of a profile meanwhile."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

import serial

from gen.errors import InputError
from gen.files import holds_measured_run, write_text
from gen.interruption import interruption
from gen.record.lines import Recorder
from gen.record.profile import Profile

_READ_S = 0.1
_ASK_AFTER_S = 3.0
_ASK_EVERY_S = 2.0
_PSEUDO_TERMINALS = ("/dev/pts/", "/dev/ttys")  # Linux, macOS
ASK_HEADER = b"?\n"
ARM = b"arm\n"
_REFUSED = re.compile(r"# event: \S+ not armed")


@dataclass
class Recording:
    """A recording and how it ended.

    Attributes
    ----------
    recorder
        What came.
    seconds
        How long it took, s, by this computer's clock.
    closed
        Whether the other end of a pseudo-terminal closed it: the emulator has come to its end.
    lost
        Why the port was lost before the end, or empty.
    """

    recorder: Recorder = field(default_factory=Recorder)
    seconds: float = 0.0
    closed: bool = False
    lost: str = ""


def record_port(
    port: str,
    *,
    baud: int = 115200,
    duration_s: float | None = None,
    profile: Profile = (),
    progress: Callable[[Recording], None] = lambda _: None,
) -> Recording:
    """Record until the time is over, the port is gone, or the user interrupts (which is a normal end).

    So is that the other end of a pseudo-terminal closes it.

    A board that does not print its header by itself is asked for it.

    Parameters
    ----------
    port
        A serial port or a pseudo-terminal.
    baud
        Its speed in bit/s.
    duration_s
        How long after the first header, s; None: until interrupted.
    profile
        PWM to command, with its times counted from the first header; the motor is armed before the first one other than
        0. After a restart of the board the present one is commanded again, and not armed: whatever made the board start
        anew, nobody has looked at the motor since.
    progress
        Called some times a second.

    Raises
    ------
    InputError
        When the port cannot be opened.
    """
    emulated = _is_pseudo_terminal(port)  # asked now: its link is gone when it has been closed
    try:
        line = serial.Serial(port, baud, timeout=_READ_S, write_timeout=1.0)
    except (serial.SerialException, ValueError, OSError) as error:
        raise InputError(f"cannot be opened: {reason(error)}", file=port) from error
    recording = Recording()
    try:
        with line, interruption() as interrupted:
            _listen(line, recording, duration_s, profile, progress, interrupted)
    except (serial.SerialException, OSError) as error:
        # The read fails alike when somebody pulls a board's plug, and that is no ordinary end.
        if emulated:
            recording.closed = True
        else:
            recording.lost = reason(error)
    recording.recorder.finish()
    return recording


def _listen(
    line: serial.Serial,
    recording: Recording,
    duration_s: float | None,
    profile: Profile,
    progress: Callable[[Recording], None],
    interrupted: threading.Event,
) -> None:
    recorder = recording.recorder
    begin = time.monotonic()
    ask_at, headed_at, headers = _ASK_AFTER_S, 0.0, 0
    commander = Commander(profile)
    while not interrupted.is_set():
        data = line.read(max(1, line.in_waiting))
        now = recording.seconds = time.monotonic() - begin
        recorder.feed(data, now)
        if recorder.headers and not headers:
            headed_at = now
        if headers != recorder.headers:
            headers = recorder.headers
            commander.repeat()
        if headers:
            line.write(commander.due(now - headed_at))
            if duration_s is not None and now - headed_at >= duration_s:
                return
        elif now >= ask_at:
            line.write(ASK_HEADER)
            ask_at = now + _ASK_EVERY_S
            if duration_s is not None and now >= duration_s + _ASK_AFTER_S + _ASK_EVERY_S:
                return
        progress(recording)


class Commander:
    """Turns a profile into the board's commands, and arms the motor once: whoever gives a profile wants it to turn."""

    def __init__(self, profile: Profile) -> None:
        self._profile = profile
        self._next = 0
        self._armed = False

    def due(self, time_s: float) -> bytes:
        """The command for the PWM that acts at a time, empty when it has been given."""
        command = b""
        while self._next < len(self._profile) and self._profile[self._next][0] <= time_s:
            command = b"%d\n" % self._profile[self._next][1]
            self._next += 1
        if command not in (b"", b"0\n") and not self._armed:
            self._armed = True
            return ARM + command
        return command

    def repeat(self) -> None:
        """Let the present command be given once more: the board has started again and forgot it."""
        self._next = max(self._next - 1, 0)


def refused(recorder: Recorder) -> int:
    """Count the events by which the board said that it drives nothing, since it is not armed."""
    return sum(bool(_REFUSED.match(line)) for part in recorder.parts for line in part.comments)


def write_parts(recorder: Recorder, out: Path) -> list[Path]:
    """Write each part as a run file: ``out``, then ``<stem>.2<suffix>`` and so on, without a number of a measured run.

    Raises
    ------
    InputError
        When a file cannot be written.
    """
    written: list[Path] = []
    numbers = count(2)
    for part in recorder.parts:
        path = out if not written else _further(out, numbers)
        write_text(path, part.text())
        written.append(path)
    return written


def _further(out: Path, numbers: Iterator[int]) -> Path:
    """The next name that no measured run has."""
    names = (out.with_name(f"{out.stem}.{number}{out.suffix}") for number in numbers)
    return next(path for path in names if not holds_measured_run(path))


def _is_pseudo_terminal(port: str) -> bool:
    return str(Path(port).resolve()).startswith(_PSEUDO_TERMINALS)


def reason(error: Exception) -> str:
    """Why a port was not opened or is gone, in one line."""
    number = getattr(error, "strerror", None)
    return str(number or error).splitlines()[0]
