"""Work in counts, which no machine's speed changes: a test asserts these where it would look at a clock otherwise."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

OWN = str(Path(__file__).parent.parent / "gen")
HANGS_S = 1200.0
"""Whatever is waited for comes long before, on any machine; what takes longer hangs."""


def lines(work: Callable[[], object]) -> int:
    """Count the lines of `gen` that are executed while something works; every turn of a loop counts again."""
    count = 0

    def inside(_frame: FrameType, event: str, _value: Any) -> Any:  # noqa: ANN401
        nonlocal count
        count += event == "line"
        return inside

    def entered(frame: FrameType, _event: str, _value: Any) -> Any:  # noqa: ANN401
        return inside if frame.f_code.co_filename.startswith(OWN) else None

    before = sys.gettrace()
    sys.settrace(entered)
    try:
        work()
    finally:
        sys.settrace(before)
    return count
