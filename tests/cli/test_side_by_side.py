"""Work that is shared with a copy of the process: the same results, the same errors, nothing left behind."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
from functools import partial

import numpy as np
import pytest

from gen import side_by_side as module
from gen.side_by_side import has_help, of_two_kinds, side_by_side

PARENT = os.getpid()


@pytest.fixture(params=["with help", "without"])
def help_or_none(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Whatever the machine has: two processors, or one."""
    helped = bool(request.param == "with help")
    if helped and sys.platform != "linux":
        pytest.skip("no process is copied here")
    if sys.platform == "linux":
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1} if helped else {0})
    assert has_help() == helped
    return helped


def _slow(number: int) -> tuple[int, int]:
    time.sleep(0.05)
    return number, os.getpid()


def test_each_task_is_done_once_and_in_its_place(help_or_none: bool) -> None:
    found = side_by_side([partial(_slow, number) for number in range(9)])
    assert [number for number, _ in found] == list(range(9))
    assert len({process for _, process in found}) == (2 if help_or_none else 1)
    assert not multiprocessing.active_children()


def test_large_results_of_both_come_back(help_or_none: bool) -> None:
    found = side_by_side([partial(np.full, 1_000_000, float(number)) for number in range(6)])
    assert [one.size for one in found] == [1_000_000] * 6
    assert [one[-1] for one in found] == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


def _fails(number: int) -> int:
    time.sleep(0.02 * (5 - number))  # the later one fails first
    if number >= 2:
        raise ValueError(f"task {number}")
    return number


def test_the_first_error_of_all_is_raised_whoever_came_to_it(help_or_none: bool) -> None:
    for _ in range(5):
        with pytest.raises(ValueError, match=r"^task 2$"):
            side_by_side([partial(_fails, number) for number in range(5)])
    assert not multiprocessing.active_children()
    assert has_help() == help_or_none


def _dies_in_the_copy() -> str:
    if os.getpid() != PARENT:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.1)
    return "done"


def test_what_a_killed_helper_owed_is_done_all_the_same(help_or_none: bool) -> None:
    assert side_by_side([_dies_in_the_copy] * 4) == ["done"] * 4


def test_two_kinds_stay_apart(help_or_none: bool) -> None:
    words, numbers = of_two_kinds([lambda: "a", lambda: "b"], [lambda: 1])
    assert (words, numbers) == (["a", "b"], [1])
    assert of_two_kinds([], [lambda: 1]) == ([], [1])


def _inner() -> list[int]:
    assert not has_help()
    return side_by_side([os.getpid, os.getpid])


def test_shared_work_is_not_shared_again(help_or_none: bool) -> None:
    for first, second in side_by_side([_inner] * 4):
        assert first == second


def test_a_thread_of_others_shares_nothing(help_or_none: bool) -> None:
    seen: list[bool] = []
    thread = threading.Thread(target=lambda: seen.append(has_help()))
    thread.start()
    thread.join()
    assert seen == [False]


@pytest.mark.parametrize("help_or_none", ["with help"], indirect=True)
def test_an_interrupt_ends_the_helper_at_once(help_or_none: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    helpers: list[int] = []

    def interrupted(_: object) -> dict[int, object]:
        helpers.extend(child.pid or 0 for child in multiprocessing.active_children())
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "_heard", interrupted)
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        side_by_side([partial(_sleeps_in_the_copy, 60.0)] * 2)
    assert time.monotonic() - begun < 10.0
    assert helpers
    assert not multiprocessing.active_children()
    assert has_help()


@pytest.mark.parametrize("help_or_none", ["with help"], indirect=True)
def test_an_interrupt_in_the_moment_in_which_a_copy_is_made_is_not_lost(
    help_or_none: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is raised in a hook of the fork itself Python prints and forgets: the command would go on."""
    told: list[object] = []
    monkeypatch.setattr("sys.unraisablehook", told.append)
    monkeypatch.setattr(_Fork, "interrupts", True)
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        side_by_side([partial(_sleeps_in_the_copy, 60.0)] * 2)
    assert time.monotonic() - begun < 10.0
    assert told == []
    assert not multiprocessing.active_children()
    assert has_help()


class _Fork:
    """A hook stays for ever, so it asks whether it is wanted."""

    interrupts = False

    @classmethod
    def made(cls) -> None:
        if cls.interrupts:
            cls.interrupts = False
            os.kill(os.getpid(), signal.SIGINT)


os.register_at_fork(after_in_parent=_Fork.made)


def _sleeps_in_the_copy(seconds: float) -> None:
    if os.getpid() != PARENT:
        time.sleep(seconds)
    time.sleep(0.2)
