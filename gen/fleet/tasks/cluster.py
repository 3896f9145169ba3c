"""Tasks on a Dask cluster, none of which is waited for without end.

Dask gives the tasks of a worker that died to others, and waits for one that hangs: it has no time limit for a task
(dask/distributed, issue 391), and one that is cancelled goes on in its worker's thread (issue 3681). So what is at work
far longer than the others is given to a second worker under another name, and whichever comes first is taken: both
write the same bytes under the same key. Where neither comes, it is an error of that task. Workers that are still at it
when all others are through are restarted, or they would be lost for what comes next. Until a first task is done nothing
says how long one takes, and it is allowed hours. Where no worker is left, nothing is waited for.
"""

from __future__ import annotations

import statistics
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any

from gen.errors import InputError

RETRIES = 2
"""How often a task that failed otherwise than by a complaint is tried again."""
LONG = 10.0
"""Nothing comes in for this many times the median of what did: what is left is given away a second time."""
HOPELESS = 100.0
"""The same, and it is given up: a motor of which there is much more than of the others may take long."""
AHEAD = 2
"""Tasks that Dask gives to a worker of one thread at a time: one at work, and one behind it."""
LEAST_S = 60.0
"""Least time after which it is given away a second time, s, however short tasks are."""
UNKNOWN_S = 360.0
"""How long a task is taken to need before any was done: a motor with many long runs may well take an hour."""
RECENT = 101
"""Tasks that the median is of."""
RESTART_S = 60.0
"""How long a worker may take to start anew."""

Outcome = tuple[str, Any, BaseException | None]
"""A task's name, what it gave, and why there is none."""


def outcomes(client: Any, call: Callable[..., Any], tasks: Mapping[str, tuple[Any, ...]]) -> Iterator[Outcome]:  # noqa: ANN401
    """Do tasks on the workers, and give each once, as they come.

    Parameters
    ----------
    client
        Of Dask.
    call
        What each task does; of a module, and to be done twice without harm.
    tasks
        Its arguments by the task's name, which is unique on the scheduler.

    Raises
    ------
    InputError
        When there is no worker any more.
    """
    came: SimpleQueue[tuple[str, Any]] = SimpleQueue()

    def give(name: str, key: str, **where: Any) -> Any:  # noqa: ANN401
        future = client.submit(_timed, call, *tasks[name], key=key, pure=False, retries=RETRIES, **where)
        future.add_done_callback(lambda done: came.put((name, done)))
        return future

    open_ = {name: [give(name, name)] for name in tasks}
    late: list[Any] = []
    took_s: deque[float] = deque(maxlen=RECENT)
    patience, twice = LONG, False
    while open_:
        next_ = _next(came, client, _limit_s(took_s, patience))
        if next_ is None:
            if patience == HOPELESS:
                break
            patience = HOPELESS
            busy = client.processing()
            # Where more are left, no worker is free, and a second copy of all would only be more to do.
            twice = len(open_) <= AHEAD * len(busy)
            for name in open_ if twice else ():
                others = [worker for worker, keys in busy.items() if name not in keys]
                open_[name] += [give(name, f"{name}-again", workers=others, allow_other_workers=True)] if others else []
            continue
        name, done = next_
        patience = HOPELESS if twice else LONG
        if name not in open_:  # the second of two
            continue
        error = done.exception()
        if error is not None and any(not future.done() for future in open_[name]):
            continue
        late += [future for future in open_.pop(name) if not future.done()]
        if error is not None:
            yield name, None, error
            continue
        result, seconds = done.result()
        took_s.append(seconds)
        yield name, result, None
    for name in open_:
        beside = f", {HOPELESS:g} times as long as others took" if took_s else ", and neither was any other"
        yield name, None, TimeoutError(f"not done in {_limit_s(took_s, HOPELESS):.0f} s{beside}")
    _ended(client, [*late, *(future for given in open_.values() for future in given)])


def _timed(call: Callable[..., Any], *arguments: Any) -> tuple[Any, float]:  # noqa: ANN401
    began = time.monotonic()
    return call(*arguments), time.monotonic() - began


def _limit_s(took_s: Sequence[float], times: float) -> float:
    """How long nothing may come in."""
    return max(statistics.median(took_s) if took_s else UNKNOWN_S, LEAST_S / LONG) * times


def _next(came: SimpleQueue[tuple[str, Any]], client: Any, limit_s: float) -> tuple[str, Any] | None:  # noqa: ANN401
    """Wait for what comes in next; None where nothing does. One look at a worker that starts anew shows none."""
    end, before = time.monotonic() + limit_s, True
    while (left_s := end - time.monotonic()) > 0.0:
        with suppress(Empty):
            return came.get(timeout=min(left_s, LEAST_S))
        there = bool(client.nthreads())
        if not (there or before):
            raise InputError(f"no worker is left at {client.scheduler.address}; what is done is kept for the next call")
        before = there
    return None


def _ended(client: Any, futures: list[Any]) -> None:  # noqa: ANN401
    """Restart the workers that are still at what nobody waits for any more."""
    keys = {future.key for future in futures if not future.done()}
    if not keys:
        return
    at_it = [worker for worker, theirs in client.processing().items() if keys & set(theirs)]
    client.cancel(futures)
    with suppress(ValueError, KeyError):  # one without a nanny is for whoever started it, and one may be gone already
        client.restart_workers(at_it, timeout=RESTART_S, raise_for_error=False)
