"""Processor time and memory of a command in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.rivals.growth.measure import processor_s
from gen.errors import CheckFailed

ROOT = Path(__file__).parents[3]
TRIES = 3
"""Of each process; the least counts."""
LAUNCHER = """
import os, sys
nowhere = [(os.POSIX_SPAWN_OPEN, number, os.devnull, os.O_WRONLY, 0) for number in (1, 2)]
pid = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ, file_actions=nowhere)
_, status, usage = os.wait4(pid, 0)
print(os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, usage.ru_maxrss)
"""
"""Starts a process from a small one: the most memory of a process counts what its parent held when it was started."""


def process(command: Sequence[str], tries: int = TRIES) -> tuple[float, float]:
    """Run a process: its least processor time, s, and the most memory that it held, MB.

    Raises
    ------
    CheckFailed
        When it fails.
    """
    least, most = float("inf"), 0.0
    for _ in range(tries):
        done = subprocess.run(
            [sys.executable, "-S", "-c", LAUNCHER, *command], capture_output=True, text=True, check=True, cwd=ROOT
        )
        status, seconds, kilobytes = done.stdout.split()
        if int(status):
            raise CheckFailed(f"{' '.join(command)} ends with {status}")
        least, most = min(least, float(seconds)), max(most, int(kilobytes) / 1024)
    return least, most


def taken(work: Callable[[], object]) -> float:
    """Processor time of this process and of those that it started, s."""
    begun = processor_s()
    work()
    return processor_s() - begun
