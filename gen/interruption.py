"""Ctrl-C and SIGTERM where work ends in order, with what there is so far, instead of being cut off."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

EXIT_STATUS = 130
"""Exit status of a command that was interrupted and kept what it had."""


@contextmanager
def interruption() -> Iterator[threading.Event]:
    """Give an event that Ctrl-C or SIGTERM sets; neither interrupts anything else meanwhile."""
    event = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield event
        return
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda *_: event.set()) for number in numbers]
    try:
        yield event
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
