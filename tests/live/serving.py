"""A page's server in a thread, and sources for tests."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import uvicorn

from gen.live.control import Control, checked
from gen.live.heat import Heat
from gen.live.known import Known
from gen.live.server import Live, make_app
from gen.live.source import Source
from gen.live.view import View

TOKEN = "a-token-of-the-tests"
HEADER = b"time_s,pwm,coil_degC,coil_model_degC,flags,sensors,alarms\n"


@dataclass
class Told:
    """What a source was told."""

    sent: list[bytes] = field(default_factory=list)
    changed: list[tuple[str, Any]] = field(default_factory=list)


class FedSource(Source):
    """A source that a test feeds."""

    def __init__(self, known: Known | None = None, heat: Heat | None = None) -> None:
        super().__init__("port", "bench", View(known or Known(("coil_hot",), ("coil",)), heat))
        self.told = Told()
        self.connected, self.link = True, "open"

    def run(self) -> None:
        self.connected = True
        self.stopped.wait()

    def send(self, data: bytes) -> None:
        self.told.sent.append(data)

    def controls(self) -> list[Control]:
        return [
            Control("room", "room", "number", 20.0, 0.0, 40.0),
            Control("pull", "pull", "slider", 0.0, 0.0, 1.0, 0.05),
            Control("kind", "kind", "choice", "a", options=("a", "b")),
        ]

    def change(self, name: str, value: Any) -> None:  # noqa: ANN401
        found = {control.name: control for control in self.controls()}.get(name)
        if found is None:
            super().change(name, value)
        else:
            self.told.changed.append((name, checked(found, value)))


@contextmanager
def served(*sources: Source, port: int = 0) -> Iterator[str]:
    """Serve sources; gives the page's address with its token."""
    import socket

    listener = socket.create_server(("127.0.0.1", port))
    port = listener.getsockname()[1]
    app = make_app([Live(source) for source in sources], TOKEN, frozenset([f"127.0.0.1:{port}"]), port)
    config = uvicorn.Config(app, log_level="error", lifespan="off", timeout_graceful_shutdown=1, access_log=False)
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    for source in sources:
        source.start()
    thread.start()
    try:
        yield f"http://127.0.0.1:{port}/?token={TOKEN}"
    finally:
        for source in sources:
            source.stop()
        server.should_exit = True
        thread.join(timeout=10.0)
        listener.close()


def wait_until(true: Callable[[], bool], seconds: float = 60.0) -> None:
    """Wait for something that has to come.

    Raises
    ------
    TimeoutError
        When it does not.
    """
    end = time.monotonic() + seconds
    while not true():
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.02)
