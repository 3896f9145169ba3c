"""An interrupt that comes where a file is half made waits for the moment after."""

from __future__ import annotations

import os
import signal
import tempfile
from pathlib import Path
from typing import NoReturn

import pytest

from gen.files import scratch
from gen.interruption import interrupts_wait


def _raise(number: int, _: object) -> NoReturn:
    raise KeyboardInterrupt(number)


@pytest.fixture(params=[signal.SIGINT, signal.SIGTERM])
def number(request: pytest.FixtureRequest) -> signal.Signals:
    return signal.Signals(request.param)


def test_it_waits_and_then_does_what_it_would_have_done(number: signal.Signals) -> None:
    before, went_on = signal.signal(number, _raise), False
    try:
        with pytest.raises(KeyboardInterrupt) as caught, interrupts_wait():
            os.kill(os.getpid(), number)
            went_on = True
        assert went_on
        assert caught.value.args == (number,)
        assert signal.getsignal(number) is _raise
    finally:
        signal.signal(number, before)


def test_python_s_own_trial_of_the_scratch_place_leaves_no_file(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    opened: list[Path] = []
    open_ = os.open

    def interrupted(path: str, *arguments: int, **named: int) -> int:
        descriptor = open_(path, *arguments, **named)
        opened.append(Path(path))
        os.kill(os.getpid(), number)  # between the file's creation and the block that removes it
        return descriptor

    before = signal.signal(number, _raise)
    try:
        monkeypatch.setattr(os, "open", interrupted)
        with pytest.raises(KeyboardInterrupt), scratch("gen-"):
            pytest.fail("the interrupt is lost")
    finally:
        monkeypatch.undo()
        signal.signal(number, before)
    assert [path.parent for path in opened] == [tmp_path]
    assert list(tmp_path.iterdir()) == []
