"""The pseudo-terminal carries every byte, both ways."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest
import serial

from gen.emulate.terminal import PseudoTerminal
from gen.errors import InputError
from tests.work import HANGS_S


def test_more_than_the_buffer_holds_arrives_whole(tmp_path: Path) -> None:
    data = bytes(range(256)) * 200
    with PseudoTerminal(tmp_path / "port") as terminal:
        assert not terminal.is_open
        terminal.write(b"nobody hears this")
        got = bytearray()
        ready = threading.Event()

        def reader() -> None:
            with serial.Serial(str(tmp_path / "port"), 115200, timeout=1.0) as line:
                ready.set()
                line.write(b"hello\n")
                while len(got) < len(data):
                    got.extend(line.read(1000))
                    time.sleep(0.001)

        thread = threading.Thread(target=reader)
        thread.start()
        terminal.wait()
        assert ready.wait(HANGS_S)
        terminal.write(data)
        thread.join(timeout=HANGS_S)
        assert bytes(got) == data
        assert terminal.read() == b"hello\n"
    assert not (tmp_path / "port").is_symlink()


def test_a_file_in_the_links_place_is_left_alone(tmp_path: Path) -> None:
    link = tmp_path / "port"
    link.write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be made"):
        PseudoTerminal(link)
    assert link.read_text(encoding="utf-8") == "mine"
