"""The page's server: one page of one motor or two, their rows as streams of events, and what the page asks for."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from dataclasses import asdict
from functools import cache
from itertools import count
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Body, FastAPI, Header, Request
from fastapi.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from plotly.offline import get_plotlyjs

from gen.drawing.palette import COLOURS, INK
from gen.errors import InputError
from gen.live.access import Access
from gen.live.commands import Commands, NotArmedError
from gen.live.source import Source
from gen.templating import folder
from gen.version import __version__

_EVERY_S = 0.25
_AT_ONCE = 5000
"""Rows of one event: who comes back late gets them in several."""
_QUIET_S = 2.0
MOST_POINTS = 4000
"""Of a curve when the page opens."""
_KINDS = {"html": "text/html; charset=utf-8", "js": "text/javascript; charset=utf-8", "css": "text/css; charset=utf-8"}


class Live:
    """A motor on the page: its source, and the commands to it.

    Parameters
    ----------
    source
        Where rows come from.
    recorded_to
        The run file that is being written, or None.
    """

    def __init__(self, source: Source, recorded_to: Path | None = None) -> None:
        self.source, self.recorded_to = source, recorded_to
        self.commands = Commands(source.send)
        self._numbers = count(1)

    def about(self) -> dict[str, Any]:
        """What of this motor a page is told when it opens."""
        return {
            "kind": self.source.kind,
            "name": self.source.name,
            "input": self.source.view.known.input,
            "heat": self.heat(),
            "takes_commands": self.source.takes_commands,
            "controls": [asdict(control) for control in self.source.controls()],
            "recorded_to": None if self.recorded_to is None else str(self.recorded_to),
        }

    def heat(self) -> dict[str, Any]:
        """Columns of missing heat, and how they are known."""
        heat = self.source.view.heat
        rules = heat.rules if heat is not None else ()
        found = [{"rule": rule.name, "column": rule.column, "threshold_K": rule.threshold_K} for rule in rules]
        return {"rules": found, "told": "" if heat is None else heat.told}

    def answer(self) -> dict[str, Any]:
        """The status with a number: what was looked up earlier, and arrives later, has a lower one.

        An event of the stream and the answer to a command reach a page in any order.
        """
        number = next(self._numbers)
        return {**self.status(), "number": number}

    def status(self) -> dict[str, Any]:
        """What holds now."""
        return {
            **self.source.view.status(),
            "signals": asdict(self.source.signals()),
            "link": self.source.link,
            "connected": self.source.connected,
            "armed_s": round(self.commands.armed_s),
        }

    async def events(self, part: int, row: int, gone: Callable[[], Awaitable[bool]]) -> AsyncIterator[str]:
        """What is new, from a row of a part on, until nobody listens any more."""
        view, quiet_s = self.source.view, 0.0
        before: dict[str, Any] = {}
        while not self.source.stopped.is_set() and not await gone():
            if view.part != part:
                part, row = view.part, 0
            rows = view.since(row, _AT_ONCE)
            number = next(self._numbers)
            status = self.status()
            quiet_s += _EVERY_S
            if rows or status != before or quiet_s >= _QUIET_S:
                row += len(rows)
                told = {"part": part, "columns": view.columns(), "rows": rows, "status": {**status, "number": number}}
                yield f"id: {part}.{row}\ndata: {json.dumps(told, allow_nan=False)}\n\n"
                before, quiet_s = status, 0.0
            await asyncio.sleep(_EVERY_S)


def make_app(lives: Sequence[Live], token: str, hosts: frozenset[str] | None, port: int) -> FastAPI:
    """Make the server.

    Parameters
    ----------
    lives
        The motors that it shows; what is asked of the k-th begins with ``/k``, from 1 on.
    token, hosts, port
        As :class:`gen.live.access.Access` has them.
    """
    app = FastAPI(title="gen live", docs_url=None, redoc_url=None, openapi_url=None)
    app.add_middleware(Access, token=token, hosts=hosts, port=port)

    @app.exception_handler(InputError)
    def refused(_: Request, error: InputError) -> JSONResponse:
        return JSONResponse({"error": error.message}, 422)

    @app.exception_handler(NotArmedError)
    def not_armed(_: Request, __: NotArmedError) -> JSONResponse:
        return JSONResponse({"error": "not armed: nothing was sent"}, 409)

    _add_files(app)

    @app.get("/about")
    def about() -> JSONResponse:
        motors = [live.about() for live in lives]
        return JSONResponse({"version": __version__, "colours": COLOURS, "ink": INK, "motors": motors})

    for number, live in enumerate(lives, start=1):
        motor = APIRouter(prefix=f"/{number}")
        _add_reading(motor, live, "run.csv" if len(lives) == 1 else f"run-{number}.csv")
        _add_doing(motor, live)
        app.include_router(motor)
    return app


def _add_files(app: FastAPI) -> None:
    @app.get("/")
    def page() -> Response:
        return _file("live.html")

    @app.get("/plotly.js")
    def library() -> Response:
        return Response(_plotly(), media_type=_KINDS["js"])

    @app.get("/{name}.js")
    def script(name: Literal["live", "motor", "curves"]) -> Response:
        return _file(f"{name}.js")

    @app.get("/live.css")
    def style() -> Response:
        return _file("live.css")


def _add_reading(app: APIRouter, live: Live, file: str) -> None:
    view = live.source.view

    @app.get("/history")
    def history(most: int = MOST_POINTS) -> JSONResponse:
        return JSONResponse({**view.history(min(max(most, 64), 50_000)), "status": live.answer()})

    @app.get("/run.csv")
    def run_file() -> Response:
        headers = {"content-disposition": f'attachment; filename="{file}"'}
        return PlainTextResponse(view.text(), media_type="text/csv; charset=utf-8", headers=headers)

    @app.get("/events")
    async def events(
        request: Request, part: int = 0, row: int = 0, last_event_id: Annotated[str, Header()] = ""
    ) -> StreamingResponse:
        first, dot, second = last_event_id.partition(".")  # a browser that lost the line asks for what came after it
        if dot and first.isdigit() and second.isdigit():
            part, row = int(first), int(second)
        return StreamingResponse(
            live.events(part, max(row, 0), request.is_disconnected), media_type="text/event-stream"
        )


def _add_doing(app: APIRouter, live: Live) -> None:
    @app.post("/arm")
    def arm(armed: Annotated[bool, Body(embed=True)]) -> JSONResponse:
        if armed and not live.source.takes_commands:
            raise InputError("a replay takes no commands")
        live.commands.arm(armed)
        return JSONResponse(live.answer())

    @app.post("/pwm")
    def pwm(count: Annotated[int, Body(embed=True)]) -> JSONResponse:
        live.commands.pwm(count)
        return JSONResponse(live.answer())

    @app.post("/line")
    def line(text: Annotated[str, Body(embed=True)]) -> JSONResponse:
        live.commands.line(text)
        return JSONResponse(live.answer())

    @app.post("/change")
    def change(name: Annotated[str, Body()], value: Annotated[float | str, Body()]) -> JSONResponse:
        live.source.change(name, value)
        return JSONResponse(live.answer())


def _file(name: str) -> Response:
    path = folder("pages") / "live" / name
    return Response(path.read_bytes(), media_type=_KINDS[name.rpartition(".")[2]])


@cache
def _plotly() -> bytes:
    return str(get_plotlyjs()).encode()
