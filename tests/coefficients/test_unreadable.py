"""A file that cannot be read is told of in one line, with the system's own words where it has some."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from gen.coefficients import load
from gen.errors import InputError


@pytest.mark.parametrize(
    ("error", "words"),
    [(OSError(errno.EIO, os.strerror(errno.EIO)), os.strerror(errno.EIO)), (OSError("odd"), "odd")],
)
def test_what_the_system_says_is_said(error: OSError, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def read_bytes(self: Path) -> bytes:
        raise error

    monkeypatch.setattr(Path, "read_bytes", read_bytes)
    with pytest.raises(InputError) as caught:
        load(Path("coeffs.json"))
    assert str(caught.value).endswith(f"cannot be read: {words}")
