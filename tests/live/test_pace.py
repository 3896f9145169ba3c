"""Two sources abreast: one pace, and neither far ahead of the other."""

from __future__ import annotations

from pathlib import Path

import pytest

from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.live.pace import Pace
from tests.live.serving import wait_until
from tests.live.test_sources import FAULT, emulated, quick

__all__ = ["quick"]  # the fixture


def test_who_is_ahead_waits_until_the_other_has_come_or_gone() -> None:
    pace = Pace(4.0)
    first, second = pace.join(), pace.join()
    pace.reach(first, 1.0)
    assert not pace.too_far(first)
    pace.reach(first, 1.25)
    assert pace.too_far(first)
    assert not pace.too_far(second)
    pace.reach(second, 0.25)
    assert not pace.too_far(first)
    pace.reach(first, 15.0)
    pace.speed = 1000.0  # a fiftieth of a second here
    assert not pace.too_far(first)
    pace.speed = 1.0
    assert pace.too_far(first)
    pace.leave(second)
    assert not pace.too_far(first)
    pace.reach(second, 50.0)
    assert not pace.too_far(first)


def test_two_boards_run_abreast_and_a_fault_is_one_s_own(quick: Coefficients, tmp_path: Path) -> None:
    pace = Pace(50.0)
    healthy, faulty = emulated(quick, tmp_path, pace), emulated(quick, tmp_path, pace, leads=False)
    assert "pace" in {control.name for control in healthy.controls()}
    assert {control.name for control in faulty.controls()} == {c.name for c in healthy.controls()} - {"pace"}
    with pytest.raises(InputError):
        faulty.change("pace", 10.0)
    assert not faulty.view.recorder.rows
    healthy.start()
    wait_until(lambda: pace.too_far(1))  # the other has not begun: this one waits
    faulty.start()
    try:
        for source in (healthy, faulty):
            wait_until(lambda source=source: source.view.recorder.rows > 2)  # type: ignore[misc]
            source.send(b"arm\n200\n")
        healthy.change("pace", 1000.0)
        faulty.change("fault", FAULT)
        wait_until(lambda: faulty.view.status()["alarms"] == ["bearing_warm"])
        healthy.stop()
        rows = faulty.view.recorder.rows
        wait_until(lambda: faulty.view.recorder.rows > rows + 400)  # nobody is waited for who has ended
    finally:
        for source in (healthy, faulty):
            source.stop()
    assert healthy.view.status()["alarms"] == []
    assert "motor_fault" in faulty.view.text()
    assert "motor_fault" not in healthy.view.text()
