"""How far a run is: a bar on a terminal, else a plain line now and then."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from gen.emulate.session import Session

_FIRST_S = 5.0
_CLOSEST_S = 5.0
_RAREST_S = 30.0
_PARTS = 10


class Milestones:
    """When a line is due: soon after the start, at each tenth of the work, and every half minute at least.

    Lines are never closer than 5 s, so that short work says nothing.
    """

    def __init__(self) -> None:
        self._told_s: float | None = None
        self._parts = 0

    def due(self, share: float, wall_s: float) -> bool:
        """Tell whether a line is due.

        Parameters
        ----------
        share
            Of the work that is done, 0..1.
        wall_s
            Time since its start, s.
        """
        since_s = wall_s - (self._told_s or 0.0)
        another = int(share * _PARTS) > self._parts
        wait_s = _FIRST_S if self._told_s is None else _CLOSEST_S if another else _RAREST_S
        if since_s < wait_s or share >= 1.0:
            return False
        self._told_s, self._parts = wall_s, int(share * _PARTS)
        return True


@contextmanager
def run_progress(duration_s: float) -> Iterator[Callable[[Session], None]]:
    """Give a function that shows on stderr how much of a run's simulated time, s, has passed."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        milestones = Milestones()

        def tell(session: Session) -> None:
            if milestones.due(session.seconds / duration_s, session.wall_s):
                click.echo(f"{session.seconds:.0f} of {duration_s:.0f} s after {session.wall_s:.0f} s", err=True)

        yield tell
        return
    columns = (TextColumn("{task.completed:.0f} of {task.total:.0f} s"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=duration_s)
        yield lambda session: bar.update(task, completed=session.seconds)
