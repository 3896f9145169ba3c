"""Where a motor's rows come from: what all sources have in common."""

from __future__ import annotations

import threading
from typing import Any, Literal

from gen.errors import InputError
from gen.live.control import Control
from gen.live.signals import UNKNOWN, Signals, from_rows
from gen.live.view import View

Kind = Literal["port", "emulated", "replay"]


class Source:
    """A thread that feeds a view until it is stopped.

    Parameters
    ----------
    kind, name
        What it is, and which.
    view
        Where the rows go.

    Attributes
    ----------
    link
        How it is going, in words.
    connected
        Whether rows can come now.
    """

    takes_commands = True

    def __init__(self, kind: Kind, name: str, view: View) -> None:
        self.kind, self.name, self.view = kind, name, view
        self.link, self.connected = "not started", False
        self.stopped = threading.Event()
        self._thread = threading.Thread(target=self._guarded, name=f"gen live {kind}", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End, and wait for it."""
        self.stopped.set()
        if self._thread.is_alive():
            self._thread.join(timeout=10.0)

    def controls(self) -> list[Control]:
        """What the page can change."""
        return []

    def change(self, name: str, value: Any) -> None:  # noqa: ANN401
        """Change one of :meth:`controls`.

        Raises
        ------
        InputError
            When there is none of this name, or the value is none for it.
        """
        raise InputError(f'found the control "{name}", expected one that this source has')

    def send(self, data: bytes) -> None:
        """Give the board bytes.

        Raises
        ------
        InputError
            When nobody takes them.
        """
        raise InputError("nobody takes commands here")

    def signals(self) -> Signals:
        """What the board's LED and relay do now."""
        if not self.connected and self.kind != "replay":
            return Signals(UNKNOWN, UNKNOWN, self.link)
        return from_rows(*self.view.last(), self.view.known)

    def run(self) -> None:
        """Feed the view until :attr:`stopped` is set or nothing comes any more."""
        raise NotImplementedError

    def _guarded(self) -> None:
        """A source that fails says so on the page; the page stays."""
        try:
            self.run()
        except Exception as error:
            self.link = f"ended: {type(error).__name__}: {error}"
            self.view.say(self.link)
        self.connected = False
