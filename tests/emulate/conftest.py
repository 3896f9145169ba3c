from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gen.avr.chip import BOARDS
from gen.avr.compile import ArduinoCore, build_elf
from gen.coefficients.wiring import BoardName
from gen.emulate.wiring.devices import DeviceBoard

SOURCES = Path(__file__).parent / "firmware"

OpenBoard = Callable[..., DeviceBoard]


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("emulate-cache")


@pytest.fixture(scope="session")
def core(cache: Path) -> ArduinoCore:
    return ArduinoCore(cache)


@pytest.fixture(scope="session")
def open_board(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> OpenBoard:
    """Build one file of firmware/ against the Arduino core and open it, not yet started."""

    def build(name: str, *defines: str, board: BoardName = "mega") -> DeviceBoard:
        out = tmp_path_factory.mktemp("firmware") / f"{name}.elf"
        elf = build_elf(
            [SOURCES / name], [], out, core=ArduinoCore(cache, chip=BOARDS[board]), chip=BOARDS[board], defines=defines
        )
        return DeviceBoard(elf, cache, board)

    return build
