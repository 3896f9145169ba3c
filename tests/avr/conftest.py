from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gen.avr.compile import ArduinoCore, build_elf
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedChip

SOURCES = Path(__file__).parent / "firmware"

Emulate = Callable[..., EmulatedChip]


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("avr-cache")


@pytest.fixture(scope="session")
def core(cache: Path) -> ArduinoCore:
    return ArduinoCore(cache)


@pytest.fixture
def emulate(cache: Path, tmp_path: Path) -> Emulate:
    """Build one file of firmware/ (or a text of its own) and open it on the emulator."""

    def build(name: str, *, text: str | None = None, core: ArduinoCore | None = None) -> EmulatedChip:
        source = SOURCES / name
        if text is not None:
            source = tmp_path / name
            source.write_text(text, encoding="utf-8")
        # -O2: single instructions are timed between two marks, and -Os puts jumps of its own between them.
        elf = build_elf([source], [MAILBOX_FOLDER], tmp_path / f"{name}.elf", core=core, optimisation="-O2")
        return EmulatedChip(elf, cache)

    return build
