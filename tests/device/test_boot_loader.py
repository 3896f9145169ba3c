"""The sketch behind the Mega's own boot loader, the one that Arduino's core ships (stk500v2)."""

from __future__ import annotations

import subprocess

import pytest

from gen import toolchain
from tests.device.board import Board, warm
from tests.device.conftest import Open

LED = 13


@pytest.fixture(scope="module")
def boot_loader(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    image = tmp_path_factory.mktemp("boot-loader") / "image.bin"
    told = toolchain.arduino_core() / "bootloaders" / "stk500v2" / "stk500boot_v2_mega2560.hex"
    copy = [str(toolchain.program("avr-objcopy")), "-I", "ihex", "-O", "binary", str(told), str(image)]
    subprocess.run(copy, check=True)
    return image.read_bytes()


@pytest.fixture
def board(power_up: Open, boot_loader: bytes) -> Board:
    """Started, driven for a while, without a copy in EEPROM yet."""
    board = warm(power_up("watched_brush"))
    board.add_boot_loader(boot_loader)
    board.started()
    board.drive(255)
    board.hear(5.0)
    return board


def seconds_until_main(board: Board) -> float:
    begun = board.seconds
    board.run_to("main", 3 * 16_000_000)
    return board.seconds - begun


def test_it_waits_for_a_second_and_what_ram_kept_is_still_there(board: Board) -> None:
    board.press_reset()
    board.run_seconds(0.1)
    assert board.pins.level(LED)
    assert not board.pins.is_output(4)
    assert 0.7 < seconds_until_main(board) < 1.2
    said = board.started()
    assert said.comments["reset"] == "unknown"
    assert any(event.endswith("start from RAM") for event in said.events)


def test_after_the_watchdog_it_waits_too_and_hides_the_cause(board: Board) -> None:
    """It means to go on at once; but EIND is 1 as the start-up code left it, so its call of address 0 goes to 0x20000.

    From there on flash is empty, which runs through to the boot loader once more: the cause is cleared by then.
    """
    board.write("tick_due", board.read("tick_due") + 3000)  # no sample for 3 s
    resets = board.resets
    board.run_until(lambda: board.resets > resets, 3.0, step_s=0.01)
    assert 0.7 < seconds_until_main(board) < 1.2
    said = board.started()
    assert said.comments["reset"] == "unknown"
    assert any(event.endswith("start from RAM") for event in said.events)


def test_a_boot_loader_that_does_not_fit_is_refused(power_up: Open) -> None:
    board = power_up("watched_brush")
    with pytest.raises(ValueError, match="does not fit at 0x3e000"):
        board.add_boot_loader(bytes(8193))
