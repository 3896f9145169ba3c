"""Run sources with their page until somebody interrupts, and keep what came of each as a run file."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import uvicorn

from gen.errors import InputError
from gen.interruption import interruption
from gen.live.access import TOKEN, new_token
from gen.live.server import Live, make_app
from gen.live.source import Source
from gen.record.port import write_parts

_SAVE_EVERY_S = 60.0
LOCAL = ("127.0.0.1", "localhost", "::1")


@dataclass(frozen=True)
class Recorded:
    """A source, not yet started, and the run file that it is recorded to, or None."""

    source: Source
    out: Path | None = None


def serve(motors: Sequence[Recorded], host: str, port: int, ready: Callable[[str], None]) -> list[list[Path]]:
    """Serve the page.

    Parameters
    ----------
    motors
        What it shows, one beside the other. Run files are written every minute, and at the end.
    host, port
        Where to listen; port 0: any that is free.
    ready
        Told the page's address, with its token, once it answers.

    Returns
    -------
    list of list of Path
        The run files of each motor; none where no row came.

    Raises
    ------
    InputError
        When nobody can listen there, or a run file cannot be written.
    """
    listener = _listening(host, port)
    port = listener.getsockname()[1]
    token, name = new_token(), f"[{host}]" if ":" in host else host
    hosts = frozenset(f"{known}:{port}" for known in (*LOCAL[:2], "[::1]")) if host in LOCAL else None
    app = make_app([Live(motor.source, motor.out) for motor in motors], token, hosts, port)
    config = uvicorn.Config(app, log_level="error", lifespan="off", timeout_graceful_shutdown=1, access_log=False)
    server = uvicorn.Server(config)
    savers = [threading.Thread(target=_save_now_and_then, args=(motor,), daemon=True) for motor in motors]
    with interruption(), listener:
        for motor in motors:
            motor.source.start()
        for saver in savers:
            saver.start()
        ready(f"http://{name}:{port}/?{TOKEN}={token}")
        try:
            server.run(sockets=[listener])
        finally:
            for motor in motors:
                motor.source.stopped.set()  # all at once, then each is waited for
            for motor in motors:
                motor.source.stop()
    for saver in savers:
        saver.join(timeout=5.0)
    for motor in motors:
        motor.source.view.recorder.finish()
    return _save_all(motors)


def _listening(host: str, port: int) -> socket.socket:
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        return socket.create_server((host, port), family=family)
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"nobody can listen on {host}, port {port}: {reason}", place="--listen") from None


def _save_now_and_then(motor: Recorded) -> None:
    while not motor.source.stopped.wait(_SAVE_EVERY_S):
        try:
            _save(motor)
        except InputError as error:
            motor.source.view.say(str(error))


def _save_all(motors: Sequence[Recorded]) -> list[list[Path]]:
    """Save each; one that cannot be written does not cost the other."""
    written: list[list[Path]] = []
    wrong: InputError | None = None
    for motor in motors:
        try:
            written.append(_save(motor))
        except InputError as error:
            wrong = wrong or error
    if wrong is not None:
        raise wrong
    return written


def _save(motor: Recorded) -> list[Path]:
    recorder = motor.source.view.recorder
    return [] if motor.out is None or not recorder.rows else write_parts(recorder, motor.out)
