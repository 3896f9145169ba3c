"""Run a source with its page until somebody interrupts, and keep what came as a run file."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
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


def serve(source: Source, host: str, port: int, out: Path | None, ready: Callable[[str], None]) -> list[Path]:
    """Serve the page.

    Parameters
    ----------
    source
        Not yet started.
    host, port
        Where to listen; port 0: any that is free.
    out
        The run file to write: every minute, and at the end.
    ready
        Told the page's address, with its token, once it answers.

    Returns
    -------
    list of Path
        The run files; none where no row came.

    Raises
    ------
    InputError
        When nobody can listen there, or the run file cannot be written.
    """
    listener = _listening(host, port)
    port = listener.getsockname()[1]
    token, name = new_token(), f"[{host}]" if ":" in host else host
    hosts = frozenset(f"{known}:{port}" for known in (*LOCAL[:2], "[::1]")) if host in LOCAL else None
    app = make_app(Live(source, out), token, hosts, port)
    config = uvicorn.Config(app, log_level="error", lifespan="off", timeout_graceful_shutdown=1, access_log=False)
    server = uvicorn.Server(config)
    saver = threading.Thread(target=_save_now_and_then, args=(source, out), daemon=True)
    with interruption(), listener:
        source.start()
        saver.start()
        ready(f"http://{name}:{port}/?{TOKEN}={token}")
        try:
            server.run(sockets=[listener])
        finally:
            source.stop()
    saver.join(timeout=5.0)
    source.view.recorder.finish()
    return _save(source, out)


def _listening(host: str, port: int) -> socket.socket:
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        return socket.create_server((host, port), family=family)
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"nobody can listen on {host}, port {port}: {reason}", place="--listen") from None


def _save_now_and_then(source: Source, out: Path | None) -> None:
    while not source.stopped.wait(_SAVE_EVERY_S):
        try:
            _save(source, out)
        except InputError as error:
            source.view.say(str(error))


def _save(source: Source, out: Path | None) -> list[Path]:
    recorder = source.view.recorder
    return [] if out is None or not recorder.rows else write_parts(recorder, out)
