"""Work that does not depend on each other, shared between this process and a copy of it.

The copy (`fork`) has all that its parent has in memory, so only what it finds is sent. Where no copy can be made
(Windows; macOS, whose libraries do not survive it), where there is one processor, and within work that is shared
already, tasks are done one after the other. What they give is the same.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import struct
import sys
import threading
import warnings
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from io import StringIO
from multiprocessing.connection import Connection
from typing import TypeVar, cast

from gen.interruption import interrupts_wait

T = TypeVar("T")
U = TypeVar("U")

_TICKET = struct.Struct("=H")

_shared = False
"""Whether this process does a part of shared work already."""


def has_help() -> bool:
    """Whether `side_by_side` would do two things at once: then, not else, what may not be needed can be begun early."""
    if _shared or sys.platform != "linux" or not hasattr(os, "fork") or len(os.sched_getaffinity(0)) < 2:
        return False
    # Threads and processes of a pool (a fleet's) are shared work, too.
    alone = threading.current_thread() is threading.main_thread()
    return alone and not multiprocessing.current_process().daemon


def side_by_side(tasks: Sequence[Callable[[], T]]) -> list[T]:
    """Do all tasks, by two processes where that is possible.

    Parameters
    ----------
    tasks
        Functions of nothing that change nothing: what one of them changes, another may not see. What they give is
        pickled, so nothing in it stays the very object that this process has.

    Returns
    -------
    list
        What each of them gives, in their order.

    Raises
    ------
    Exception
        What a task raises, of several the first in their order.
    """
    found = _shared_out(tasks) if len(tasks) > 1 and has_help() else {}
    # What was not done, for a helper that was killed or an error, is done here: so the first error of all is raised.
    return [found[number] if number in found else task() for number, task in enumerate(tasks)]


def of_two_kinds(some: Sequence[Callable[[], T]], others: Sequence[Callable[[], U]]) -> tuple[list[T], list[U]]:
    """Do tasks that give two kinds of things, all side by side; the longest should come first."""
    tasks: list[Callable[[], T | U]] = [*some, *others]
    found = side_by_side(tasks)
    return cast("list[T]", found[: len(some)]), cast("list[U]", found[len(some) :])


def _shared_out(tasks: Sequence[Callable[[], T]]) -> dict[int, T]:
    """What two processes found, by the number of the task."""
    global _shared
    tickets = _tickets(len(tasks))
    receiver, sender = multiprocessing.Pipe(duplex=False)
    helper = multiprocessing.get_context("fork").Process(target=_help, args=(tasks, tickets, sender), daemon=True)
    with ExitStack() as after:
        after.callback(os.close, tickets)
        after.callback(receiver.close)
        # What comes while a copy is made would be lost: Python only prints what is raised in that moment.
        with sender, warnings.catch_warnings(), interrupts_wait():
            # Other threads here draw a line of progress, or are asleep in BLAS, which knows of copies.
            warnings.simplefilter("ignore", DeprecationWarning)
            try:
                helper.start()
            except OSError:  # no room for one more
                return {}
            after.callback(helper.join)
            after.callback(helper.kill)  # at its beginning it lets SIGTERM wait, too
        _shared = True
        try:
            return _done(tasks, tickets) | _heard(receiver)
        finally:
            _shared = False


def _tickets(count: int) -> int:
    """A pipe's end from which both processes take the numbers of tasks, each number once."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)  # a pipe holds 65 536 bytes; more tasks would be an error, not a standstill
    os.write(writing, b"".join(_TICKET.pack(number) for number in range(count)))
    os.close(writing)
    return reading


def _next(tickets: int) -> int:
    """The next task's number; -1 if there is none."""
    taken = os.read(tickets, _TICKET.size)
    return int(_TICKET.unpack(taken)[0]) if taken else -1


def _done(tasks: Sequence[Callable[[], T]], tickets: int) -> dict[int, T]:
    """Do tasks until there are none, or one fails: which of them fails first is told apart from who came to it."""
    found: dict[int, T] = {}
    with suppress(Exception):
        for number in iter(lambda: _next(tickets), -1):
            found[number] = tasks[number]()
    return found


def _help(tasks: Sequence[Callable[[], T]], tickets: int, sender: Connection) -> None:
    """Do tasks in the copy, and send what they give; an interrupt is for the parent, which then ends this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    sys.stdout = sys.stderr = StringIO()  # the parent's may be half-written, or locked
    sender.send(_done(tasks, tickets))


def _heard(receiver: Connection) -> dict[int, T]:
    """What the helper found; nothing if it died."""
    try:
        return dict(receiver.recv())
    except EOFError:
        return {}
