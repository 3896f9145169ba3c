"""A board on a serial port: read, written to, and opened anew when it was pulled out and plugged in again."""

from __future__ import annotations

import queue
import time

import serial

from gen.errors import InputError
from gen.live.source import Source
from gen.live.view import View
from gen.record.port import ASK_HEADER, reason

_READ_S = 0.1
_AGAIN_S = 1.0
_ASK_EVERY_S = 3.0
_MOST_WAITING = 32
_LOST = (serial.SerialException, ValueError, OSError)


class PortSource(Source):
    """A serial port.

    Parameters
    ----------
    port, baud
        Which, and its speed in bit/s.
    view
        Where the rows go.

    Raises
    ------
    InputError
        When it cannot be opened; one that goes later is waited for.
    """

    def __init__(self, port: str, baud: int, view: View) -> None:
        super().__init__("port", port, view)
        self._baud = baud
        try:
            self._first: serial.Serial | None = self._opened()
        except _LOST as error:
            raise InputError(f"cannot be opened: {reason(error)}", file=port) from error
        self._waiting: queue.Queue[bytes] = queue.Queue(_MOST_WAITING)

    def send(self, data: bytes) -> None:
        """See :meth:`Source.send`."""
        if not self.connected:
            raise InputError("the port is not open: nothing was sent")
        try:
            self._waiting.put_nowait(data)
        except queue.Full:
            raise InputError("the port takes nothing: nothing was sent") from None

    def run(self) -> None:
        """See :meth:`Source.run`."""
        begin = time.monotonic()
        while not self.stopped.is_set():
            try:
                line, self._first = self._first or self._opened(), None
                with line:
                    self._forget()
                    self.link, self.connected = f"open at {self._baud} bit/s", True
                    self.view.say(f"{self.name}: open")
                    self._listen(line, begin)
            except _LOST as error:
                if self.connected:
                    self.view.say(f"{self.name}: {reason(error)}; waiting for it")
                self.link = f"waiting for the port: {reason(error)}"
            self.connected = False
            self.stopped.wait(_AGAIN_S)

    def _opened(self) -> serial.Serial:
        return serial.Serial(self.name, self._baud, timeout=_READ_S, write_timeout=1.0)

    def _listen(self, line: serial.Serial, begin: float) -> None:
        headers, ask_at = self.view.recorder.headers, time.monotonic() + _ASK_EVERY_S
        while not self.stopped.is_set():
            self.view.feed(line.read(max(1, line.in_waiting)), time.monotonic() - begin)
            while not self._waiting.empty():
                line.write(self._waiting.get_nowait())
            if self.view.recorder.headers == headers and time.monotonic() >= ask_at:
                line.write(ASK_HEADER)  # it changes nothing: the board says what its columns are
                ask_at = time.monotonic() + _ASK_EVERY_S

    def _forget(self) -> None:
        """A command that a lost port did not take is none for the board that comes after it."""
        while not self._waiting.empty():
            self._waiting.get_nowait()
