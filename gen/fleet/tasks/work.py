"""Tasks over workers: the same results whatever their number, and none computed twice.

A task is a function of a module, the store and arguments that JSON can hold. What it gives is a set of arrays, kept in
the store under a hash of the function's name, its version and its arguments; there the next call finds it. A task that
complains costs a line, one whose worker dies or hangs is given to another (`cluster`).
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.errors import CheckFailed, InputError
from gen.fleet.folder.store import TASKS, Store
from gen.fleet.tasks.cluster import outcomes
from gen.version import __version__

Arrays = dict[str, NDArray[Any]]
Progress = Callable[[str], None]
CONNECT_S = 30.0
"""How long a scheduler may take to answer, and then to have a worker."""
LAYOUT = 21
"""Raised with every change of what tasks compute from the same arguments."""


Function = Callable[..., Arrays]
"""What a task does; of a module, so that a worker finds it by its name; complains by `InputError` or `CheckFailed`."""


@dataclass(frozen=True)
class Workers:
    """Where tasks run.

    Parameters
    ----------
    jobs
        Processes of this machine; 1: this process alone, without a cluster.
    scheduler
        Address of a Dask scheduler whose workers have `gen` and reach the store; then `jobs` says nothing.
    """

    jobs: int = 1
    scheduler: str | None = None


@dataclass(frozen=True)
class Failed:
    """Why a task has no result."""

    message: str


def key_of(function: Function, arguments: Mapping[str, Any]) -> str:
    """Give the name under which a task's result is kept."""
    text = json.dumps([LAYOUT, __version__, function.__name__, arguments], sort_keys=True, allow_nan=False)
    return f"{function.__name__}-{hashlib.sha256(text.encode()).hexdigest()[:40]}"


def computed(
    store: Store,
    function: Function,
    tasks: Mapping[str, Mapping[str, Any]],
    client: Any,  # noqa: ANN401 - distributed is imported where it is needed
    progress: Progress,
) -> dict[str, Arrays | Failed]:
    """Give the result of each task, from the store where it was computed before.

    Parameters
    ----------
    store
        Where results are kept.
    function
        What each task does.
    tasks
        By name, the arguments; JSON can hold them.
    client
        From :func:`workers_of`; None for this process.
    progress
        Told how many are done.

    Returns
    -------
    dict
        In the order of the names.
    """
    keys = {name: key_of(function, tasks[name]) for name in sorted(tasks)}
    there = set(store.names(TASKS))
    missing = [name for name in keys if f"{keys[name]}.npz" not in there]
    failed: dict[str, Failed] = {}
    done = _in_process if client is None else _on_cluster
    what = function.__name__.replace("_", " ")
    for number, (name, message) in enumerate(done(store, function, tasks, keys, missing, client), start=1):
        if message:
            failed[name] = Failed(message)
        progress(f"{what}: {number} of {len(missing)}")
    return {name: failed[name] if name in failed else _kept(store, keys[name]) for name in keys}


_Done = Iterator[tuple[str, str]]
"""Names as they are done, each with why there is no result, or nothing."""


def _in_process(
    store: Store,
    function: Function,
    tasks: Mapping[str, Mapping[str, Any]],
    keys: Mapping[str, str],
    missing: Sequence[str],
    _: Any,  # noqa: ANN401
) -> _Done:
    for name in missing:
        try:
            yield name, done_at(store.url, keys[name], function, tasks[name])
        except Exception as error:  # one motor's failure is a line, not the fleet's end
            yield name, f"{type(error).__name__}: {error}"


def _on_cluster(
    store: Store,
    function: Function,
    tasks: Mapping[str, Mapping[str, Any]],
    keys: Mapping[str, str],
    missing: Sequence[str],
    client: Any,  # noqa: ANN401
) -> _Done:
    url = store.absolute
    names = {keys[name]: name for name in missing}
    calls = {key: (url, key, function, dict(tasks[name])) for key, name in names.items()}
    for key, complaint, error in outcomes(client, done_at, calls):
        yield names[key], complaint if error is None else f"{type(error).__name__}: {error}"


def done_at(url: str, key: str, function: Function, arguments: Mapping[str, Any]) -> str:
    """Do a task where a worker runs, and keep its result.

    Returns
    -------
    str
        What it complains of, or nothing.
    """
    import scipy.linalg  # noqa: F401 - libraries are limited that are there: numpy's and scipy's own
    from threadpoolctl import threadpool_limits

    store = Store(url)
    try:
        # More threads would only wait for each other, and their sums would depend on how many there are.
        with threadpool_limits(1, user_api="blas"):
            arrays = function(store, **arguments)
    except (InputError, CheckFailed) as error:
        return str(error)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # type: ignore[arg-type]
    store.write(f"{TASKS}/{key}.npz", buffer.getvalue())
    return ""


def _kept(store: Store, key: str) -> Arrays | Failed:
    try:
        with np.load(io.BytesIO(store.read(f"{TASKS}/{key}.npz")), allow_pickle=False) as arrays:
            return {name: np.asarray(arrays[name]) for name in arrays.files}
    except (ValueError, OSError, KeyError, zipfile.BadZipFile) as error:
        return Failed(f"{TASKS}/{key}.npz cannot be read: {error}; remove it, and it is computed anew")


@contextmanager
def workers_of(store: Store, workers: Workers) -> Iterator[Any]:
    """Give a Dask client, or None where this process does all.

    Raises
    ------
    InputError
        When the scheduler does not answer, or has no workers, or workers would not see what is in the store.
    """
    if workers.scheduler is None and workers.jobs == 1:
        yield None
        return
    if store.of_one_process:
        raise InputError("no other process sees it; expected another store, or --jobs 1", file=store.url)
    distributed = _distributed()

    if workers.scheduler is not None:
        try:
            client = distributed.Client(workers.scheduler, timeout=CONNECT_S)
        except (OSError, ValueError) as error:
            raise InputError(f"no scheduler answers at {workers.scheduler}: {error}", place="--scheduler") from error
        with client:
            try:
                client.wait_for_workers(1, timeout=CONNECT_S)
            except TimeoutError as error:
                raise InputError(f"{workers.scheduler} has no workers", place="--scheduler") from error
            yield client
        return
    with (
        distributed.LocalCluster(
            n_workers=workers.jobs, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def _distributed() -> Any:  # noqa: ANN401 - it has no types
    """Slow to import: only where there are workers."""
    return import_module("distributed")
