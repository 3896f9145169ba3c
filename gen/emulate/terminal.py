"""A pseudo-terminal that stands for the board's serial port."""

from __future__ import annotations

import contextlib
import os
import select
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

from gen.errors import InputError

_POLL_S = 0.02


class PseudoTerminal:
    """The board's end of a serial line; a link leads to the other end.

    Nobody at the other end is as a cable without a computer: what the board sends is lost. While somebody has it open
    nothing is lost: the board waits until it is read.

    Parameters
    ----------
    link
        Where to put the symbolic link.

    Raises
    ------
    InputError
        When the link cannot be made.
    """

    def __init__(self, link: Path) -> None:
        try:
            import pty
            import tty
        except ImportError:
            raise InputError("this system has no pseudo-terminals; expected Linux or macOS", file=str(link)) from None
        self._master, slave = pty.openpty()
        tty.setraw(slave)
        self.name = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._master, False)
        self._state = select.poll()
        self._state.register(self._master, 0)
        self._link = link
        try:
            if link.is_symlink():
                link.unlink()  # of an earlier run
            link.symlink_to(self.name)
        except OSError as error:
            os.close(self._master)
            raise InputError(f"cannot be made: {error.strerror}", file=str(link)) from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Remove the link and hang up."""
        with contextlib.suppress(OSError):
            self._link.unlink()
        os.close(self._master)

    @property
    def is_open(self) -> bool:
        """Whether somebody has the other end open."""
        return not self._state.poll(0)

    def wait(self) -> None:
        """Wait until somebody opens the other end, and has had time to throw away what stood there before."""
        while not self.is_open:
            time.sleep(_POLL_S)
        time.sleep(0.3)

    def write(self, data: bytes, *, given_up: Callable[[], bool] = lambda: False) -> None:
        """Send; waits while the other end is open and its buffer full, until `given_up`."""
        while data and self.is_open and not given_up():
            try:
                data = data[os.write(self._master, data) :]
            except BlockingIOError:
                time.sleep(_POLL_S)

    def drain(self, *, given_up: Callable[[], bool] = lambda: False) -> None:
        """Wait until the other end has read everything, or is closed, or until `given_up`."""
        time.sleep(_POLL_S)
        while self.is_open and not given_up() and select.select([], [self._master], [], 0.0)[1] == []:
            time.sleep(_POLL_S)

    def read(self) -> bytes:
        """Give what the other end sent since the last call."""
        try:
            return os.read(self._master, 4096)
        except OSError:  # nothing there, or nobody
            return b""
