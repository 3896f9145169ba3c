"""Tasks: the same with any number of workers, none twice, and a line for what fails."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gen.commands.fleet.options import usual_jobs
from gen.errors import InputError
from gen.fleet.folder.store import TASKS, Store
from gen.fleet.tasks import cluster, work
from gen.fleet.tasks.work import Arrays, Failed, Workers, computed, key_of, workers_of
from tests.fleet import tasks


def silent(_: str) -> None:
    pass


def bits(found: dict[str, Arrays | Failed]) -> dict[str, Any]:
    made = {}
    for name, result in found.items():
        assert not isinstance(result, Failed), result
        made[name] = {key: (values.dtype.str, values.shape, values.tobytes()) for key, values in result.items()}
    return made


def test_as_many_processes_as_asked_for_or_as_this_one_may_use() -> None:
    assert usual_jobs(3) == 3
    if hasattr(os, "sched_getaffinity"):
        assert usual_jobs(None) == len(os.sched_getaffinity(0))
    assert usual_jobs(None) >= 1


def test_nothing_is_computed_twice_and_what_is_there_is_taken(tmp_path: Path) -> None:
    store, marks = Store(str(tmp_path / "store")), tmp_path / "marks"
    marks.mkdir()
    some = {f"t{seed}": {"seed": seed, "marks": str(marks)} for seed in range(3)}
    first = computed(store, tasks.random_sums, some, None, silent)
    more = some | {"t9": {"seed": 9, "marks": str(marks)}}
    second = computed(store, tasks.random_sums, more, None, silent)
    assert len(list(marks.iterdir())) == 4
    assert bits(first) == {name: value for name, value in bits(second).items() if name in first}
    assert list(second) == sorted(more)


def test_a_complaint_is_a_line_and_tried_again_next_time(tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    found = computed(store, tasks.refused, {str(seed): {"seed": seed} for seed in range(4)}, None, silent)
    assert found["1"] == Failed("seed 1 is odd")
    assert not isinstance(found["2"], Failed)
    assert len(store.names(TASKS)) == 2


def test_a_result_that_was_damaged_is_told_by_name(tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    computed(store, tasks.refused, {"a": {"seed": 0}}, None, silent)
    store.write(f"{TASKS}/{store.names(TASKS)[0]}", b"PK half")
    found = computed(store, tasks.refused, {"a": {"seed": 0}}, None, silent)["a"]
    assert isinstance(found, Failed)
    assert "remove it" in found.message


def test_other_arguments_have_another_key() -> None:
    one = key_of(tasks.refused, {"seed": 1, "b": [1.0]})
    assert one == key_of(tasks.refused, {"b": [1.0], "seed": 1})
    assert one != key_of(tasks.refused, {"seed": 1, "b": [1.0 + 2**-52]})
    assert one != key_of(tasks.random_sums, {"seed": 1, "b": [1.0]})


def test_two_workers_one_of_which_dies_give_the_same_bits_as_this_process(tmp_path: Path) -> None:
    alone, both = Store(str(tmp_path / "alone")), Store(str(tmp_path / "both"))
    marks = tmp_path / "marks"
    marks.mkdir()
    some = {f"t{seed}": {"seed": seed, "marks": str(marks)} for seed in range(6)}
    with workers_of(both, Workers(jobs=2)) as client:
        killed = computed(both, tasks.dies_once, some, client, silent)
        with workers_of(both, Workers(scheduler=client.scheduler.address)) as elsewhere:
            odd = computed(both, tasks.refused, {"1": {"seed": 1}}, elsewhere, silent)
    assert (marks / "died").exists()
    assert odd == {"1": Failed("seed 1 is odd")}
    assert bits(killed) == bits(computed(alone, tasks.dies_once, some, None, silent))
    assert alone.names(TASKS) == both.names(TASKS)


def hung(marks: Path) -> bool:
    """Whether the process of the worker that hung is still there."""
    try:
        os.kill(int((marks / "hung").read_text()), 0)
    except ProcessLookupError:
        return False
    return True


def test_a_task_that_hangs_is_done_by_another_worker_and_its_own_is_restarted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "LEAST_S", 2.0)
    alone, both = Store(str(tmp_path / "alone")), Store(str(tmp_path / "both"))
    some = {f"t{seed}": {"seed": seed, "marks": str(tmp_path)} for seed in range(6)}
    with workers_of(both, Workers(jobs=2)) as client:
        found = computed(both, tasks.hangs, some, client, silent)
        assert not hung(tmp_path)
        after = computed(both, tasks.refused, {str(seed): {"seed": 2 * seed} for seed in range(4)}, client, silent)
        assert len(client.nthreads()) == 2
    assert not any(isinstance(result, Failed) for result in after.values())
    assert bits(found) == bits(computed(alone, tasks.hangs, some, None, silent))


def test_a_task_that_hangs_wherever_it_is_costs_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "LEAST_S", 4.0)
    monkeypatch.setattr(cluster, "HOPELESS", 60.0)  # 24 s: beside other work a worker may take seconds to start a task
    store = Store(str(tmp_path / "store"))
    some = {f"t{seed}": {"seed": seed, "marks": str(tmp_path), "always": True} for seed in range(6)}
    with workers_of(store, Workers(jobs=2)) as client:
        found = computed(store, tasks.hangs, some, client, silent)
        assert not hung(tmp_path)
        assert computed(store, tasks.refused, {"1": {"seed": 1}}, client, silent) == {"1": Failed("seed 1 is odd")}
    lost = found.pop("t2")
    assert isinstance(lost, Failed)
    assert lost.message.startswith("TimeoutError: not done in ")
    assert len(bits(found)) == 5


def within(seconds: float, call: Callable[[], Any]) -> Any:  # noqa: ANN401
    """Give what a call gives or raises; fails where that takes longer."""
    came: list[Any] = []

    def caught() -> None:
        try:
            came.append(call())
        except Exception as error:
            came.append(error)

    thread = threading.Thread(target=caught, daemon=True)
    thread.start()
    thread.join(seconds)
    assert came, f"still waiting after {seconds:g} s"
    return came[0]


def test_a_first_task_that_hangs_costs_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As what has one task only: nothing says how long it may take."""
    monkeypatch.setattr(cluster, "UNKNOWN_S", 0.5)
    monkeypatch.setattr(cluster, "LEAST_S", 2.0)
    monkeypatch.setattr(cluster, "HOPELESS", 20.0)
    store = Store(str(tmp_path / "store"))
    only = {"t2": {"seed": 2, "marks": str(tmp_path), "always": True}}
    with workers_of(store, Workers(jobs=2)) as client:
        lost = within(100.0, lambda: computed(store, tasks.hangs, only, client, silent))["t2"]
        assert not hung(tmp_path)
    assert lost == Failed("TimeoutError: not done in 10 s, and neither was any other")


def test_a_scheduler_without_workers_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At once where there is none, and later where none is left."""
    monkeypatch.setattr(work, "CONNECT_S", 5.0)
    monkeypatch.setattr(cluster, "LEAST_S", 1.0)
    store = Store(str(tmp_path / "store"))
    with work._distributed().LocalCluster(n_workers=0, processes=False, dashboard_address=None) as empty:
        with (
            pytest.raises(InputError, match=r"--scheduler: \S+ has no workers"),
            workers_of(store, Workers(scheduler=empty.scheduler_address)),
        ):
            pass
        with work._distributed().Client(empty) as client:
            left = within(60.0, lambda: computed(store, tasks.refused, {"1": {"seed": 1}}, client, silent))
    assert isinstance(left, InputError)
    assert "no worker is left" in str(left)


def test_workers_elsewhere_do_not_see_this_processs_memory() -> None:
    with pytest.raises(InputError, match="no other process"), workers_of(Store("memory://x"), Workers(jobs=2)):
        pass


def test_a_scheduler_that_is_not_there_is_told() -> None:
    with pytest.raises(InputError, match="--scheduler"), workers_of(Store("/tmp"), Workers(scheduler="nonsense://")):
        pass
