"""Folders that go with what is done in them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from gen.files import scratch


def test_a_folder_goes_with_its_block(tmp_path: Path) -> None:
    with scratch("some-", tmp_path) as folder:
        assert folder.parent == tmp_path
        assert folder.name.startswith("some-")
        (folder / "file").touch()
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_as_it_is_made_leaves_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = os.mkdir

    def interrupted(*given: Any, **named: Any) -> None:  # noqa: ANN401
        real(*given, **named)
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "mkdir", interrupted)
    with pytest.raises(KeyboardInterrupt), scratch("some-", tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []
