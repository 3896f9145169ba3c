"""Arguments and options that the fleet's commands share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

CommandType = TypeVar("CommandType", bound=Callable[..., Any])
STORE = click.argument("store", metavar="STORE")


def workers_options(command: CommandType) -> CommandType:
    """--scheduler and --jobs."""
    command = click.option(
        "--jobs",
        type=click.IntRange(1, 1024),
        help="Processes of this machine; 1: none beside this one.  [default: as many as it has cores]",
    )(command)
    return click.option(
        "--scheduler", metavar="ADDRESS", help="A Dask scheduler's, tcp://HOST:PORT; its workers do the work."
    )(command)


def usual_jobs(jobs: int | None) -> int:
    """As many as were asked for, or as there are cores for this process."""
    import os

    if jobs is not None:
        return jobs
    if hasattr(os, "sched_getaffinity"):  # Linux
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
