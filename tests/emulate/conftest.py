from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gen.avr.compile import ArduinoCore, build_elf
from gen.emulate.devices import DeviceMega

SOURCES = Path(__file__).parent / "firmware"

OpenBoard = Callable[..., DeviceMega]


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("emulate-cache")


@pytest.fixture(scope="session")
def core(cache: Path) -> ArduinoCore:
    return ArduinoCore(cache)


@pytest.fixture(scope="session")
def open_board(cache: Path, core: ArduinoCore, tmp_path_factory: pytest.TempPathFactory) -> OpenBoard:
    """Build one file of firmware/ against the Arduino core and open it, not yet started."""

    def build(name: str, *defines: str) -> DeviceMega:
        out = tmp_path_factory.mktemp("firmware") / f"{name}.elf"
        elf = build_elf([SOURCES / name], [], out, core=core, defines=defines)
        return DeviceMega(elf, cache)

    return build
