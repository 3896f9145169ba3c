"""Folders that go with what is done in them."""

from __future__ import annotations

import os
import signal
import tempfile
from pathlib import Path

import pytest

from gen.files import scratch


def test_a_folder_goes_with_its_block(tmp_path: Path) -> None:
    with scratch("some-", tmp_path) as folder:
        assert folder.parent == tmp_path
        assert folder.name.startswith("some-")
        (folder / "file").touch()
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_between_the_folder_and_who_removes_it_leaves_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = tempfile.mkdtemp

    def interrupted(*given: str | None) -> str:
        made = real(*given)
        os.kill(os.getpid(), signal.SIGINT)
        return made

    monkeypatch.setattr(tempfile, "mkdtemp", interrupted)
    with pytest.raises(KeyboardInterrupt), scratch("some-", tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []
