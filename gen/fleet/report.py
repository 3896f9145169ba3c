"""Pages of a fleet: every motor as a row, and a page of each; they work without a network and without a server."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass

from gen.errors import InputError
from gen.files import MARK
from gen.fleet.folder.models import paths_in_use
from gen.fleet.folder.store import Store
from gen.fleet.watch import FILE, QUIET, Apart, State, read_watched
from gen.pages.environment import page_environment
from gen.version import __version__

WIDTH, HEIGHT, EDGE = 120.0, 28.0, 3.0
"""Of a sparkline, in its own units."""


@dataclass(frozen=True)
class Row:
    """A motor as the pages show it.

    Attributes
    ----------
    motor, page, model
        Its name, and where its page and its coefficient file are.
    state, said, last_alarm, bad
        As watched; `bad` where the state is an alarm.
    error_K
        Of its newest run, or None.
    points, last
        The error's course as an SVG polyline's points, and its last one.
    runs
        Day and error of each run.
    labels
        Of the motor, `KEY=VALUE`.
    batches
        What it shows together with others of a label, in words.
    """

    motor: str
    page: str
    model: str
    state: str
    said: str
    last_alarm: str
    bad: bool
    error_K: float | None
    points: str
    last: tuple[str, str]
    runs: tuple[tuple[str, float | None], ...]
    labels: tuple[str, ...]
    batches: tuple[str, ...]


def pages_of(store: Store) -> dict[str, str]:
    """Give the pages by their path, with the manifest by which the folder is known again.

    Raises
    ------
    InputError
        When the fleet was not watched yet.
    """
    watched = read_watched(store)
    if watched is None:
        raise InputError("is missing; expected a fleet that gen fleet watch has seen", file=f"{store.url}/{FILE}")
    models = paths_in_use(store, [state.motor for state in watched.motors])
    rows = [_row(state, models[state.motor], watched.batches) for state in watched.motors]
    environment = page_environment()
    index, motor = (environment.get_template(f"fleet_{name}.html.j2") for name in ("index", "motor"))
    files = {
        "index.html": index.render(
            title="Fleet",
            version=__version__,
            rows=rows,
            fine=sum(row.state == "ok" for row in rows),
            common=(*watched.common, *(batch.said for batch in watched.batches)),
            limit=watched.limit,
            level=watched.level,
        )
    }
    files |= {row.page: motor.render(title=row.motor, row=row) for row in rows}
    hashes = {path: hashlib.sha256(text.encode()).hexdigest() for path, text in files.items()}
    files[MARK] = json.dumps({"tool": f"gen {__version__}", "files": hashes}, indent=1) + "\n"
    return files


def _row(state: State, model: str, batches: Sequence[Apart]) -> Row:
    points = _points(state.course_K)
    return Row(
        motor=state.motor,
        page=f"motors/{state.motor}.html",
        model=model,
        state=state.state,
        said=state.said,
        last_alarm=state.last_alarm,
        bad=state.state not in QUIET,
        error_K=state.error_K,
        points=" ".join(",".join(point) for point in points),
        last=points[-1] if points else ("0", "0"),
        runs=tuple(zip(state.days, state.course_K, strict=True)),
        labels=state.labels,
        batches=tuple(batch.said for batch in batches if state.motor in batch.motors),
    )


def _points(course: Sequence[float | None]) -> list[tuple[str, str]]:
    """Points from left to right, 0 K at the bottom; a run without an error leaves a gap in time only."""
    known = [(place, value) for place, value in enumerate(course) if value is not None]
    top = max((value for _, value in known), default=0.0) or 1.0
    step = (WIDTH - 2.0 * EDGE) / max(len(course) - 1, 1)
    return [
        (f"{EDGE + step * place:.1f}", f"{HEIGHT - EDGE - (HEIGHT - 2.0 * EDGE) * value / top:.1f}")
        for place, value in known
    ]
