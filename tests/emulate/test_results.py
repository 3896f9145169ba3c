"""When the LED told of an alarm: of that one, and of that time."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from gen.coefficients.document import Document
from gen.emulate.board import Board
from gen.emulate.results import results_of
from gen.emulate.session import Session
from gen.record import Part
from tests.emulate.test_led import HEALTHY, alarm, observe


def test_an_alarm_that_comes_again_was_told_again() -> None:
    """The second rule is raised, reset, and raised again: each time the LED blinks two, after the row that says so."""
    edges, end_s, starts = observe(HEALTHY, alarm(2, 3), HEALTHY, alarm(2, 3))
    first, second = starts[1], starts[3]
    times = [0.25 * k for k in range(round(4 * end_s))]
    raised = [first - 0.2 <= t < starts[2] or t >= second - 0.2 for t in times]
    rows = [f"{t:.3f},{2 if alarm_on else 0}" for t, alarm_on in zip(times, raised, strict=True)]
    rules = [SimpleNamespace(name="cool"), SimpleNamespace(name="hot")]
    document = SimpleNamespace(alarms=rules, wiring=None, protection=[])
    recorder = SimpleNamespace(parts=[Part(("time_s", "alarms"), rows=rows)])
    found = results_of(
        cast(Document, document),
        cast(Board, SimpleNamespace(led=edges)),
        cast(Session, SimpleNamespace(seconds=end_s, recorder=recorder)),
    )
    assert [one.rule for one in found.alarms] == ["hot", "hot"]
    assert [one.led_s for one in found.alarms] == pytest.approx([first, second], abs=0.07)
